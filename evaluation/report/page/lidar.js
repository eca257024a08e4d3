// The paper's LiDAR route against Embree: a table, and a histogram of range errors a scene.
const kLidarColumns = [
  ["scene", (r) => r.scene], ["seed", (r) => r.seed, true], ["scans", (r) => r.scans, true],
  ["completeness", (r) => r.completeness.toFixed(4), true], ["extra", (r) => r.extra, true],
  ["mean [m]", (r) => format_figure(r.mean_m), true], ["rms [m]", (r) => format_figure(r.rms_m), true],
  ["median |error| [m]", (r) => format_figure(r.median_abs_m), true], ["95 % [m]", (r) => format_figure(r.p95_abs_m), true],
  ["octree [ms/scan]", (r) => lidar_figure(r.octree_ms), true], ["Embree [ms/scan]", (r) => lidar_figure(r.embree_ms), true],
  ["Embree is faster by", (r) => lidar_figure(r.speed_ratio), true],
];
let lidar_charts = [];

function lidar_figure(value) {
  return value === null ? "–" : format_figure(value);
}

function lidar_chart(canvas, routes) {
  const sets = routes.map((r, i) => line(`seed ${r.seed}`, r.errors.map(([x, beams]) => ({ x, y: (100 * beams) / r.matched })),
    kColors[dark_mode.matches ? "dark" : "light"][i % kColors.light.length], 1.5, { stepped: "middle", fill: i === 0 ? "origin" : false }));
  if (sets.length > 0) sets[0].backgroundColor = `${sets[0].borderColor}40`;
  return new Chart(canvas, { type: "line", data: { datasets: sets }, options: {
    animation: false, parsing: false, normalized: true, responsive: true, maintainAspectRatio: false,
    interaction: { mode: "nearest", axis: "x", intersect: false },
    scales: { x: axis({ type: "linear", bounds: "data", ticks: { callback: (value) => `${Number(value.toFixed(2))} m`, maxTicksLimit: 7 } }),
      y: axis({ type: "linear", beginAtZero: true, ticks: { maxTicksLimit: 6, callback: (value) => `${Number(value.toPrecision(3))} %` } }) },
    plugins: { legend: { display: false }, tooltip: { callbacks: {
      title: (items) => (items.length ? `error ${items[0].parsed.x.toFixed(2)} m` : ""),
      label: (item) => `${item.dataset.label}: ${format_figure(item.parsed.y)} % of the points`,
    } } },
  } });
}

function draw_lidar() {
  const all = data.lidar, shown = distinct(all.map((r) => r.scene));
  for (const chart of lidar_charts) chart.destroy();
  by_id("lidar").hidden = all.length === 0;
  document.querySelector('nav a[href="#lidar"]').hidden = all.length === 0;
  const cell = (tag, text, number) => el(tag, { class: number ? "number" : null }, String(text));
  const table = by_id("lidar-table");
  table.tHead.replaceChildren(el("tr", {}, ...kLidarColumns.map(([name, , number]) => cell("th", name, number))));
  table.tBodies[0].replaceChildren(...all.map((r) => el("tr", {}, ...kLidarColumns.map(([, text, number]) => cell("td", text(r), number)))));
  const canvases = shown.map((scene) => el("canvas", { role: "img", "aria-label": `Histogram of range errors in ${scene}` }));
  by_id("lidar-charts").replaceChildren(...shown.map((scene, i) => {
    const beyond = all.filter((r) => r.scene === scene).map((r) => `${format_figure((100 * r.beyond) / Math.max(1, r.matched))} %`);
    return el("figure", {}, el("figcaption", {}, `Range error, ${scene} `, el("small", {}, `cells of 1 cm; beyond the plot: ${beyond.join(", ")}`),
        save_button(`${scene}_range_error`, () => chart_svg(lidar_charts[i], `Range error [m], ${scene}`))),
      el("div", { class: "plot" }, canvases[i]));
  }));
  lidar_charts = shown.map((scene, i) => lidar_chart(canvases[i], all.filter((r) => r.scene === scene)));
}
