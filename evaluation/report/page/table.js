// The summary: filtered, sortable, against a baseline, the paper's rows in the same columns.
const kWhereGiven = ["surface_error_median_m", "feature_depth_median_m"]; // of variants that write what they are of
const kAll = "", kEvery = "every metric";
const summary_state = { scene: kAll, object: kAll, variant: kAll, metric: kAll, output: kAll, baseline: kAll, paper: false, sort: null, descending: false };

function table_columns() {
  const has = (name) => data.summary.some((row) => name in row.spread), { metric } = summary_state;
  const short = (m) => data.summary_metrics.includes(m.name) || kWhereGiven.includes(m.name);
  return data.metrics.filter((m) => has(m.name) && (metric === kEvery || (metric === kAll ? short(m) : m.name === metric)));
}

function is_shown(row) {
  const is = (state, value) => summary_state[state] === kAll || summary_state[state] === value;
  return is("scene", row.scene) && is("object", row.object) && is("variant", own_name(row.variant)) &&
    (summary_state.output === "all" || output_of(row.variant) === summary_state.output) &&
    (row.object !== "all" || row.good === 0 || summary_state.metric === kEvery);
}

// The median over the shown objects of a variant, for each metric; a row a variant.
function overall_of_shown(shown) {
  const objects = shown.filter((row) => row.object !== "camera" && row.object !== "all");
  if (distinct(objects.map((row) => `${row.scene}/${row.object}`)).length < 2) return [];
  return distinct(objects.map((row) => row.variant)).map((variant) => {
    const rows = objects.filter((row) => row.variant === variant), spread = {};
    for (const { name } of data.metrics) {
      const values = rows.map((row) => row.spread[name]?.median).filter((v) => v !== undefined);
      if (values.length) spread[name] = { median: median_of(values), min: Math.min(...values), max: Math.max(...values), n: values.length };
    }
    return { scene: "all", object: `${rows.length} objects`, variant, runs: rows.reduce((n, r) => n + r.runs, 0), good: rows.reduce((n, r) => n + r.good, 0), spread };
  });
}

// Of all scenes and of families of scenes where the page shows some of them; else of what is shown.
function overall_rows(is_wanted) {
  const whole = data.overall.length > 0 && summary_state.scene === kAll && summary_state.object === kAll;
  const rows = whole ? data.overall.filter(is_wanted) : overall_of_shown(data.summary.filter(is_wanted));
  const all = rows.map((row, i) => ({ ...row, spread: Object.fromEntries(Object.entries(row.spread).map(([name, s]) => [name, { ...s }])), overall: true, first: row.scene !== rows[i - 1]?.scene }));
  for (const group of distinct(all.map((row) => `${row.scene} ${output_of(row.variant)}`)))
    for (const { name, better } of data.metrics)
      mark_best(all.filter((row) => `${row.scene} ${output_of(row.variant)}` === group).map((row) => row.spread[name]).filter(Boolean), better);
  return all;
}

// As the objects' rows are marked: of those that are over the most objects, where they differ.
function mark_best(spreads, better) {
  const most = Math.max(...spreads.map((s) => s.n)), compared = spreads.filter((s) => s.n === most), medians = compared.map((s) => s.median);
  const best = better === "lower" ? Math.min(...medians) : Math.max(...medians);
  if (Math.min(...medians) !== Math.max(...medians)) for (const s of compared) s.best = s.median === best;
}

// Rows of the table, the paper's behind the last variant of an object that it has.
function table_rows() {
  const shown = data.summary.filter(is_shown), rows = overall_rows(is_shown);
  const is_same = (a, b) => a && a.scene === b.scene && a.object === b.object;
  shown.forEach((row, i) => {
    rows.push({ ...row, first: !is_same(shown[i - 1], row) });
    const paper = data.paper.find((p) => is_same(p, row));
    if (is_same(shown[i + 1], row) || !paper || !summary_state.paper) return;
    for (const { name: variant, figures } of paper.systems) {
      const spread = Object.fromEntries(Object.entries(figures).map(([name, value]) => [name, { median: value, n: 0 }]));
      rows.push({ scene: row.scene, object: row.object, variant, spread, paper: true });
    }
  });
  return rows;
}

