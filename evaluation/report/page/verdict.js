// The first screen: which variant wins, how sure that is, and what was compared on what.
const causal_variants = variants.filter((v) => !v.includes("@"));

// How a variant fares against a baseline, by objects; null where the two were not compared.
function duel(baseline, variant) {
  const found = data.verdicts.find((v) => v.baseline === baseline && v.variant === variant);
  const of = (...names) => found.objects.filter((o) => names.includes(o.verdict));
  const count_of_all = (...names) => names.reduce((sum, name) => sum + (found.counts[name] ?? 0), 0);
  const groups = { better: ["better", "mended"], worse: ["worse", "lost"], mixed: ["mixed"], alike: ["alike"] };
  const made = (make) => Object.fromEntries(Object.entries(groups).map(([name, verdicts]) => [name, make(...verdicts)]));
  if (!found || Object.keys(found.counts).length === 0) return null;
  return { ...found, ...made(of), count: { ...made(count_of_all), all: count_of_all(...Object.values(groups).flat()) } }; // the objects shown, and the number of all
}

// The same comparison with the two exchanged.
function mirrored(d) {
  const other = { better: "worse", worse: "better" }, turned = (verdict) => other[verdict] ?? verdict;
  return { ...d, baseline: d.variant, variant: d.baseline, better: d.worse, worse: d.better, count: { ...d.count, better: d.count.worse, worse: d.count.better },
    metrics: d.metrics.map((c) => ({ ...c, a: c.b, b: c.a, verdict: turned(c.verdict), p_better: c.p_worse, p_worse: c.p_better })) };
}

// Of many variants only the first is a baseline: where it is ahead, its comparisons are the others' turned round.
function duel_either_way(baseline, variant) {
  const there = duel(baseline, variant), back = there ? null : duel(variant, baseline);
  return back ? mirrored(back) : there;
}

// The best first: by the number of others that it beats on more objects than it loses, then by how many more.
function ranked_variants() {
  const score = (variant) => causal_variants.map((other) => duel(other, variant)).filter(Boolean)
    .reduce(([wins, lead], { count }) => [wins + (count.better > count.worse), lead + count.better - count.worse], [0, 0]);
  return causal_variants.map((variant, i) => ({ variant, i, score: score(variant) }))
    .sort((a, b) => b.score[0] - a.score[0] || b.score[1] - a.score[1] || a.i - b.i).map(({ variant }) => variant);
}

const count_of = (n, noun) => `${n} ${noun}${n === 1 ? "" : "s"}`;

// "cube, ball and skateboard", or how many where there are more than three.
function names_of(objects, count) {
  if (count > 3) return count_of(count, "object");
  const repeated = (o) => subjects.filter((s) => s.object === o.object).length > 1;
  const names = objects.map((o) => (repeated(o) ? `${o.object} (${o.scene})` : o.object));
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}

const variant_name = (variant) => el("span", { class: "variant", style: `--color:${variant_color(variant)}` }, ...with_swatch(el("i", {}), variant));

// Who is ahead and, unless it is short, on what it is not.
function duel_sentence(d, short) {
  const { baseline, variant, count } = d;
  const lead = Math.sign(count.better - count.worse), of = ` of ${count_of(count.all, "object")}`;
  const names = [variant_name(variant), [" is worse than ", " is level with ", " is better than "][lead + 1], variant_name(baseline)];
  const part = (text, kind) => (count[kind] ? [`${text} on ${names_of(d[kind], count[kind])}`] : []);
  const rest = [...(lead <= 0 ? part("better", "better") : []), ...(lead >= 0 ? part("worse", "worse") : []), ...part("mixed", "mixed"), ...part("alike", "alike")].join("; ");
  return [...names, lead ? ` on ${count[lead > 0 ? "better" : "worse"]}${of}` : ` over ${count_of(count.all, "object")}`, short || !rest ? "." : `; ${rest}.`];
}

// What the paired test says of all objects together.
function proof_sentence(d) {
  const label = (c) => `${metric_of.get(c.metric).label} ${format_figure(c.a)} → ${format_figure(c.b)}`;
  const of = (verdict, p) => d.metrics.filter((c) => c.subjects === "objects" && c.verdict === verdict && c[p] !== null).map((c) => `${label(c)} (p ${format_short(c[p])})`);
  const gains = of("better", "p_better"), losses = d.metrics.filter((c) => c.subjects === "objects" && c.verdict === "worse").map(label);
  const pairs = Math.max(0, ...d.metrics.map((c) => c.pairs)), few = d.metrics.every((c) => c.verdict === "not judged");
  if (few) return `Each object is judged by the gate's margin. For a test over all objects, ${count_of(pairs, "pair")} of runs are too few.`;
  return [gains.length ? `Proven over all objects, in ${count_of(pairs, "pair")} of runs: ${gains.join(", ")}.` : `No gain is proven over all objects, in ${count_of(pairs, "pair")} of runs.`,
    losses.length ? ` Worse: ${losses.join(", ")}.` : ""].join("");
}

