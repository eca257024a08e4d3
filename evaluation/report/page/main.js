// Puts the parts together.
const runs = data.cells.filter((cell) => !cell.output); // without their later outputs
const scenes = distinct(data.cells.map((cell) => cell.scene));
const subjects = scenes.flatMap((scene) => distinct(data.cells.filter((cell) => cell.scene === scene)
  .flatMap((cell) => cell.series.map((s) => s.object))).map((object) => ({ scene, object })));

const object_hash = (scene, object) => `#object/${encodeURIComponent(scene)}/${encodeURIComponent(object)}`;

function failure(cell) {
  return cell.status === "failed" ? cell.message : "not run";
}

function draw_failures() {
  const failed = runs.filter((cell) => cell.status === "failed" || cell.status === "missing");
  by_id("failures").hidden = failed.length === 0;
  by_id("failures").querySelector("tbody").replaceChildren(...failed.map((cell) => el("tr", {}, el("td", {}, cell.scene),
    el("td", {}, cell.variant), el("td", { class: "number" }, cell.seed), el("td", {}, failure(cell)))));
}

// Of scenes and recordings without a true object.
function draw_sizes() {
  const rows = data.cells.flatMap((cell) => cell.sizes.map((size) => ({ cell, size })));
  const number = (text) => el("td", { class: "number" }, text);
  by_id("sizes").hidden = rows.length === 0;
  by_id("sizes").querySelector("tbody").replaceChildren(...rows.map(({ cell, size }) => el("tr", {}, el("td", {}, cell.scene), el("td", {}, cell.variant),
    number(cell.seed), number(size.id), number(size.states), el("td", {}, size.size_m.map((m) => m.toFixed(3)).join(" × ")), number(format_figure(size.spread)))));
}

function draw_definitions() {
  by_id("alignments").textContent = data.alignments.length ? data.alignments.join(", ") : "not recorded";
  const present = data.metrics.filter((m) => data.summary.some((row) => m.name in row.spread));
  by_id("metric-list").replaceChildren(...present.flatMap((m) => [
    el("dt", {}, m.label, el("small", {}, `${m.unit ? `${m.unit}, ` : ""}${m.better} is better`)),
    el("dd", {}, m.definition, " ", el("code", {}, m.name))]));
}

function draw_made() {
  const entry = (name, value) => (value ? [el("dt", {}, name), el("dd", {}, value)] : []);
  by_id("made-list").replaceChildren(...entry("command", data.command && el("code", {}, data.command)),
    ...entry("program", data.programs.join(", ")), ...entry("gathered by", data.program), ...entry("this page by", data.report_program),
    ...entry("inputs (hashes)", data.inputs.join(", ")),
    ...entry("seeds", data.seeds.join(", ")), ...entry("hardware", data.hardware));
  by_id("config").textContent = data.config || "not recorded";
  by_id("run-table").tBodies[0].replaceChildren(...runs.map((cell) => el("tr", {}, el("td", {}, cell.scene), el("td", {}, cell.variant),
    el("td", { class: "number" }, cell.seed), el("td", { class: `status-${cell.status}` }, cell.not_isolated ? `${cell.status}, not isolated` : cell.status),
    el("td", {}, ...(cell.status !== "ok" ? [cell.message] : [el("a", { href: `${cell.folder}/evaluation/evaluation.json` }, "evaluation.json"), " ",
      el("a", { href: `${cell.folder}/evaluation/frames.csv` }, "frames.csv")])))));
}

function draw_object_chips() {
  chips(by_id("object-chips"), "", subjects, subjects.filter((s) => s.scene === chart_state.scene && s.object === chart_state.object), {
    text: (s) => `${s.scene} / ${s.object}`,
    change: ([s]) => {
      history.replaceState(null, "", object_hash(s.scene, s.object));
      show_object(s);
    },
  });
}

