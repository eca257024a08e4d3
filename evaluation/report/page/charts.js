// Plots over time of one object: errors, IoU, semi-axes against truth.
const chart_state = { scene: null, object: null, variants: new Set(variants.filter((v) => output_of(v) === "")), seeds: new Set(data.seeds), log: false, time: null };
let charts = [];

function series_of(scene, object) {
  return data.cells.filter((cell) => cell.scene === scene)
    .flatMap((cell) => cell.series.filter((s) => s.object === object).map((s) => ({ cell, ...s })));
}

// What frames.csv has of an object in a run; undefined where it has nothing.
const series_in = (run, object) => data.cells.find((c) => c.scene === run.scene && c.variant === run.variant && c.seed === run.seed)?.series.find((s) => s.object === object);

const has_values = (list) => list?.some((value) => value !== null);

// Times count from the scene's first stamp, in all its plots and pictures.
function scene_start_ns(scene) {
  return Math.min(...data.cells.filter((cell) => cell.scene === scene)
    .flatMap((cell) => cell.series.map((s) => s.stamps_ns[0] ?? Infinity)));
}

function points(series, column, start_ns) {
  const values = series.columns[column];
  const at = (i) => (values.length === 1 ? values[0] : values[i]) ?? NaN;
  return series.stamps_ns.map((stamp, i) => ({ x: (stamp - start_ns) / 1e9, y: at(i), frame: series.frames[i] }));
}

function line(label, list, color, width, extra = {}) {
  return { label, data: list, borderColor: color, backgroundColor: color, borderWidth: width, pointRadius: 0,
    pointHoverRadius: 3, pointHitRadius: 0, spanGaps: false, ...extra };
}

function datasets(plot, all, start_ns) {
  const shown = all.filter((s) => chart_state.variants.has(s.cell.variant) && chart_state.seeds.has(s.cell.seed));
  const sets = shown.filter((s) => has_values(s.columns[plot.column])).map((s) => {
    const fade = data.seeds.length > 1 ? Math.max(0x70, 0xff - 0x40 * data.seeds.indexOf(s.cell.seed)) : 0xff;
    return line(`${s.cell.variant} · seed ${s.cell.seed}`, points(s, plot.column, start_ns),
      variant_color(s.cell.variant) + fade.toString(16), 1.6, { borderDash: output_dash(s.cell.variant) });
  });
  const longest = all.filter((s) => plot.truth && has_values(s.columns[plot.truth]))
    .sort((a, b) => b.stamps_ns.length - a.stamps_ns.length)[0];
  if (longest) sets.unshift(line("truth", points(longest, plot.truth, start_ns), css("--ink"), 1.5, { borderDash: [5, 4] }));
  return sets; // the first is drawn last, over the others
}

// The moment that image and 3D show; where the scene has neither, the time pointed at.
const marked_time = () => (motion_state.scene === chart_state.scene ? motion_time(motion_state.index) : chart_state.time);

// A vertical line at the marked time, in all plots.
const crosshair = {
  id: "crosshair",
  afterDraw(chart) {
    const { x, y } = chart.scales, time = marked_time();
    if (time === null || time < x.min || time > x.max) return;
    const at = x.getPixelForValue(time), context = chart.ctx;
    context.save();
    context.strokeStyle = css("--soft");
    context.lineWidth = 1;
    context.setLineDash([2, 3]);
    context.beginPath();
    context.moveTo(at, y.top);
    context.lineTo(at, y.bottom);
    context.stroke();
    context.restore();
  },
  afterEvent(chart, { event }) {
    const { left, right } = chart.chartArea;
    const inside = event.type !== "mouseout" && event.x >= left && event.x <= right;
    const time = inside ? chart.scales.x.getValueForPixel(event.x) : null;
    if (time === chart_state.time) return;
    chart_state.time = time;
    if (motion_state.scene !== chart_state.scene) draw_marks();
    else if (time !== null) show_motion_time(chart_state.scene, time);
  },
};

function draw_marks() {
  for (const chart of charts) chart.draw();
}

function axis(options) {
  return { grid: { color: css("--line"), drawBorder: false }, ...options,
    ticks: { color: css("--soft"), maxRotation: 0, font: { size: 11 }, ...options.ticks } };
}

