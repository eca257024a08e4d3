// What the stages of the estimator took: a row a scene and variant, a column a stage, the costliest first.
function time_rows() {
  const timed = data.cells.filter((cell) => Object.keys(cell.stage_ms).length > 0);
  const of = (cell) => `${cell.scene}\n${cell.variant}`;
  return distinct(timed.map(of)).map((key) => {
    const cells = timed.filter((cell) => of(cell) === key);
    const median = (stage) => median_of(cells.map((cell) => cell.stage_ms[stage] ?? 0));
    const stages = Object.fromEntries(distinct(cells.flatMap((cell) => Object.keys(cell.stage_ms))).map((stage) => [stage, median(stage)]));
    return { scene: cells[0].scene, variant: cells[0].variant, stages };
  });
}

const kLeast_ms = 0.05;

function draw_times() {
  const rows = time_rows(), cost = (stage) => rows.reduce((sum, row) => sum + (row.stages[stage] ?? 0), 0);
  const stages = distinct(rows.flatMap((row) => Object.keys(row.stages))).filter((stage) => stage !== "frame" && cost(stage) >= kLeast_ms).sort((a, b) => cost(b) - cost(a));
  by_id("times").hidden = rows.length === 0;
  document.querySelector('nav a[href="#times"]').hidden = rows.length === 0;
  const number = (tag, text) => el(tag, { class: "number" }, text);
  by_id("times-table").tHead.replaceChildren(el("tr", {}, el("th", {}, "variant"), number("th", "whole [ms]"), ...stages.map((stage) => number("th", stage))));
  by_id("times-table").tBodies[0].replaceChildren(...rows.map((row) => el("tr", {}, el("td", {}, row.variant, el("small", {}, row.scene)),
    ...["frame", ...stages].map((stage) => number("td", stage in row.stages ? row.stages[stage].toFixed(1) : "–")))));
}
