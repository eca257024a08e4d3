// One time for image, 3D view and plots: what is shown of which runs, and the slider.
const motion = JSON.parse(document.getElementById("motion").textContent);
const motion_state = { scene: null, variants: new Set(), index: 0, follow: "", orbit: null, touched: false, playing: null, drawn: [],
  cloud: true, by_error: false, sigmas: false };
const motion_canvas = by_id("space"), motion_names = by_id("space-names");
let painter = null;

const motion_runs = () => motion.runs.filter((run) => run.scene === motion_state.scene && motion_state.variants.has(run.variant));
const motion_truths = () => distinct(motion.runs.filter((run) => run.scene === motion_state.scene).map((run) => run.truth)).map((i) => motion.truths[i]);
const motion_stamps = () => motion_truths()[0].stamps_ns;
const motion_time = (index) => (motion_stamps()[index] - scene_start_ns(motion_state.scene)) / 1e9;
const axes_at = (track, index) => track.semi_axes_m[track.semi_axes_m.length === 1 ? 0 : index];
const places = (poses) => poses.map((pose) => pose && pose.slice(0, 3));

const kBox = [1, 1, 1, 2]; // a true body without a mesh is its tight box

// A body at one of the kept times: what it is, where, and how large; nothing where it has no pose.
function track_body(scene, index, track, color, variant) {
  const truth = variant === "", pose = track.poses[index], at = (list) => list[list.length === 1 ? 0 : index];
  if (!pose) return [];
  const mesh = truth && true_mesh(scene, track.id), solid = truth ? kBox : at(track.solids);
  return [{ object: track.object, label: variant, truth, color, pose, sigmas_m: at(track.sigmas_m),
    ...(mesh ? { mesh, key: `${scene} ${track.id}`, scale: [1, 1, 1] } : { mesh: unit_solid(solid), key: solid.join(), scale: at(track.semi_axes_m) }) }];
}

const tracks_of = (tracks) => [...tracks.objects, ...(tracks.unmatched ?? [])];
// The truth's bodies first.
const bodies_at = (scene, index, truths, runs) => [...truths.flatMap((truth) => tracks_of(truth).flatMap((t) => track_body(scene, index, t, css("--ink"), ""))),
  ...runs.flatMap((run) => tracks_of(run).flatMap((t) => track_body(scene, index, t, variant_color(run.variant), run.variant)))];
const motion_bodies = () => bodies_at(motion_state.scene, motion_state.index, motion_truths(), motion_runs());

// The object's 90th percentile of APE.t, which is red; null where it has none.
function reddest_m(run, object) {
  const known = (series_in(run, object)?.columns.ape_translation_m ?? []).filter((v) => v !== null).sort((a, b) => a - b);
  return known[Math.floor(0.9 * (known.length - 1))] || null;
}

// From the variant's colour, of no error, to red.
function error_colors(run, track) {
  const series = series_in(run, track.object), values = series?.columns.ape_translation_m, most = reddest_m(run, track.object);
  if (most === null) return null;
  const from = new THREE.Color(variant_color(run.variant)), to = new THREE.Color(css("--bad"));
  return motion_stamps().map((stamp) => {
    const at = nearest_index(series.stamps_ns, stamp);
    return from.clone().lerp(to, Math.min(1, (values[at] ?? 0) / most)).toArray();
  });
}

// What is painted of one truth or run.
function tracks_look(tracks, color, variant) {
  const truth = variant === "", dash = truth ? motion_state.size / 120 : undefined, pose = tracks.camera[motion_state.index], size = scenery[motion_state.scene]?.camera;
  const half = size ? { half_width: size.width / size.fx / 2, half_height: size.height / size.fy / 2 } : { half_width: 0.7, half_height: 0.5 };
  return {
    paths: [{ points: places(tracks.camera), color, dash }, ...tracks_of(tracks).map((t) => ({ points: places(t.poses), color, dash,
      colors: motion_state.by_error && !truth ? error_colors(tracks, t) : null }))],
    cameras: pose ? [{ pose, color, dash, ...half, depth: motion_state.size / 14, image: truth ? film_image : null }] : [],
  };
}