// The 3D IoU of an object's row: of the solid where there is one.
const iou_of = (row) => (row.spread.iou3d_solid_mean ?? row.spread.iou3d_ellipsoid_mean)?.median;
const iou_label = (row) => (row?.spread.iou3d_solid_mean ? "IoU solid" : "IoU ellipsoid");
const whole_row = (variant) => data.overall.find((row) => row.scene === "all" && row.variant === variant); // where not all scenes are shown
const median_iou = (variant) => (whole_row(variant) ? iou_of(whole_row(variant)) : median_of(object_rows(variant).map(iou_of).filter((v) => v !== undefined)));
const object_rows = (variant) => data.summary.filter((row) => row.variant === variant && row.object !== "camera" && row.object !== "all");

// Of a bench with one variant: how many objects it follows.
function alone_sentence(variant) {
  const rows = object_rows(variant), good = rows.map((row) => ({ row, iou: iou_of(row) })).filter(({ iou }) => iou !== undefined);
  if (good.length === 0) return [variant_name(variant), rows.length ? " followed no object." : data.counts.failed === data.counts.runs ? " has no run with a result." : " was run on scenes without true objects."];
  const worst = good.reduce((a, b) => (b.iou < a.iou ? b : a));
  const whole = whole_row(variant), followed = whole ? (whole.spread.iou3d_solid_mean ?? whole.spread.iou3d_ellipsoid_mean).n : good.length;
  return [variant_name(variant), ` follows ${followed} of ${count_of(data.counts.objects, "object")}, with a median ${iou_label(good[0].row)} of ${format_figure(median_iou(variant))}`,
    good.length > 1 ? `; the worst is ${worst.row.object} in ${worst.row.scene}, ${format_figure(worst.iou)}.` : "."];
}

function draw_compared() {
  const { scenes, objects, runs, failed } = data.counts;
  by_id("compared").replaceChildren(`${count_of(causal_variants.length, "variant")} on ${count_of(scenes, "scene")} with ${count_of(objects, "object")}, ${count_of(data.seeds.length, "seed")}: `,
    failed ? el("b", { class: "bad" }, `${failed} of ${runs} runs have no result`) : `all ${runs} runs have a result`, ".");
}

function draw_variant_lines() {
  by_id("variant-lines").replaceChildren(...ranked_variants().flatMap((variant) => {
    const iou = median_iou(variant);
    return [el("dt", {}, variant_name(variant), el("small", {}, iou === undefined ? "no result" : `${iou_label(object_rows(variant)[0])} ${format_figure(iou)}`)),
      el("dd", {}, data.descriptions[variant] || "No description: the variant's file begins with no comment.")];
  }));
}

const kFilmStep_ms = 90;

// The variant's hardest scene of those with frames, or where no scene has any, of those with overlays.
function hardest_scene(variant, shown) {
  const rows = object_rows(variant), iou_in = (scene) => median_of(rows.filter((row) => row.scene === scene).map((row) => iou_of(row) ?? 0)) || 0;
  return shown.length ? shown.reduce((a, b) => (iou_in(b) < iou_in(a) ? b : a)) : null;
}