// Of the variants and seeds that the scene has; the others stay as they were pressed.
function draw_filter_chips() {
  const cells = data.cells.filter((cell) => cell.scene === chart_state.scene && cell.series.length > 0);
  const filter = (id, label, state, values, extra) => chips(by_id(id), label, values, values.filter((v) => chart_state[state].has(v)), {
    many: true, ...extra, change: (chosen) => {
      const others = [...chart_state[state]].filter((v) => !values.includes(v));
      chart_state[state] = new Set([...others, ...chosen]);
      draw_charts();
    } });
  filter("variant-chips", "variants", "variants", distinct(cells.map((cell) => cell.variant)), { color: variant_color });
  filter("seed-chips", "seeds", "seeds", distinct(cells.map((cell) => cell.seed)));
}

function show_object({ scene, object }) {
  Object.assign(chart_state, { scene, object, time: null });
  draw_object_chips();
  draw_filter_chips();
  draw_charts();
  show_motion(scene);
  draw_error_scale();
  show_scene(scene);
}

function show_scene(scene) {
  const shown = distinct(galleries.filter((g) => g.frames.length > 0).map((g) => g.scene));
  chips(by_id("scene-chips"), "", shown, [scene], { change: ([chosen]) => show_scene(chosen) });
  draw_galleries(scene);
}

// The view as an address: #scene=NAME&object=NAME&t=SECONDS&show=VARIANT,VARIANT.
const view_hash = (scene, object, time, shown) => `#${new URLSearchParams({ scene, object, ...(time === null ? {} : { t: time.toFixed(2) }), show: shown.join(",") })}`;
let address_timer = null;
function note_address() {
  clearTimeout(address_timer); // browsers allow so many changes a second
  address_timer = setTimeout(() => {
    if (!motion_state.scene || !motion_state.moved) return;
    history.replaceState(null, "", view_hash(chart_state.scene, chart_state.object, motion_time(motion_state.index), [...motion_state.variants]));
  }, 300);
}

// The view that the address names, or the object of #object/SCENE/OBJECT.
function follow_address() {
  const text = location.hash.slice(1), [kind, ...names] = text.split("/").map((part) => { try { return decodeURIComponent(part); } catch { return ""; } });
  const parts = new URLSearchParams(text), [scene, object] = kind === "object" ? names : [parts.get("scene"), parts.get("object")];
  const found = subjects.find((s) => s.scene === scene && (s.object === object || object === null));
  if (!found) return;
  show_object(found);
  const time = Number(parts.get("t") ?? NaN);
  show_variants((parts.get("show") ?? "").split(","));
  if (motion_state.scene && Number.isFinite(time)) jump_in_time(motion_state.scene, time);
  by_id("objects").scrollIntoView();
}

// A click on a plot: there the time stays.
function jump_to(scene, time) {
  jump_in_time(scene, time);
  by_id("space-view").scrollIntoView({ block: "nearest" });
}

function start() {
  draw_verdict();
  start_film(ranked_variants()[0]);
  draw_failures();
  start_table();
  draw_ratios();
  start_ablation();
  draw_definitions();
  draw_made();
  draw_sizes();
  draw_lidar();
  draw_times();
  by_id("log-errors").addEventListener("change", (e) => { chart_state.log = e.target.checked; draw_charts(); });
  by_id("frames").hidden = galleries.every((g) => g.frames.length === 0);
  document.querySelector('nav a[href="#frames"]').hidden = by_id("frames").hidden;
  by_id("objects").hidden = subjects.length === 0;
  start_viewer();
  start_motion();
  if (subjects.length > 0) show_object(subjects[0]);
  else if (galleries.length > 0) show_scene(galleries[0].scene);
  dark_mode.addEventListener("change", () => {
    draw_verdict();
    draw_table();
    draw_lidar();
    draw_ablation();
    if (subjects.length === 0) return;
    draw_filter_chips();
    draw_charts();
    if (motion_state.scene) (draw_motion_chips(), show_motion_index(motion_state.index));
  });
  window.addEventListener("hashchange", follow_address);
  follow_address();
}

start();