function motion_look() {
  const parts = [...motion_runs().map((run) => tracks_look(run, variant_color(run.variant), run.variant)),
    ...motion_truths().map((truth) => tracks_look(truth, css("--ink"), ""))]; // dashed over what lies along it
  const all = (name) => parts.flatMap((part) => part[name]), bodies = motion_bodies(), cloud = scenery[motion_state.scene]?.cloud;
  return { paths: all("paths"), cameras: all("cameras"), bodies, floor: motion_state.floor, index: motion_state.index, size: motion_state.size,
    cloud: cloud && motion_state.cloud ? { scene: motion_state.scene, ...cloud } : null,
    sigmas: motion_state.sigmas ? bodies.filter((b) => b.sigmas_m).map((b) => ({ center: b.pose.slice(0, 3), sigmas_m: b.sigmas_m.map((s) => 3 * s), color: b.color })) : [],
    colors: { ink: css("--ink"), soft: css("--soft"), line: css("--line"), paper: css("--raised") } };
}

// All places of the truth: what the first view must hold.
const motion_places = () => motion_truths().flatMap((t) => [t.camera, ...t.objects.map((o) => o.poses)]).flatMap(places).filter(Boolean);

// The box of all places with the objects around them, its size, and a floor under it in squares of a round length.
function measure_scene() {
  const all = motion_places(), bodies = motion_truths().flatMap((t) => t.objects);
  const margin = Math.max(0, ...bodies.flatMap((o) => o.semi_axes_m.filter(Boolean).flat())); // of the largest body
  const range = (i) => [Math.min(...all.map((p) => p[i])) - margin, Math.max(...all.map((p) => p[i])) + margin];
  const [x, y, z] = [0, 1, 2].map(range), size = Math.max(x[1] - x[0], y[1] - y[0], z[1] - z[0], 1e-3), step = round_length(size / 14);
  const on_grid = (r) => [Math.floor(r[0] / step) * step, Math.ceil(r[1] / step) * step];
  const floor = Math.min(...bodies.flatMap((o) => o.poses.map((pose, i) => (pose ? pose[2] - Math.max(...axes_at(o, i)) : Infinity))));
  Object.assign(motion_state, { size, center: [x, y, z].map((r) => (r[0] + r[1]) / 2),
    floor: { x: on_grid(x), y: on_grid(y), z: Number.isFinite(floor) ? floor : z[0], step } });
}

// The first view: from behind the camera, to its side and from above; in the middle, as near as everything fits.
function reset_orbit() {
  const pose = motion_truths()[0].camera.find(Boolean), forward = pose ? pose_axes(pose)[2] : [0, 1, 0];
  const orbit = { target: motion_state.center, yaw: Math.atan2(-forward[1], -forward[0]) + 0.7, pitch: 0.5, distance: 2 * motion_state.size };
  const { clientWidth: width, clientHeight: height } = motion_canvas, all = motion_places();
  for (let round = 0; round < 12; ++round) { // the perspective changes with the place
    const view = orbit_view(orbit, width, height);
    const shown = all.map((p) => in_view(view, p)).filter((p) => p[2] > view.near).map((p) => on_canvas(view, p));
    const [x, y] = [0, 1].map((i) => ({ from: Math.min(...shown.map((p) => p[i])), to: Math.max(...shown.map((p) => p[i])) }));
    const scale = orbit.distance / view.focal, off = (range, middle) => ((range.from + range.to) / 2 - middle) * scale;
    orbit.target = v_add(orbit.target, v_add(v_scale(view.right, off(x, view.cx)), v_scale(view.down, off(y, view.cy))));
    const filled = Math.max((x.to - x.from) / width, (y.to - y.from) / height) / 0.78;
    orbit.distance = Math.min(Math.max(orbit.distance * filled, 0.3 * motion_state.size), 4 * motion_state.size);
  }
  Object.assign(motion_state, { orbit, touched: false });
}

