// The paper's UniQuadric and our variants, each divided by its own single-frame baseline.
function ratio_row(row, metrics, first) {
  const number = (text, title) => el("td", { class: "number", title }, text);
  const figure = (m) => (m.name in row.ratio ? format_figure(row.ratio[m.name]) : "–");
  return el("tr", { class: [row.paper ? "paper" : "", first ? "first" : ""].join(" ").trim() || null },
    el("td", {}, row.scene), el("td", {}, row.object), el("td", {}, ...breakable(row.system)), el("td", {}, ...breakable(row.baseline)),
    number(row.paper ? "" : `${row.good}/${row.runs}`, "runs with a result / all"),
    ...metrics.map((m) => number(figure(m), `${m.name}, divided by the baseline's`)));
}

function draw_ratios() {
  const metrics = data.metrics.filter((m) => data.ratios.some((row) => m.name in row.ratio));
  by_id("ratios").hidden = data.ratios.length === 0;
  document.querySelector('nav a[href="#ratios"]').hidden = data.ratios.length === 0;
  by_id("ratio-note").textContent = data.ratio_note;
  const head = ["scene", "object", "system", "divided by"].map((text) => el("th", {}, text));
  const numbers = ["runs", ...metrics.map((m) => m.label)].map((text) => el("th", { class: "number" }, text));
  by_id("ratio-table").tHead.replaceChildren(el("tr", {}, ...head, ...numbers));
  by_id("ratio-table").tBodies[0].replaceChildren(...data.ratios.map((row) => ratio_row(row, metrics, row.paper)));
}
