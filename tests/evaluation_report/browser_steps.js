// What browser_test.cpp does in a report: appended to its scripts, whose names it sees. It sends what it saw as JSON
// to the page around it, which leaves it in <pre id="seen">; the test judges it.
(async () => {
  const seen = {};
  const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
  const column = (index) => [...by_id("summary-table").tBodies[0].rows].map((row) => row.cells[index].firstChild?.textContent ?? "");
  const header = (name) => document.querySelector(`#summary-table [data-sort="${name}"]`);

  // The view as numbers: where the eye is, and what outlines were painted.
  const painted = () => ({ index: motion_state.index, orbit: structuredClone(motion_state.orbit),
    width: motion_canvas.clientWidth, height: motion_canvas.clientHeight, picture: motion_canvas.toDataURL(),
    figures: by_id("space-figures").tBodies[0].textContent,
    film: film_canvas.toDataURL(), frame: by_id("film-note").textContent, film_width: film_image.clientWidth,
    in_film: film_state.drawn.map(({ object, label, outline }) => ({ object, label, outline: outline.points })),
    bodies: motion_state.drawn.map(({ object, label, outline }) => ({ object, label, outline: outline.points })) });
  const middle_of = ({ outline }) => outline.points.reduce((sum, p) => v_add(sum, [...p, 0]), [0, 0, 0]).map((v) => v / outline.points.length);

  // What is drawn of one body alone: its pixels' number and box.
  const pixels_of = (body, of = painter, canvas = motion_canvas) => {
    const { clientWidth: width, clientHeight: height } = motion_canvas, view = orbit_view(motion_state.orbit, width, height);
    of.paint(view, { ...motion_look(), width, height, paths: [], cameras: [], sigmas: [], cloud: null, bodies: [body], floor: { x: [0, -1], y: [0, -1], z: 0, step: 1 } });
    const copy = el("canvas", { width, height }).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0, width, height);
    const { data: rgba } = copy.getImageData(0, 0, width, height), box = { count: 0, left: width, right: 0, top: height, bottom: 0 };
    for (let i = 3; i < rgba.length; i += 4) {
      if (rgba[i] < 40) continue;
      const x = (i >> 2) % width, y = Math.floor((i >> 2) / width);
      ++box.count;
      Object.assign(box, { left: Math.min(box.left, x), right: Math.max(box.right, x + 1), top: Math.min(box.top, y), bottom: Math.max(box.bottom, y + 1) });
    }
    draw_motion();
    return box;
  };
  const slide = (index) => {
    by_id("space-time").value = String(index);
    by_id("space-time").dispatchEvent(new Event("input"));
    return painted();
  };
  const pointer = (type, x, y, id = 1, more = {}) =>
    motion_canvas.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: y, pointerId: id, buttons: 1, bubbles: true, ...more }));
  motion_canvas.setPointerCapture = () => {}; // made-up pointers cannot be captured

  seen.page = { width: innerWidth, overflow: document.documentElement.scrollWidth - innerWidth,
    background: getComputedStyle(document.body).backgroundColor, charts: charts.length };

  // What a box cuts off at its right, and the smallest letters of the pictures [px].
  const cut = (selector) => [...document.querySelectorAll(selector)].filter((node) => {
    const box = node.closest(".scroll, svg").getBoundingClientRect(), own = node.getBoundingClientRect();
    return own.right > box.right + 1 || own.left < box.left - 1 || own.right > innerWidth; }).map((node) => node.textContent);
  const of_arcs = [...document.querySelectorAll(".arcs text")];
  seen.small = { failures: [...document.querySelectorAll("#failures td")].length, cut: cut("#failures td, .arcs text"),
    arcs: document.querySelectorAll(".arcs svg").length, letters: Math.min(...of_arcs.map((text) => text.getBoundingClientRect().height)) };

  const ape = [...document.querySelectorAll("#summary-table [data-sort]")].findIndex((b) => b.dataset.sort === "ape_translation_rmse_m");
  seen.table = { original: column(ape) };
  header("ape_translation_rmse_m").click();
  seen.table.best_first = column(ape);
  header("ape_translation_rmse_m").click();
  seen.table.worst_first = column(ape);
  header("object").click();
  seen.table.objects = column(1);
  by_id("original-order").click();
  seen.table.again = column(ape);

  // The same table with long names, long ranges and every column that is shown without being asked for.
  const as_they_are = data.summary;
  const ranging = { lower: { median: 0.00021, min: 0.00019, max: 0.00024, n: 8 }, higher: { median: 0.89, min: 0.86, max: 0.93, n: 8 } };
  data.summary = as_they_are.map((row) => ({ ...row, variant: `${row.variant}_rigid_axis_lidar`,
    spread: Object.fromEntries([...data.summary_metrics, ...kWhereGiven].map((name) => [name, ranging[metric_of.get(name).better]])) }));
  draw_table();
  seen.crowded = { columns: by_id("summary-table").tHead.rows[0].cells.length, cut: cut("#summary-table th:not(:nth-child(-n+2))") };
  data.summary = as_they_are;
  draw_table();

  const rows_of = (table) => [...by_id(table).rows].map((row) => [...row.cells].map((cell) => cell.textContent));
  const choose = (id, value) => {
    by_id(id).value = value;
    by_id(id).dispatchEvent(new Event("change"));
  };
  choose("filter-metric", kEvery);
  seen.all_metrics = rows_of("summary-table").slice(0, 2);
  choose("filter-metric", kAll);
  choose("filter-scene", scenes[1]);
  choose("filter-object", "ball");
  choose("filter-baseline", "single_frame_obb");
  choose("filter-metric", "ape_translation_rmse_m");
  seen.filtered = rows_of("summary-table");
  for (const id of ["filter-scene", "filter-object", "filter-baseline", "filter-metric"]) choose(id, kAll);
  seen.verdict = { head: by_id("verdict").innerText, more: by_id("verdict-more").innerText, compared: by_id("compared").textContent,
    variants: [...by_id("variant-lines").querySelectorAll("dd")].map((dd) => dd.textContent), film: by_id("film").querySelector("img").alt };
  const [one, other] = causal_variants, told = ({ baseline, variant, better, worse }) => ({ baseline, variant, better: better.map((o) => o.object), worse: worse.map((o) => o.object) });
  seen.verdict.there = told(duel(one, other));
  const both_ways = data.verdicts;
  data.verdicts = both_ways.filter((d) => d.baseline !== one); // as of many variants
  seen.verdict.turned = told(duel_either_way(one, other));
  data.verdicts = both_ways;
  seen.times = rows_of("times-table");
  seen.ratios = by_id("ratios").hidden ? [] : rows_of("ratio-table");
  seen.without_poses = { section: !by_id("objects").hidden, view: !by_id("space-view").hidden, note: by_id("space-absent").hidden ? "" : by_id("space-absent").textContent };
  const send = () => parent.postMessage(JSON.stringify(seen), "*");
  if (!motion_state.scene || location.hash === "#tables") return send();

  by_id("ablation-metrics").querySelector("button").click(); // APE.t
  const percent = (node, side) => Number.parseFloat(node.style[side]);
  seen.ablation = [...by_id("ablation-plots").children].map((figure) => [...figure.querySelectorAll(".ablation-row:has(.mean)")].map((row) => ({
    title: row.title, mean: percent(row.querySelector(".mean"), "left"), seeds: [...row.querySelectorAll(".seed")].map((dot) => percent(dot, "left")),
    interval: row.querySelector(".interval") && [percent(row.querySelector(".interval"), "left"), percent(row.querySelector(".interval"), "width")] })));

  const one_run = (value) => ({ mean: value, interval: null, values: [value] });
  seen.axes = [];
  for (let least = 1; least < 10; least *= 1.07) // ranges of all widths, both kinds of axes
    for (const ratio of [1, 1.0003, 1.5, 3, 7, 19, 21, 40, 90, 2000])
      seen.axes.push(ablation_axis([one_run(least), one_run(least * ratio)], true));
  seen.axes = seen.axes.map(({ at, marks }) => marks.map(at));
  const wide = { mean: 0.9, interval: 0.4, values: [0.8, 1] }, low = { mean: 0.1, interval: 0.4, values: [0, 0.2] };
  const share = data.metrics.find((m) => m.name === "iou3d_ellipsoid_mean"), axis = ablation_axis([wide, low], false);
  seen.clipped = { zero: axis.at(0), one: axis.at(1), bars: [wide, low].map((s) => {
    const bar = ablation_row({ variant: data.summary[0].variant, spread: { iou3d_ellipsoid_mean: s } }, share, axis).querySelector(".interval");
    return [percent(bar, "left"), percent(bar, "left") + percent(bar, "width")]; }) };

  seen.space = { start: painted(), early: slide(5), late: slide(125), mark_s: marked_time() };
  const flat = el("canvas"), asked = flat.getContext.bind(flat);
  flat.getContext = (kind) => (kind === "webgl" ? null : asked(kind)); // as where there is no WebGL
  const in_lines = make_painter(flat);
  seen.space.solids = motion_state.drawn.filter((body) => !body.truth).map((body) => ({ object: body.object, label: body.label,
    pixels: pixels_of(body), in_lines: pixels_of(body, in_lines, flat) }));
  document.querySelector('#space-variants button[aria-pressed="false"]').click();
  seen.space.both = painted();
  by_id("space-follow").value = "object cube";
  by_id("space-follow").dispatchEvent(new Event("change"));
  seen.space.followed = painted();
  by_id("space-reset").click();

  const box = motion_canvas.getBoundingClientRect(), x = box.left + 100, y = box.top + 100;
  seen.space.before_drag = painted();
  pointer("pointerdown", x, y);
  pointer("pointermove", x + 50, y + 25);
  pointer("pointerup", x + 50, y + 25);
  seen.space.dragged = painted();
  const [aim_x, aim_y] = middle_of(motion_state.drawn[0]), aim = { x: aim_x, y: aim_y }; // what is pointed at stays under the pointer
  const wheel = new WheelEvent("wheel", { deltaY: -100, cancelable: true, clientX: box.left + aim.x, clientY: box.top + aim.y });
  motion_canvas.dispatchEvent(wheel);
  const [aimed_x, aimed_y] = middle_of(motion_state.drawn[0]);
  seen.space.wheeled = { ...painted(), stays: wheel.defaultPrevented, aim, aimed: { x: aimed_x, y: aimed_y } };
  pointer("pointerdown", x, y, 1);
  pointer("pointerdown", x + 100, y, 2);
  pointer("pointermove", x + 200, y, 2); // twice as far apart
  pointer("pointerup", x, y, 1);
  pointer("pointerup", x + 200, y, 2);
  seen.space.pinched = painted();

  slide(0);
  by_id("space-play").click();
  for (let wait = 0; wait < 50 && motion_state.index < 3; ++wait) await new Promise(requestAnimationFrame); // frames come as the machine can
  by_id("space-play").click();
  seen.space.played = motion_state.index;
  await sleep(500);
  seen.space.paused = motion_state.index;
  show_motion_time(motion_state.scene, motion_time(70)); // as a pointer on a plot does
  seen.space.pointed = motion_state.index;
  seen.svg = chart_svg(charts[0], "APE <of> a & b");
  const [group] = ablation_groups(ablation_state.metric.name), spreads = group.rows.map((row) => row.spread[ablation_state.metric.name]);
  seen.ablation_svg = { drawing: ablation_svg(group, ablation_state.metric), circles: spreads.reduce((sum, s) => sum + s.values.length + 1, 0),
    figures: document.querySelectorAll("#ablation figure").length, buttons: document.querySelectorAll("#ablation figure .save").length };
  by_id("space-errors").click();
  const reds = motion_runs().map((run) => reddest_m(run, chart_state.object)).filter((most) => most !== null);
  seen.ramps = { text: by_id("space-ramps").textContent, shown: document.querySelectorAll("#space-ramps .ramp").length, expected: reds.length, most: format_figure(reds[0] ?? 0) };
  const before = { scene: chart_state.scene, object: chart_state.object };
  seen.ramps.other = subjects.find((s) => s.scene === before.scene && s.object !== before.object && s.object !== "camera").object;
  show_object({ scene: before.scene, object: seen.ramps.other });
  seen.ramps.of_other = by_id("space-ramps").textContent;
  show_object(before);
  by_id("space-errors").click();
  seen.ramps.after = by_id("space-ramps").textContent;
  document.activeElement?.blur();
  document.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
  seen.space.stepped = motion_state.index;
  const blank = () => {
    const event = new KeyboardEvent("keydown", { key: " ", cancelable: true });
    document.dispatchEvent(event);
    const taken = { playing: motion_state.playing !== null, stays: event.defaultPrevented };
    pause_motion();
    return taken;
  };
  scrollTo({ top: 0, behavior: "instant" });
  seen.space.blank = { away: blank() };
  by_id("space-play").scrollIntoView({ behavior: "instant", block: "center" });
  seen.space.blank.there = blank();
  await sleep(600);
  seen.space.address = location.hash;
  slide(3);
  location.hash = "#scene=skateboard_ball&object=ball&t=2&show=rotbbox";
  await sleep(300);
  seen.space.linked = { scene: motion_state.scene, object: chart_state.object, index: motion_state.index, variants: [...motion_state.variants], mark_s: marked_time() };

  // The link to the weakest object, while another variant plays.
  show_variants(["rotbbox"]);
  play_motion();
  document.querySelector("#verdict-more a").click();
  await sleep(300);
  const [weak] = motion_runs(), ious = series_in(weak, chart_state.object).columns, iou = ious.iou3d_solid ? "iou3d_solid" : "iou3d";
  seen.space.weakest = { variants: [...motion_state.variants], playing: motion_state.playing !== null, off_s: marked_time() - motion_time(motion_state.index),
    named: document.querySelector("#verdict-more a").textContent === chart_state.object, iou: figures_at(weak, chart_state.object)(iou), least: Math.min(...ious[iou].filter((v) => v !== null)) };
  show_variants(["rotbbox"]);
  play_motion();
  by_id("film-open").click();
  seen.space.of_film = { variants: [...motion_state.variants], playing: motion_state.playing !== null };

  send();
})();