// Where the followed thing is; the scene's middle for none, and as long as it has no place.
function follow_target() {
  const truth = motion_truths()[0];
  const poses = motion_state.follow === "camera" ? truth.camera : truth.objects.find((o) => `object ${o.object}` === motion_state.follow)?.poses;
  return poses?.[motion_state.index]?.slice(0, 3);
}

function draw_motion() {
  if (!motion_state.scene || motion_canvas.clientWidth === 0) return;
  draw_film();
  const ratio = window.devicePixelRatio || 1, { clientWidth: width, clientHeight: height } = motion_canvas;
  Object.assign(motion_names, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  const target = follow_target();
  if (target) motion_state.orbit.target = target;
  const view = orbit_view(motion_state.orbit, width, height), look = { ...motion_look(), width, height };
  motion_state.drawn = look.bodies.map((body) => ({ ...body, outline: outline_of(view, body) }))
    .filter((body) => body.outline).sort((a, b) => b.outline.depth - a.outline.depth); // far ones first
  painter.paint(view, look);
  const context = motion_names.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  paint_names(context, view, motion_state.drawn, look);
}

// The figures of frames.csv at a time of a run: from its series, by the nearest stamp.
function figures_at(run, object) {
  const series = series_in(run, object);
  if (!series) return () => null;
  const at = nearest_index(series.stamps_ns, motion_stamps()[motion_state.index]);
  return (column) => { const values = series.columns[column]; return values ? values[values.length === 1 ? 0 : at] : null; };
}

// What the colours of the errors of the object of the plots mean: a ramp for each shown run.
function draw_error_scale() {
  const object = chart_state.object, reds = (motion_state.by_error ? motion_runs() : []).map((run) => [variant_color(run.variant), reddest_m(run, object)]);
  by_id("space-ramps").replaceChildren(...reds.filter(([, most]) => most !== null).map(([color, most]) => el("span", {}, `APE.t of ${object}: 0 `,
    el("i", { class: "ramp", style: `background:linear-gradient(90deg,${color},${css("--bad")})` }), ` ${format_figure(most)} m and more `)));
}

function draw_readout() {
  draw_error_scale();
  const shown = (value) => (value === null || value === undefined ? "–" : format_figure(value));
  const number = (value) => el("td", { class: "number" }, shown(value));
  const rows = motion_truths()[0].objects.flatMap((o) => motion_runs().map((run) => {
    const figure = figures_at(run, o.object);
    return el("tr", {}, el("td", {}, el("i", { class: "dot", style: `background:${variant_color(run.variant)}` }), o.object, el("small", {}, run.variant)),
      number(figure("iou3d_solid")), number(figure("iou3d")), number(figure("ape_translation_m")), number(figure("ape_rotation_rad")));
  }));
  by_id("space-figures").tBodies[0].replaceChildren(...rows);
}

// Shows one of the kept times, and marks it in the plots.
function show_motion_index(index) {
  motion_state.moved ||= index !== motion_state.index;
  motion_state.index = Math.max(0, Math.min(motion_stamps().length - 1, index));
  const time = motion_time(motion_state.index), slider = by_id("space-time");
  slider.value = String(motion_state.index);
  slider.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
  by_id("space-clock").textContent = `${time.toFixed(2)} s`;
  draw_motion();
  draw_readout();
  note_address();
  if (chart_state.scene === motion_state.scene) draw_marks();
}

// The kept time nearest to one that was pointed at in a plot.
function show_motion_time(scene, time) {
  if (scene !== motion_state.scene || motion_state.playing) return;
  show_motion_index(nearest_index(motion_stamps(), scene_start_ns(scene) + time * 1e9));
}

// Shows a time even while the view plays, which ends there.
function jump_in_time(scene, time) {
  pause_motion();
  show_motion_time(scene, time);
}

// When a run has the object's greatest APE.t or, of another column, its least value; null where it has none.
function worst_time(run, object, column) {
  const series = series_in(run, object), values = series?.columns[column] ?? [], sign = column === "ape_translation_m" ? 1 : -1;
  const worst = values.reduce((best, v, i) => (v !== null && (best < 0 || sign * v > sign * values[best]) ? i : best), -1);
  return worst < 0 ? null : (series.stamps_ns[worst] - scene_start_ns(run.scene)) / 1e9;
}

// The moment at which the first shown run has the object's greatest APE.t.
function show_worst() {
  const run = motion_runs()[0], time = run ? worst_time(run, chart_state.object, "ape_translation_m") : null;
  if (time !== null) jump_in_time(run.scene, time);
}

// Shows these variants in image and 3D, as far as the scene has them.
function show_variants(chosen) {
  const there = chosen.filter((variant) => motion.runs.some((run) => run.scene === motion_state.scene && run.variant === variant));
  if (there.length === 0) return;
  motion_state.variants = new Set(there);
  draw_motion_chips();
  show_motion_index(motion_state.index);
}

function pause_motion() {
  cancelAnimationFrame(motion_state.playing);
  motion_state.playing = null;
  Object.assign(by_id("space-play"), { textContent: "▶", ariaLabel: "Play" });
}

const kLongestStep_s = 0.2; // what takes longer to paint is played slower, not left out

// In the time of the recording; from the start when it is at its end.
function play_motion() {
  const last = motion_stamps().length - 1;
  if (motion_state.index === last) show_motion_index(0);
  let time = motion_time(motion_state.index), before_ms = null;
  const step = (now_ms) => {
    time += Math.min((now_ms - (before_ms ?? now_ms)) / 1000, kLongestStep_s);
    before_ms = now_ms;
    let index = motion_state.index;
    while (index < last && motion_time(index + 1) <= time) ++index;
    if (index !== motion_state.index) show_motion_index(index);
    if (index === last) pause_motion();
    else motion_state.playing = requestAnimationFrame(step);
  };
  Object.assign(by_id("space-play"), { textContent: "❚❚", ariaLabel: "Pause" });
  motion_state.playing = requestAnimationFrame(step);
}

// The best of those shown, as known at each frame where there is one.
const leading_variant = (shown) => ranked_variants().find((v) => shown.includes(v)) ?? shown[0];

// Results made before `evaluate` wrote poses have nothing to show here: which, and what helps.
function say_what_is_absent(scene) {
  const absent = motion.absent.filter((run) => run.scene === scene).map((run) => run.variant), note = by_id("space-absent");
  note.hidden = absent.length === 0;
  note.textContent = `Not here: ${absent.join(", ")} of ${scene}. The results have no evaluation/poses.csv; an older version of evaluate made them. ` +
    "Run evaluate on the runs once more with --force, or the bench into a new folder.";
}

function show_motion(scene) {
  const shown = distinct(motion.runs.filter((run) => run.scene === scene).map((run) => run.variant));
  say_what_is_absent(scene);
  by_id("space-view").hidden = shown.length === 0;
  if (shown.length > 0 && scene === motion_state.scene) return;
  pause_motion();
  if (shown.length === 0) return (motion_state.scene = null);
  Object.assign(motion_state, { scene, variants: new Set([leading_variant(shown)]), moved: false, index: 0, follow: "" });
  draw_motion_chips();
  const names = motion_truths()[0].objects.map((o) => o.object);
  by_id("space-follow").replaceChildren(el("option", { value: "" }, "the whole scene"),
    ...names.map((name) => el("option", { value: `object ${name}` }, name)), el("option", { value: "camera" }, "the camera"));
  by_id("space-time").max = String(motion_stamps().length - 1);
  measure_scene();
  by_id("space-scale").textContent = `squares of ${Number(motion_state.floor.step.toPrecision(1))} m`;
  reset_orbit();
  motion_state.index = Math.floor(motion_stamps().length / 2); // where most is seen
  show_motion_index(motion_state.index);
}
