// The camera's image at the slider's time, with the outlines of the true and estimated bodies drawn on it.
const scenery = JSON.parse(document.getElementById("scenery").textContent);
const film_canvas = by_id("film-canvas"), film_image = by_id("film-image"), film_state = { drawn: [] };

const film_frames = (scene) => scenery[scene]?.frames ?? [];

function nearest_frame(scene, stamp_ns) {
  const frames = film_frames(scene);
  return frames[nearest_index(frames.map((frame) => frame.stamp_ns), stamp_ns)];
}

// The camera's own view, as wide as the canvas; pixel centres lie at whole numbers.
function camera_view(scene, pose, width) {
  const { camera } = scenery[scene], [right, down, forward] = pose_axes(pose), scale = width / camera.width;
  return { eye: pose.slice(0, 3), right, down, forward, focal: camera.fx * scale, focal_y: camera.fy * scale,
    cx: (camera.cx + 0.5) * scale, cy: (camera.cy + 0.5) * scale, near: 0.01 };
}

// A dashed line of the truth is light on dark, so that it shows on any image.
function stroke_outline(context, outline, color, truth) {
  for (const [style, width, dash] of truth ? [["rgb(0 0 0 / 70%)", 4, []], ["#fff", 2, [6, 4]]] : [["rgb(0 0 0 / 45%)", 4, []], [color, 2.2, []]])
    with_style(context, { dash, set: { strokeStyle: style, lineWidth: width } }, () => {
      context.beginPath();
      for (const p of outline.points) context.lineTo(...p);
      context.closePath();
      context.stroke();
    });
}

// Draws a frame's outlines on a canvas over its image, which is as wide as `width`; gives back the bodies drawn.
function paint_film(canvas, width, scene, camera, bodies) {
  const ratio = window.devicePixelRatio || 1, height = (width * scenery[scene].camera.height) / scenery[scene].camera.width;
  Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  if (!camera || width === 0) return [];
  const context = canvas.getContext("2d"), view = camera_view(scene, camera, width);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const drawn = bodies.map((body) => ({ ...body, outline: outline_of(view, body) })).filter((body) => body.outline);
  for (const truth of [true, false])
    for (const body of drawn.filter((b) => b.truth === truth)) stroke_outline(context, body.outline, body.color, truth);
  return drawn;
}

function draw_film() {
  const { scene, index } = motion_state, frame = nearest_frame(scene, motion_stamps()[index]);
  by_id("film-view").hidden = !frame;
  if (!frame) return;
  const source = source_of(frame);
  if (film_image.src !== source) film_image.src = source;
  film_image.alt = `${scene}: frame ${frame.frame}`;
  by_id("film-note").textContent = `frame ${frame.frame}`;
  film_state.drawn = paint_film(film_canvas, film_image.clientWidth, scene, motion_truths()[0].camera[index], motion_bodies());
}
