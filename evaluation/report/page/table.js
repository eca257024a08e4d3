// The summary: sortable, the paper's rows in the same columns.
const kWhereGiven = ["surface_error_median_m", "feature_depth_median_m"]; // of variants that write what they are of
const summary_state = { all: false, paper: true, sort: null, descending: false };

function table_columns() {
  const has = (name) => data.summary.some((row) => name in row.spread);
  return data.metrics.filter((m) => has(m.name) && (summary_state.all || data.summary_metrics.includes(m.name) || kWhereGiven.includes(m.name)));
}

// Rows of the table, the paper's behind the last variant of an object that it has.
function table_rows() {
  const rows = [];
  const shown = data.summary.filter((row) => row.object !== "all" || row.good === 0 || summary_state.all);
  shown.forEach((row, i) => {
    const first = i === 0 || shown[i - 1].scene !== row.scene || shown[i - 1].object !== row.object;
    rows.push({ ...row, first });
    const next = shown[i + 1];
    const last = !next || next.scene !== row.scene || next.object !== row.object;
    const paper = data.paper.find((p) => p.scene === row.scene && p.object === row.object);
    if (!last || !paper || !summary_state.paper) return;
    for (const { name: variant, figures } of paper.systems) {
      const spread = Object.fromEntries(Object.entries(figures).map(([name, value]) => [name, { median: value, n: 0 }]));
      rows.push({ scene: row.scene, object: row.object, variant, spread, paper: true });
    }
  });
  return rows;
}

const sort_keys = {
  scene: (row) => row.scene, object: (row) => row.object, variant: (row) => row.variant,
  runs: (row) => (row.paper ? undefined : row.good),
};

function sorted_rows(rows) {
  if (!summary_state.sort) return rows;
  const key = sort_keys[summary_state.sort] ?? ((row) => (shows_given(row, metric_of.get(summary_state.sort)) ? undefined : row.spread[summary_state.sort]?.median));
  const sign = summary_state.descending ? -1 : 1;
  return rows.map((row, index) => ({ row, index, value: key(row) })).sort((a, b) => {
    if (a.value === undefined || b.value === undefined) // without a figure: always last
      return (a.value === undefined) - (b.value === undefined) || a.index - b.index;
    return sign * (a.value < b.value ? -1 : a.value > b.value ? 1 : 0) || a.index - b.index;
  }).map(({ row }) => row);
}

function sort_by(name) {
  const better = metric_of.get(name)?.better;
  if (summary_state.sort === name) summary_state.descending = !summary_state.descending;
  else Object.assign(summary_state, { sort: name, descending: better === "higher" }); // the best first
  draw_table();
}

function head_cell(name, label, title, number) {
  const order = summary_state.sort !== name ? "none" : summary_state.descending ? "descending" : "ascending";
  return el("th", { scope: "col", "aria-sort": order, title, class: number ? "number" : null },
    el("button", { type: "button", "data-sort": name, click: () => sort_by(name) }, label));
}

// Errors of a camera whose poses were given: no estimate's.
const shows_given = (row, metric) => row.given === true && metric?.better === "lower";

function figure_cell(row, metric) {
  const spread = row.spread[metric.name];
  if (!spread) return el("td", { class: "number" }, row.paper ? "" : "–");
  if (shows_given(row, metric)) return el("td", { class: "number", title: "the camera's poses were given, not estimated" }, "given");
  const text = row.paper ? spread.median.toFixed(3) : format_figure(spread.median);
  const range = spread.max > spread.min ? el("small", {}, `${format_short(spread.min)} – ${format_short(spread.max)}`) : null;
  const title = row.paper ? "as printed in Table III" : `${metric.name}: ${spread.median}, ${spread.n} runs`;
  return el("td", { class: "number", title }, spread.best ? el("b", { class: "best" }, text) : text, range);
}

// A name that may go on in the next line after an underscore.
const breakable = (name) => name.split(/(?<=_)/).flatMap((part) => [part, el("wbr")]);

function table_row(row, columns) {
  const plots = series_of(row.scene, row.object).length > 0;
  const object = plots && !row.paper ? el("a", { href: object_hash(row.scene, row.object) }, row.object) : row.object;
  const runs = row.paper ? "" : `${row.good}/${row.runs}`;
  const first = row.first && !summary_state.sort;
  const repeated = !first && !summary_state.sort; // said once a group, there for readers of the screen
  const name = (text) => el("td", { class: repeated ? "repeated" : null }, text);
  return el("tr", { class: [row.paper ? "paper" : "", first ? "first" : ""].join(" ").trim() || null },
    name(row.scene), name(object), el("td", {}, ...breakable(row.variant), el("small", { class: "where" }, `${row.scene} / ${row.object}`)),
    el("td", { class: row.good < row.runs ? "number few" : "number" }, runs),
    ...columns.map((metric) => figure_cell(row, metric)));
}

function draw_table() {
  const columns = table_columns();
  const table = by_id("summary-table");
  const focused = document.activeElement?.dataset?.sort;
  table.tHead.replaceChildren(el("tr", {}, head_cell("scene", "scene"), head_cell("object", "object"),
    head_cell("variant", "variant"), head_cell("runs", "runs", "runs with a result / all", true),
    ...columns.map((m) => head_cell(m.name, m.unit ? `${m.label} [${m.unit}]` : m.label,
      `${m.definition} ${m.better === "lower" ? "Lower" : "Higher"} is better.`, true))));
  table.tBodies[0].replaceChildren(...sorted_rows(table_rows()).map((row) => table_row(row, columns)));
  if (focused) table.tHead.querySelector(`[data-sort="${focused}"]`)?.focus();
}