// The frames of the hardest scene one after the other, with the outlines of the truth and of the variant; without
// frames the overlays. A click opens the scene over time.
function start_film(variant) {
  const run_in = (scene) => motion.runs.find((run) => run.scene === scene && run.variant === variant);
  const filmed = hardest_scene(variant, scenes.filter((scene) => film_frames(scene).length > 1 && run_in(scene)));
  let index = 0;
  const scene = filmed ?? hardest_scene(variant, galleries.filter((g) => g.variant === variant && g.frames.length > 0).map((g) => g.scene));
  if (!scene) return;
  const frames = filmed ? film_frames(scene) : galleries.find((g) => g.scene === scene && g.variant === variant).frames;
  const image = by_id("film").querySelector("img"), canvas = by_id("film").querySelector("canvas"), still = window.matchMedia("(prefers-reduced-motion: reduce)");
  const show = (i) => {
    Object.assign(image, { src: source_of(frames[i]), alt: `${scene}, ${variant}: frame ${frames[i].frame} with outlines` });
    if (!filmed) return;
    const run = run_in(scene), truth = motion.truths[run.truth];
    const index = nearest_index(truth.stamps_ns, frames[i].stamp_ns);
    paint_film(canvas, image.clientWidth, scene, truth.camera[index], bodies_at(scene, index, [truth], [run]));
  };
  by_id("film").hidden = false;
  by_id("film").querySelector("figcaption").replaceChildren(scenes.length > 1 ? `The hardest scene, ${scene}` : scene, filmed ? ": dashed the truth, in colour " : ": ", variant_name(variant), ". Click to look at it over time.");
  by_id("film-open").addEventListener("click", () => {
    const there = subjects.filter((s) => s.scene === scene), iou_at = (s) => iou_of(object_rows(variant).find((row) => row.scene === scene && row.object === s.object) ?? { spread: {} }) ?? 0;
    if (there.length) show_object(there.reduce((a, b) => (iou_at(b) < iou_at(a) ? b : a)));
    show_variants([variant]);
    if (filmed) jump_in_time(scene, (frames[index].stamp_ns - scene_start_ns(scene)) / 1e9);
    by_id(there.length ? "objects" : "frames").scrollIntoView();
  });
  image.addEventListener("load", () => show(index), { once: true });
  show(0);
  setInterval(() => { if (!still.matches && !document.hidden) show((index = (index + 1) % frames.length)); }, filmed ? kFilmStep_ms : 6 * kFilmStep_ms);
}

// The object that the variant models worst, with a way there.
function weakest_line(variant) {
  const rows = object_rows(variant).filter((row) => iou_of(row) !== undefined);
  if (rows.length < 2) return [];
  const worst = rows.reduce((a, b) => (iou_of(b) < iou_of(a) ? b : a)), run = motion.runs.find((r) => r.scene === worst.scene && r.variant === variant);
  const time = run ? worst_time(run, worst.object, "iou3d_solid") ?? worst_time(run, worst.object, "iou3d") : null;
  const href = view_hash(worst.scene, worst.object, time, [variant]);
  return [el("p", {}, "Its weakest: ", el("a", { href, click: () => { if (location.hash === href) follow_address(); } }, worst.object),
    ` in ${worst.scene}, ${iou_label(worst)} ${format_figure(iou_of(worst))}.${time === null ? "" : " The link opens its worst frame."}`)];
}

// Where another variant models the surface better, each of its runs.
function behind_line(winner) {
  const score = (row) => row?.spread.surface_f1, found = [];
  for (const row of object_rows(winner).filter(score)) {
    const ahead = causal_variants.map((variant) => object_rows(variant).find((r) => r.scene === row.scene && r.object === row.object))
      .filter((other) => score(other) && score(other).min > score(row).max).sort((a, b) => score(b).median - score(a).median)[0];
    if (ahead) found.push(`${row.object} (${format_figure(score(row).median)}, ${ahead.variant} ${format_figure(score(ahead).median)})`);
  }
  return found.length ? [el("p", {}, `Another variant has the better surface F1 on ${found.slice(0, 3).join(", ")}${found.length > 3 ? ` and ${count_of(found.length - 3, "more object")}` : ""}.`)] : [];
}

// Than how many others it is better, where it was compared with several.
function lead_sentence(duels) {
  const beaten = duels.filter(({ count }) => count.better > count.worse).length;
  return duels.length > 1 ? ` It is better than ${beaten < duels.length ? `${beaten} of ${duels.length}` : beaten === 2 ? "both" : `all ${beaten}`} others.` : "";
}

function draw_verdict() {
  const [winner, ...others] = ranked_variants();
  const duels = others.map((other) => duel_either_way(other, winner)).filter(Boolean);
  by_id("verdict").replaceChildren(...(duels.length ? [...duel_sentence(duels[0], true), lead_sentence(duels)] : alone_sentence(winner)));
  by_id("verdict-more").replaceChildren(...(duels.length ? [el("p", {}, proof_sentence(duels[0])),
    ...duels.filter((d, i) => i > 0 || d.count.better < d.count.all).map((d) => el("p", {}, ...duel_sentence(d, false)))].slice(0, 4) : []), ...weakest_line(winner), ...behind_line(winner));
  draw_compared();
  draw_variant_lines();
}