function chart_options(plot) {
  const log = plot.error && chart_state.log;
  const y = { type: log ? "logarithmic" : "linear", beginAtZero: !log, grace: "4%",
    ticks: { maxTicksLimit: 6, callback: (value) => (value === 0 ? "0" : String(Number(value.toPrecision(3)))) } };
  if (plot.range) Object.assign(y, { min: plot.range[0], max: plot.range[1] });
  return {
    animation: false, parsing: false, normalized: true, responsive: true, maintainAspectRatio: false,
    interaction: { mode: "nearest", axis: "x", intersect: false },
    scales: { x: axis({ type: "linear", bounds: "data", ticks: { callback: (value) => `${Number(value.toFixed(2))} s`, maxTicksLimit: 7 } }), y: axis(y) },
    plugins: { legend: { display: false }, tooltip: {
      boxPadding: 4, usePointStyle: true, itemSort: (a, b) => a.parsed.y - b.parsed.y,
      callbacks: {
        title: (items) => (items.length ? `frame ${items[0].raw.frame} · ${items[0].parsed.x.toFixed(2)} s` : ""),
        label: (item) => `${item.dataset.label}: ${format_figure(item.parsed.y)} ${plot.unit}`,
      } } },
    onClick: (event, items, chart) => jump_to(chart_state.scene, chart.scales.x.getValueForPixel(event.x)),
  };
}

function svg_text(x, y, value, anchor, extra = "") {
  const text = String(value).replaceAll("&", "&amp;").replaceAll("<", "&lt;");
  return `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" text-anchor="${anchor}"${extra}>${text}</text>`;
}

const svg_drawing = (top, width, height, parts) =>
  `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 ${top} ${width} ${height}" font-family="sans-serif" font-size="11" fill="#1d2126">${parts.join("")}</svg>\n`;

// The chart as it stands, as a drawing for a paper: text stays text.
function chart_svg(chart, title) {
  const { chartArea: area, scales: { x, y }, width, height } = chart, head = 22, parts = [];
  const label = (px, py, value, anchor) => parts.push(svg_text(px, py, value, anchor));
  parts.push(svg_text(area.left, 14 - head, title, "start", ' font-weight="bold"'));
  y.ticks.forEach((tick) => {
    const at = y.getPixelForValue(tick.value);
    parts.push(`<path d="M${area.left} ${at.toFixed(1)}H${area.right}" stroke="#ddd"/>`);
    label(area.left - 5, at + 4, tick.label, "end");
  });
  x.ticks.forEach((tick) => label(x.getPixelForValue(tick.value), area.bottom + 15, tick.label, "middle"));
  chart.data.datasets.forEach((set, i) => {
    let path = "", pen = "M";
    for (const { x: px, y: py } of set.data) {
      path += Number.isFinite(py) ? `${pen}${x.getPixelForValue(px).toFixed(1)} ${y.getPixelForValue(py).toFixed(1)}` : "";
      pen = Number.isFinite(py) ? "L" : "M";
    }
    parts.push(`<path d="${path}" fill="none" stroke="${set.borderColor.slice(0, 7)}" stroke-width="1.4" stroke-dasharray="${(set.borderDash ?? []).join(" ")}"/>`);
    parts.push(`<path d="M${area.left} ${height + 12 + 16 * i}h22" stroke="${set.borderColor.slice(0, 7)}" stroke-width="2" stroke-dasharray="${(set.borderDash ?? []).join(" ")}"/>`);
    label(area.left + 28, height + 16 + 16 * i, set.label, "start");
  });
  const bottom = height + 16 * chart.data.datasets.length + 8;
  return svg_drawing(-head, width, bottom + head, parts);
}

// Saves the drawing that `draw` makes.
function save_button(name, draw) {
  const save = () => {
    const address = URL.createObjectURL(new Blob([draw()], { type: "image/svg+xml" }));
    el("a", { href: address, download: `${name}.svg` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  };
  return el("button", { type: "button", class: "save", title: "Save this plot as an SVG file", click: save }, "SVG");
}

function plot_title(plot) {
  return `${with_unit(plot.title, plot.unit)}, ${chart_state.object} in ${chart_state.scene}`;
}

function draw_charts() {
  for (const chart of charts) chart.destroy();
  const all = series_of(chart_state.scene, chart_state.object);
  const start_ns = scene_start_ns(chart_state.scene);
  const plots = data.plots.filter((plot) => all.some((s) => has_values(s.columns[plot.column])));
  const canvases = plots.map(() => el("canvas", { role: "img" }));
  by_id("charts").replaceChildren(...plots.map((plot, i) => {
    canvases[i].setAttribute("aria-label", `${plot.title} of ${chart_state.object} in ${chart_state.scene} over time`);
    return el("figure", {}, el("figcaption", {}, plot.title, " ", el("small", {}, plot.unit ? `[${plot.unit}]` : ""),
        save_button(`${chart_state.scene}_${chart_state.object}_${plot.column}`, () => chart_svg(charts[i], plot_title(plot)))),
      el("div", { class: "plot" }, canvases[i]));
  }));
  if (plots.length === 0) by_id("charts").replaceChildren(el("p", {}, "No frames with results."));
  charts = plots.map((plot, i) => new Chart(canvases[i], { type: "line", plugins: [crosshair],
    data: { datasets: datasets(plot, all, start_ns) }, options: chart_options(plot) }));
}
