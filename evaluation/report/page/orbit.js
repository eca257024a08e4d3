// Pointer, wheel and keys of the 3D view.
const kMaxPitch = 1.55; // just short of straight down, where yaw has no meaning

function zoom_by(factor) {
  const { orbit, size } = motion_state;
  orbit.distance = Math.min(Math.max(orbit.distance * factor, 0.02 * size), 20 * size);
}

function turn_by(dx, dy) {
  const { orbit } = motion_state;
  orbit.yaw -= dx * 0.008;
  orbit.pitch = Math.min(Math.max(orbit.pitch + dy * 0.008, -kMaxPitch), kMaxPitch);
}

// Moves what is looked at with the pointer, in the plane of the screen.
function shift_by(dx, dy) {
  const { orbit } = motion_state;
  const view = orbit_view(orbit, motion_canvas.clientWidth, motion_canvas.clientHeight), scale = -orbit.distance / view.focal;
  orbit.target = v_add(orbit.target, v_add(v_scale(view.right, dx * scale), v_scale(view.down, dy * scale)));
}

// Zooms so that what is pointed at stays there, unless something is followed.
function zoom_at(event, factor) {
  const before = motion_state.orbit.distance;
  zoom_by(factor);
  const rest = 1 - before / motion_state.orbit.distance;
  if (motion_state.follow === "") shift_by((event.offsetX - motion_canvas.clientWidth / 2) * rest, (event.offsetY - motion_canvas.clientHeight / 2) * rest);
}

// One pointer turns (shifts with shift or another button), two pinch and shift together.
function drag(pointers, event) {
  const before = pointers.get(event.pointerId), other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
  const now = { x: event.offsetX, y: event.offsetY }, dx = now.x - before.x, dy = now.y - before.y;
  if (other) {
    const gap = (p) => Math.max(1, Math.hypot(p.x - other.x, p.y - other.y));
    zoom_by(gap(before) / gap(now));
    shift_by(dx / 2, dy / 2);
  } else if (event.shiftKey || event.buttons & 6) shift_by(dx, dy);
  else turn_by(dx, dy);
  pointers.set(event.pointerId, now);
  motion_state.touched = true;
  draw_motion();
}

// The body pointed at, by its name; the nearest where several are.
function name_under(event) {
  const body = motion_state.drawn.findLast((b) => outline_holds(b.outline, event.offsetX, event.offsetY));
  const note = by_id("space-note");
  note.hidden = !body;
  if (!body) return;
  const run = motion_runs().find((r) => r.variant === body.label), iou = run && figures_at(run, body.object)("iou3d");
  note.textContent = `${body.object} · ${body.truth ? "truth" : body.label}${iou ? ` · IoU ${format_figure(iou)}` : ""}`;
  note.style.left = `${Math.min(event.offsetX + 14, motion_canvas.clientWidth - note.offsetWidth - 4)}px`;
  note.style.top = `${Math.max(4, event.offsetY - 34)}px`;
}

function on_key(event) {
  const turns = { ArrowLeft: [15, 0], ArrowRight: [-15, 0], ArrowUp: [0, 15], ArrowDown: [0, -15] };
  if (turns[event.key]) turn_by(...turns[event.key]);
  else if (event.key === "+" || event.key === "-") zoom_by(event.key === "+" ? 0.85 : 1 / 0.85);
  else return;
  event.preventDefault();
  motion_state.touched = true;
  draw_motion();
}

function is_in_sight(node) {
  const { top, bottom, height } = node.getBoundingClientRect();
  return height > 0 && bottom > 0 && top < window.innerHeight;
}

// Arrows and the blank bar move the time, unless something else has the keys. The blank bar scrolls as ever where
// the player is out of sight.
function on_time_key(event) {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key], at = document.activeElement;
  if (!motion_state.scene || by_id("viewer").open || event.ctrlKey || event.metaKey || event.altKey) return;
  const is_free = !at || at === document.body || at === by_id("space-play") || (at.tagName === "BUTTON" && step); // a blank presses a button
  if (!is_free) return;
  if (step) (pause_motion(), show_motion_index(motion_state.index + step));
  else if (event.key === " " && at !== by_id("space-play") && is_in_sight(by_id("space-play"))) motion_state.playing ? pause_motion() : play_motion();
  else return;
  event.preventDefault();
}

function start_orbit() {
  const pointers = new Map(), drop = (event) => pointers.delete(event.pointerId);
  motion_canvas.addEventListener("pointerdown", (event) => {
    motion_canvas.setPointerCapture(event.pointerId);
    if (pointers.size < 2) pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    by_id("space-note").hidden = true;
  });
  motion_canvas.addEventListener("pointermove", (event) => (pointers.has(event.pointerId) ? drag(pointers, event) : name_under(event)));
  for (const end of ["pointerup", "pointercancel"]) motion_canvas.addEventListener(end, drop);
  motion_canvas.addEventListener("pointerleave", () => { by_id("space-note").hidden = true; });
  motion_canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  motion_canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * [1, 16, 400][event.deltaMode];
    zoom_at(event, Math.exp(Math.min(Math.max(pixels, -240), 240) * 0.0012));
    motion_state.touched = true;
    draw_motion();
  }, { passive: false });
  motion_canvas.addEventListener("keydown", on_key);
}

// Looks at one thing, which stays in the middle; with "" at the whole scene.
function follow(name) {
  motion_state.follow = name;
  if (name === "") reset_orbit();
  else if (name === "camera") motion_state.orbit.distance = 0.6 * motion_state.size;
  else {
    const track = motion_truths()[0].objects.find((o) => `object ${o.object}` === name);
    motion_state.orbit.distance = 9 * Math.max(...track.semi_axes_m.find(Boolean));
  }
  draw_motion();
}

function draw_motion_chips() {
  const scene = motion_state.scene, shown = distinct(motion.runs.filter((run) => run.scene === scene).map((run) => run.variant));
  chips(by_id("space-variants"), "in image and 3D", shown, motion_state.variants, { many: true, color: variant_color,
    change: (chosen) => { Object.assign(motion_state, { variants: new Set(chosen), moved: true }); draw_motion(); draw_readout(); note_address(); } });
}

function start_motion() {
  painter = make_painter(motion_canvas);
  by_id("space-no-webgl").hidden = painter instanceof Painter;
  for (const [id, state] of [["space-cloud", "cloud"], ["space-errors", "by_error"], ["space-sigmas", "sigmas"]])
    by_id(id).addEventListener("change", (event) => { motion_state[state] = event.target.checked; draw_motion(); draw_error_scale(); });
  by_id("space-worst").addEventListener("click", () => show_worst());
  by_id("space-top").addEventListener("click", () => { Object.assign(motion_state.orbit, { pitch: kMaxPitch }); motion_state.touched = true; draw_motion(); });
  film_image.addEventListener("load", () => draw_motion());
  document.addEventListener("keydown", on_time_key);
  start_orbit();
  by_id("space-time").addEventListener("input", (event) => { pause_motion(); show_motion_index(Number(event.target.value)); });
  by_id("space-play").addEventListener("click", () => (motion_state.playing ? pause_motion() : play_motion()));
  by_id("space-reset").addEventListener("click", () => { by_id("space-follow").value = ""; follow(""); });
  by_id("space-follow").addEventListener("change", (event) => follow(event.target.value));
  new ResizeObserver(() => {
    if (!motion_state.scene) return;
    if (!motion_state.touched && motion_state.follow === "") reset_orbit();
    draw_motion();
  }).observe(motion_canvas.parentElement);
}
