// Variants side by side: of each object the runs' figures, their mean and its 95 % confidence interval.
const ablation_state = { metric: null };
const kLogarithmicFrom = 20; // times between the greatest and the least

// Objects with two variants or more that have the metric, cameras that were given left out: [{scene, object, rows}].
function ablation_groups(metric) {
  const groups = new Map();
  for (const row of data.summary.filter((r) => metric in r.spread && !r.given)) {
    const key = JSON.stringify([row.scene, row.object]);
    groups.set(key, [...(groups.get(key) ?? []), row]);
  }
  return [...groups.values()].filter((rows) => rows.length > 1).map((rows) => ({ scene: rows[0].scene, object: rows[0].object, rows }));
}

// The mean's 95 % interval; of IoU and coverage within what they can be.
function interval_of({ mean, interval }, lower_is_better) {
  const half = interval ?? 0;
  return lower_is_better ? [mean - half, mean + half] : [Math.max(0, mean - half), Math.min(1, mean + half)];
}

// The round numbers from `from` to `to`, two at least.
function round_marks(from, to) {
  for (let step = round_length((to - from) / 3); ; step /= 2) {
    const first = Math.ceil(from / step), count = Math.floor(to / step) - first + 1;
    if (count >= 2) return Array.from({ length: count }, (_, i) => (first + i) * step);
  }
}

// Where a value lies on an axis, in per cent, and the axis' round marks.
function ablation_axis(spreads, lower_is_better) {
  const values = spreads.flatMap((s) => s.values), least = Math.min(...values), greatest = Math.max(...values);
  if (lower_is_better && least > 0 && greatest / least > kLogarithmicFrom) {
    const from = Math.log10(least) - 0.1, to = Math.log10(Math.max(greatest, ...spreads.map((s) => s.mean + (s.interval ?? 0)))) + 0.1;
    const decades = Array.from({ length: Math.ceil(to) - Math.floor(from) }, (_, i) => 10 ** (Math.floor(from) + i));
    const of_each = (factors) => decades.flatMap((d) => factors.map((f) => f * d)).filter((v) => v >= 10 ** from && v <= 10 ** to);
    const powers = of_each([1]); // of little more than a decade there may be one
    return { at: (v) => (100 * ((v > 0 ? Math.max(from, Math.log10(v)) : from) - from)) / (to - from), marks: powers.length > 1 ? powers : of_each([1, 2, 5]) };
  }
  const ends = spreads.flatMap((s) => [...interval_of(s, lower_is_better), ...s.values]);
  const low = Math.min(...ends), high = Math.max(...ends), margin = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
  const from = low - margin, to = high + margin;
  return { at: (v) => (100 * (v - from)) / (to - from), marks: round_marks(from, to) };
}

function ablation_row({ variant, spread }, metric, axis_of) {
  const s = spread[metric.name], { at, marks } = axis_of, mark = (name, left, extra = "") => el("i", { class: name, style: `left:${left}%;${extra}` });
  const [low, high] = interval_of(s, metric.better === "lower"), half = s.interval, range = half === null ? "of one run" : `± ${format_short(half)} (95 %) of ${s.n} runs`;
  return el("div", { class: "ablation-row", style: `--color:${variant_color(variant)}`, title: `${variant}: mean ${format_figure(s.mean)} ${range}` },
    el("span", {}, variant.replaceAll("_", "_\u200b")), // a long name breaks after an underscore
    el("div", { class: "track" }, ...marks.map((m) => mark("tick", at(m))),
      half === null ? null : mark("interval", at(low), `width:${at(high) - at(low)}%`),
      ...s.values.map((v) => mark("seed", at(v))), mark("mean", at(s.mean))),
    el("span", {}, format_figure(s.mean)));
}

// The figure as a drawing for a paper.
function ablation_svg({ scene, object, rows }, metric) {
  const left = 170, plot = 300, line = 20, lower = metric.better === "lower", { at, marks } = ablation_axis(rows.map((row) => row.spread[metric.name]), lower);
  const x = (value) => left + (plot * at(value)) / 100, bottom = 30 + line * rows.length;
  const parts = [svg_text(0, 14, `${with_unit(metric.label, metric.unit)}, ${object} in ${scene}`, "start", ' font-weight="bold"'),
    ...marks.flatMap((m) => [`<path d="M${x(m).toFixed(1)} 24V${bottom}" stroke="#ddd"/>`, svg_text(x(m), bottom + 14, Number(m.toPrecision(3)), "middle")])];
  rows.forEach(({ variant, spread }, i) => {
    const s = spread[metric.name], y = 34 + line * i, color = variant_color(variant), [low, high] = interval_of(s, lower).map(x);
    parts.push(svg_text(left - 8, y + 4, variant, "end"), svg_text(left + plot + 8, y + 4, format_figure(s.mean), "start"));
    if (s.interval !== null) parts.push(`<path d="M${low.toFixed(1)} ${y}H${high.toFixed(1)}" stroke="${color}" stroke-width="2"/>`);
    parts.push(...s.values.map((v) => `<circle cx="${x(v).toFixed(1)}" cy="${y}" r="2.5" fill="none" stroke="${color}"/>`),
      `<circle cx="${x(s.mean).toFixed(1)}" cy="${y}" r="4" fill="${color}"/>`);
  });
  return svg_drawing(0, left + plot + 60, bottom + 22, parts);
}

function ablation_figure(group, metric) {
  const { scene, object, rows } = group, save = save_button(`${scene}_${object}_${metric.name}`, () => ablation_svg(group, metric));
  const axis_of = ablation_axis(rows.map((row) => row.spread[metric.name]), metric.better === "lower");
  const labels = axis_of.marks.map((m) => el("span", { style: `left:${axis_of.at(m)}%` }, String(Number(m.toPrecision(3)))));
  return el("figure", {}, el("figcaption", {}, object, " ", el("small", {}, scene), save), ...rows.map((row) => ablation_row(row, metric, axis_of)),
    el("div", { class: "ablation-row" }, el("span", {}), el("div", { class: "scale" }, ...labels), el("span", {})));
}

function draw_ablation() {
  if (ablation_state.metric) // camera and tracking last, as in the table
    by_id("ablation-plots").replaceChildren(...ablation_groups(ablation_state.metric.name).map((group) => ablation_figure(group, ablation_state.metric)));
}

function start_ablation() {
  const shown = data.metrics.filter((m) => data.summary_metrics.includes(m.name) && ablation_groups(m.name).length > 0);
  by_id("ablation").hidden = shown.length === 0;
  document.querySelector('nav a[href="#ablation"]').hidden = shown.length === 0;
  if (shown.length === 0) return;
  ablation_state.metric = shown.find((m) => m.name === "iou3d_solid_mean") ?? shown.find((m) => m.name === "iou3d_ellipsoid_mean") ?? shown[0];
  chips(by_id("ablation-metrics"), "", shown, [ablation_state.metric], { text: (m) => with_unit(m.label, m.unit),
    change: ([metric]) => { ablation_state.metric = metric; draw_ablation(); } });
  draw_ablation();
}