// The row of the baseline beside this one, with the same output.
function baseline_row(row) {
  if (summary_state.baseline === kAll || row.paper || own_name(row.variant) === summary_state.baseline) return null;
  const output = output_of(row.variant), name = summary_state.baseline + (output ? `@${output}` : "");
  if (row.overall) return overall_rows((r) => is_shown({ ...r, variant: row.variant }) && r.variant === name).find((r) => r.scene === row.scene) ?? null;
  return data.summary.find((r) => r.scene === row.scene && r.object === row.object && r.variant === name) ?? null;
}

const sort_keys = {
  scene: (row) => row.scene, object: (row) => row.object, variant: (row) => row.variant,
  runs: (row) => (row.paper ? undefined : row.good), verdict: (row) => verdict_against_baseline(row) || undefined,
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

// The change from the baseline: of errors in per cent, of shares and counts their difference.
function change_text(metric, from, to) {
  if (metric.better === "lower" && metric.unit && from > 0) return `${to >= from ? "+" : "−"}${format_short(Math.abs(100 * (to / from - 1)))} %`;
  return `${to >= from ? "+" : "−"}${format_short(Math.abs(to - from))}`;
}

function below_figure(row, metric, spread, base) {
  const from = base?.spread[metric.name]?.median;
  if (from !== undefined && from !== spread.median)
    return el("small", { class: (spread.median < from) === (metric.better === "lower") ? "gain" : "loss" }, change_text(metric, from, spread.median));
  return spread.max > spread.min ? el("small", {}, `${format_short(spread.min)} – ${format_short(spread.max)}`) : null;
}

function figure_cell(row, metric, base) {
  const spread = row.spread[metric.name];
  if (!spread) return el("td", { class: "number" }, row.paper ? "" : "–");
  if (shows_given(row, metric)) return el("td", { class: "number", title: "the camera's poses were given, not estimated" }, "given");
  const text = row.paper ? spread.median.toFixed(3) : format_figure(spread.median);
  const title = row.paper ? "as printed in Table III" : `${metric.name}: ${spread.median}, ${count_of(spread.n, row.overall ? "object" : "run")}`;
  return el("td", { class: "number", title }, spread.best ? el("b", { class: "best" }, text) : text, row.paper ? null : below_figure(row, metric, spread, base));
}

// A name that may go on in the next line after an underscore.
const breakable = (name) => name.split(/(?<=_)/).flatMap((part) => [part, el("wbr")]);

// A variant's name that may break, but not behind its swatch.
function with_swatch(swatch, name) {
  const [first, ...rest] = breakable(name);
  return [el("span", { class: "swatched" }, swatch, first), ...rest];
}

// Of an object the verdict, of all objects how many.
function verdict_against_baseline(row) {
  const found = summary_state.baseline !== kAll && !row.paper && !output_of(row.variant) && duel(summary_state.baseline, row.variant);
  if (!found) return "";
  if (row.overall) return row.scene === "all" ? `${found.count.better} better, ${found.count.worse} worse` : "";
  return found.objects.find((o) => o.scene === row.scene && o.object === row.object)?.verdict ?? "";
}

function verdict_cell(row) {
  const verdict = verdict_against_baseline(row), kind = ["better", "mended"].includes(verdict) ? "gain" : ["worse", "lost"].includes(verdict) ? "loss" : null;
  return el("td", { class: kind }, verdict);
}

function table_row(row, columns) {
  const plots = series_of(row.scene, row.object).length > 0, base = baseline_row(row);
  const object = plots && !row.paper ? el("a", { href: object_hash(row.scene, row.object) }, row.object) : row.object;
  const runs = row.paper ? "" : `${row.good}/${row.runs}`;
  const first = row.first && !summary_state.sort;
  const repeated = !first && !summary_state.sort; // said once a group, there for readers of the screen
  const name = (text) => el("td", { class: repeated ? "repeated" : null }, text);
  const swatch = row.paper ? null : el("i", { class: "swatch", style: `background:${variant_color(row.variant)}` });
  return el("tr", { class: [row.paper ? "paper" : "", row.overall ? "overall" : "", first ? "first" : ""].join(" ").trim() || null },
    name(row.scene), name(object), el("td", { title: data.descriptions[own_name(row.variant)] ?? null }, ...with_swatch(swatch, row.variant), el("small", { class: "where" }, `${row.scene} / ${row.object}`)),
    el("td", { class: row.good < row.runs ? "number few" : "number" }, runs),
    ...(summary_state.baseline === kAll ? [] : [verdict_cell(row)]), ...columns.map((metric) => figure_cell(row, metric, base)));
}

function draw_table() {
  const columns = table_columns();
  const table = by_id("summary-table");
  const focused = document.activeElement?.dataset?.sort;
  table.tHead.replaceChildren(el("tr", {}, head_cell("scene", "scene"), head_cell("object", "object"),
    head_cell("variant", "variant"), head_cell("runs", "runs", "runs with a result / all", true),
    ...(summary_state.baseline === kAll ? [] : [head_cell("verdict", `against ${summary_state.baseline}`, "3D IoU, APE.t and coverage, by the gate's margins")]),
    ...columns.map((m) => head_cell(m.name, with_unit(m.label, m.unit),
      `${m.definition} ${m.better === "lower" ? "Lower" : "Higher"} is better.`, true))));
  const rows = sorted_rows(table_rows());
  table.tBodies[0].replaceChildren(...(rows.length ? rows.map((row) => table_row(row, columns)) : [el("tr", {}, el("td", { colspan: 4 + columns.length }, "No rows: the filters leave nothing."))]));
  if (focused) table.tHead.querySelector(`[data-sort="${focused}"]`)?.focus();
}

// A select of the table's state; one that has a single choice is not shown.
function filter(id, state, choices) {
  const select = by_id(id);
  select.replaceChildren(...choices.map(([value, text]) => el("option", { value, selected: value === summary_state[state] }, text)));
  select.closest("label").hidden = choices.length < 2 || (choices[0][0] === kAll && choices.length === 2 && state !== "metric" && state !== "output");
  select.addEventListener("change", () => { summary_state[state] = select.value; draw_table(); });
}

function start_table() {
  const shown_note = data.overall.length ? `${scenes.length} of ${data.counts.scenes} scenes are shown one by one, here and below. ${data.shown_note}` : "";
  by_id("shown-note").hidden = !shown_note && !data.judged_note;
  by_id("shown-note").textContent = `${shown_note} ${data.judged_note}`;
  const plain = (list) => list.map((value) => [value, value]), with_all = (text, list) => [[kAll, text], ...plain(list)];
  const outputs = distinct(data.summary.map((row) => output_of(row.variant)));
  const shown = data.metrics.filter((m) => data.summary.some((row) => m.name in row.spread));
  const baselines = causal_variants.filter((v) => data.verdicts.some((d) => d.baseline === v));
  filter("filter-scene", "scene", with_all("all", scenes));
  filter("filter-object", "object", with_all("all", distinct(data.summary.map((row) => row.object)).filter((o) => o !== "all")));
  filter("filter-variant", "variant", with_all("all", causal_variants));
  filter("filter-metric", "metric", [[kAll, "the main ones"], [kEvery, "all"], ...shown.map((m) => [m.name, m.label])]);
  filter("filter-output", "output", [[kAll, "at each frame"], ...outputs.filter(Boolean).map((o) => [o, o === "final" ? "at the end" : "some time later"]), ...(outputs.length > 1 ? [["all", "all three"]] : [])]);
  filter("filter-baseline", "baseline", with_all("none", baselines));
  by_id("paper-switch").hidden = !data.summary.some((row) => data.paper.some((p) => p.scene === row.scene && p.object === row.object));
  by_id("paper-rows").addEventListener("change", (e) => { summary_state.paper = e.target.checked; draw_table(); });
  by_id("original-order").addEventListener("click", () => { summary_state.sort = null; draw_table(); });
  draw_table();
}
