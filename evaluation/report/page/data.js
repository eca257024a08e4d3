"use strict";
// The page's data and small helpers that every part uses.
const data = JSON.parse(document.getElementById("data").textContent);
for (const { spread } of [...data.summary, ...data.overall]) // of a single run there is a number alone
  for (const [name, s] of Object.entries(spread)) if (typeof s === "number") spread[name] = { median: s, min: s, max: s, n: 1, best: false, mean: s, values: [s], interval: null };
const metric_of = new Map(data.metrics.map((metric) => [metric.name, metric]));

data.cells = data.cells.map((cell) => ({ output: "", message: "", not_isolated: false, stage_ms: {}, sizes: [], series: [], ...cell }));

// An element with attributes (functions become listeners) and children.
function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(name, value);
    else if (value !== null && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

// Of an even number the mean of the middle two; undefined of none.
function median_of(values) {
  const sorted = [...values].sort((a, b) => a - b), n = sorted.length;
  return n ? (sorted[(n - 1) >> 1] + sorted[n >> 1]) / 2 : undefined;
}

// The index of the stamp nearest to a time, the first of equals.
const nearest_index = (stamps_ns, time_ns) => stamps_ns.reduce((best, s, i) => (Math.abs(s - time_ns) < Math.abs(stamps_ns[best] - time_ns) ? i : best), 0);

const by_id = (id) => document.getElementById(id);
const distinct = (list) => [...new Set(list)];
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const with_unit = (label, unit) => (unit ? `${label} [${unit}]` : label);

// As the tables of report.md: two to four digits, no exponent for ordinary sizes.
function format_figure(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-4 || size >= 1e6) return value.toExponential(2);
  return value.toFixed(size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 0.1 ? 3 : size >= 0.001 ? 4 : 5);
}

// Two digits, for ranges.
function format_short(value) {
  const size = Math.abs(value);
  return size === 0 ? "0" : size < 1e-4 || size >= 1e6 ? value.toExponential(1)
    : size >= 100 ? value.toFixed(0) : value.toPrecision(2);
}

// Colours that keep apart for the colour-blind (Okabe and Ito), one a variant, the same in every part of the page.
const kColors = {
  light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#56a3d9", "#7a3db8", "#5c6670"],
  dark: ["#4aa8e8", "#ff8f3f", "#35cfa0", "#e89ac4", "#e8d24a", "#8cccf5", "#b98aef", "#a5adb5"],
};
const dark_mode = window.matchMedia("(prefers-color-scheme: dark)");
const variants = distinct(data.cells.map((cell) => cell.variant));
const output_of = (variant) => variant.split("@")[1] ?? "";
const own_name = (variant) => variant.split("@")[0];
const own_names = distinct(variants.map(own_name));
function variant_color(variant) {
  const colors = dark_mode.matches ? kColors.dark : kColors.light;
  return colors[own_names.indexOf(own_name(variant)) % colors.length];
}
// Later outputs of a variant have its colour, and dashes.
const output_dash = (variant) => ({ fixed_lag: [7, 3], final: [2, 3] })[output_of(variant)] ?? [];

// A row of buttons of which one (with `many` any number) is pressed; `change` gets the pressed values.
function chips(parent, label, values, pressed, { many = false, text = String, color = null, change }) {
  const chosen = new Set(pressed);
  const draw = () => {
    const buttons = values.map((value) => el("button", {
      type: "button", "aria-pressed": String(chosen.has(value)), click: () => press(value),
    }, color ? el("i", { style: `background:${color(value)}` }) : null, text(value)));
    parent.replaceChildren(...(label ? [el("span", {}, label)] : []), ...buttons);
  };
  const press = (value) => {
    if (many) chosen.delete(value) || chosen.add(value);
    else if (!chosen.has(value)) (chosen.clear(), chosen.add(value));
    draw();
    parent.querySelectorAll("button")[values.indexOf(value)].focus();
    change(values.filter((v) => chosen.has(v)));
  };
  draw();
}
