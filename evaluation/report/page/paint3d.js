// Paints the 3D view: `look` says what to paint and in which colours, `view` from where (space.js).
function path3d(context, view, points3d) {
  let last = null; // a segment goes on from the one before, or dashes would start anew
  context.beginPath();
  for (let i = 1; i < points3d.length; ++i) {
    const ends = points3d[i - 1] && points3d[i] && segment_on_canvas(view, points3d[i - 1], points3d[i]);
    if (!ends) continue;
    if (!last || last[0] !== ends[0][0] || last[1] !== ends[0][1]) context.moveTo(...ends[0]);
    context.lineTo(...(last = ends[1]));
  }
  context.stroke();
}

function with_style(context, style, paint) {
  context.save();
  context.setLineDash(style.dash ?? []);
  Object.assign(context, { lineCap: "round", lineJoin: "round", ...style.set });
  paint();
  context.restore();
}

function paint_floor(context, view, { floor, color }) {
  with_style(context, { set: { strokeStyle: color, lineWidth: 1 } }, () => {
    const { x, y, z, step } = floor;
    for (let at = x[0]; at <= x[1] + step / 2; at += step) path3d(context, view, [[at, y[0], z], [at, y[1], z]]);
    for (let at = y[0]; at <= y[1] + step / 2; at += step) path3d(context, view, [[x[0], at, z], [x[1], at, z]]);
  });
}

function paint_shadow(context, view, body, z, color) {
  const shape = footprint_of(body, z).map((p) => in_view(view, p));
  if (shape.some((p) => p[2] < view.near)) return;
  with_style(context, { set: { fillStyle: color, globalAlpha: 0.12 } }, () => {
    context.beginPath();
    for (const p of shape) context.lineTo(...on_canvas(view, p));
    context.fill();
  });
}

// A trajectory: strong up to now, faint after.
function paint_path(context, view, { points: list, color, dash, width }, index) {
  for (const [part, alpha] of [[list.slice(0, index + 1), 0.95], [list.slice(index), 0.3]])
    with_style(context, { dash, set: { strokeStyle: color, lineWidth: width, globalAlpha: alpha } }, () => path3d(context, view, part));
}

function paint_outline(context, { outline: { x, y, a, b, angle }, color, dash }, fill) {
  with_style(context, { dash, set: { strokeStyle: color, fillStyle: color, lineWidth: 1.8, globalAlpha: fill ?? 1 } }, () => {
    context.beginPath();
    context.ellipse(x, y, a, b, angle, 0, 2 * Math.PI);
    fill ? context.fill() : context.stroke();
  });
}

// Lightly filled, with the rings where the surface faces the eye; the others shine through.
function paint_ellipsoid(context, view, { ellipsoid, color, fill, ...body }) {
  paint_outline(context, { color, ...body }, fill);
  const rings = rings_of(view, ellipsoid);
  for (const [front, alpha] of [[false, 0.16], [true, 0.65]])
    with_style(context, { set: { strokeStyle: color, lineWidth: 1, globalAlpha: alpha } }, () => {
      for (const ring of rings.filter((r) => r.front === front)) path3d(context, view, [ring.from, ring.to]);
    });
}

// A camera as a pyramid along its z axis; `size` is how deep.
function paint_camera(context, view, { pose, color, dash, size }) {
  const [right, down, forward] = pose_axes(pose), eye = pose.slice(0, 3);
  const corner = (x, y) => v_add(eye, v_add(v_scale(forward, size), v_add(v_scale(right, 0.7 * x * size), v_scale(down, 0.5 * y * size))));
  const corners = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
  with_style(context, { dash, set: { strokeStyle: color, lineWidth: 1.5 } }, () => {
    path3d(context, view, [...corners, corners[0]]);
    for (const c of corners) path3d(context, view, [eye, c]);
  });
}

function paint_text(context, text, x, y, color, paper) {
  with_style(context, { set: { font: "12px system-ui, 'DejaVu Sans', sans-serif", textAlign: "center", fillStyle: color,
    strokeStyle: paper, lineWidth: 3 } }, () => {
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  });
}

// The world's axes in the lower left corner.
function paint_compass(context, view, height, color, paper) {
  const origin = [38, height - 38];
  [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((direction, i) => {
    const x = v_dot(view.right, direction), y = v_dot(view.down, direction);
    with_style(context, { set: { strokeStyle: color, lineWidth: 1.5 } }, () => {
      context.beginPath();
      context.moveTo(...origin);
      context.lineTo(origin[0] + 20 * x, origin[1] + 20 * y);
      context.stroke();
    });
    paint_text(context, "xyz"[i], origin[0] + 29 * x, origin[1] + 29 * y + 4, color, paper);
  });
}

// Everything; gives back the ellipsoids with their outlines, far ones first.
function paint_scene(context, view, look) {
  context.clearRect(0, 0, look.width, look.height);
  paint_floor(context, view, { floor: look.floor, color: look.colors.line });
  const bodies = look.bodies.map((body) => ({ ...body, outline: outline_of(view, body.ellipsoid) }))
    .filter((body) => body.outline).sort((a, b) => b.outline.depth - a.outline.depth);
  for (const body of bodies) paint_shadow(context, view, body.ellipsoid, look.floor.z, body.color);
  for (const path of look.paths) paint_path(context, view, path, look.index);
  for (const camera of look.cameras) paint_camera(context, view, camera);
  for (const body of bodies) paint_ellipsoid(context, view, body);
  for (const truth of [false, true]) for (const body of bodies.filter((b) => b.truth === truth)) paint_outline(context, body);
  for (const body of bodies.filter((b) => b.truth))
    paint_text(context, body.object, body.outline.x, body.outline.y - body.outline.a - 8, look.colors.ink, look.colors.paper);
  paint_compass(context, view, look.height, look.colors.soft, look.colors.paper);
  return bodies;
}
