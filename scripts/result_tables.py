"""Tables of results/ pages, made from the scores that scripts/results keeps.

A block of a page is `<!-- KIND BENCH key=value .. -->`, then what is made, then `<!-- end -->`. Kinds:
  made                                    commit, command and seeds of the bench
  table   metrics= [scenes= objects= variants= outputs=]    means over seeds
  claim   than= better= metric= [output= scenes= objects= margin=]   a paired comparison and a verdict
  level   variant= metric= level=0.8 | object:0.8,.. [output= scenes=]   a figure against a level, and a verdict
  section heading=                        a section of the bench's report.md
"""
import csv
import gzip
import math
import re
import statistics
from pathlib import Path

SCORES = Path(__file__).resolve().parent.parent / "results" / "scores"

# metric: (heading, factor, digits)
COLUMNS = {
    "ape_translation_rmse_m": ("APE.t [mm]", 1e3, 2),
    "ape_translation_after_3s_rmse_m": ("APE.t after 3 s [mm]", 1e3, 2),
    "ape_translation_in_view_rmse_m": ("APE.t in view [mm]", 1e3, 2),
    "ape_rotation_rmse_rad": ("APE.r [mrad]", 1e3, 1),
    "rpe_translation_rmse_m": ("RPE.t [mm]", 1e3, 2),
    "rpe_rotation_rmse_rad": ("RPE.r [mrad]", 1e3, 2),
    "rpe_rotation_after_3s_rmse_rad": ("RPE.r after 3 s [mrad]", 1e3, 2),
    "motion_error_translation_rmse_m": ("motion.t [mm]", 1e3, 2),
    "motion_error_rotation_rmse_rad": ("motion.r [mrad]", 1e3, 2),
    "iou3d_solid_mean": ("IoU solid", 1, 3),
    "iou3d_ellipsoid_mean": ("IoU ellipsoid", 1, 3),
    "iou2d_mean": ("IoU 2D", 1, 3),
    "surface_error_median_m": ("surface error [mm]", 1e3, 1),
    "feature_depth_median_m": ("feature depth [mm]", 1e3, 1),
    "drift_max_translation_m": ("drift.t [m]", 1, 4),
    "drift_max_angle_deg": ("drift.r [deg]", 1, 2),
    "coverage": ("coverage", 1, 3),
    "octree_completeness": ("completeness", 1, 4),
    "octree_error_median_m": ("median error [mm]", 1e3, 1),
    "octree_error_rms_m": ("rms error [mm]", 1e3, 0),
    "octree_time_ratio": ("Embree is faster by", 1, 1),
}
OUTPUTS = {"": "at each frame", "fixed_lag": "1 s later", "final": "offline smoothing"}
# Student's t at 97.5 %, by degrees of freedom
T = [0, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131]


class PageError(Exception):
    """What a page asks for and the scores do not have."""


def read_scores(name):
    """(scene, object, variant, output, metric) -> {seed: value}; the value is None where a run failed."""
    file = SCORES / f"{name}.csv.gz"
    if not file.exists():
        raise PageError(f"{file.name} is missing; run scripts/results --page {name}")
    values = {}
    with gzip.open(file, "rt") as lines:
        for row in csv.DictReader(lines):
            variant, _, output = row["variant"].partition("@")
            key = (row["sequence"], row["object"], variant, output, row["metric"])
            values.setdefault(key, {})[int(row["seed"])] = float(row["value"]) if row["value"] else None
    return values


def interval(values):
    """Mean and half its 95 % confidence interval (Student's t); half is None without two values."""
    half = None
    if 1 < len(values) <= len(T):
        half = T[len(values) - 1] * statistics.stdev(values) / math.sqrt(len(values))
    return statistics.fmean(values), half


def column(metric):
    if metric not in COLUMNS:
        raise PageError(f"no column for the metric {metric}")
    return COLUMNS[metric]


def cell(values, metric):
    """Mean and half interval as text, and how many runs have a figure, unless all do."""
    _, factor, digits = column(metric)
    good = [factor * value for value in values.values() if value is not None]
    if not good:
        return "-"
    mean, half = interval(good)
    text = f"{mean:.{digits}f}" + (f" ± {half:.{digits}f}" if half is not None else "")
    return text if len(good) == len(values) else f"{text} ({len(good)}/{len(values)})"


def chosen(options, key, every):
    return options[key].split(",") if key in options else every


def table(name, options):
    scores = read_scores(name)
    rows = list(dict.fromkeys(key[:4] for key in scores))
    metrics = options["metrics"].split(",")
    outputs = chosen(options, "outputs", ["causal", "fixed_lag"])
    lines = ["| scene | object | variant | known | " + " | ".join(column(m)[0] for m in metrics) + " |",
             "|---|---|---|---|" + "---:|" * len(metrics)]
    for row in rows:
        scene, item, variant, output = row
        if (scene in chosen(options, "scenes", [scene]) and variant in chosen(options, "variants", [variant])
                and item in chosen(options, "objects", [item] if item not in ("camera", "all") else [])
                and (output or "causal") in outputs):
            cells = [cell(scores.get((*row, metric), {}), metric) for metric in metrics]
            lines.append(f"| {scene} | {item} | {variant} | {OUTPUTS[output]} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def is_error(metric):
    """Errors compare by their ratio, shares by their difference."""
    return metric.endswith(("_m", "_rad", "_deg"))


def objects_of(scores, variant, output, metric, options):
    return [(scene, item) for scene, item, *rest in scores
            if rest == [variant, output, metric] and item not in ("camera", "all")
            and scene in chosen(options, "scenes", [scene]) and item in chosen(options, "objects", [item])]


def gain(than, better, metric):
    """Above 0 where `better` is."""
    return math.log(max(than, 1e-9) / max(better, 1e-9)) if is_error(metric) else better - than


def pooled(gains):
    """The mean over objects for each seed that all of them have."""
    seeds = set.intersection(*(set(of_object) for of_object in gains)) if gains else set()
    return [statistics.fmean(of_object[seed] for of_object in gains) for seed in sorted(seeds)]


def gain_text(values, metric):
    """A mean gain with its interval: of errors as the ratio of `better` to `than`."""
    if not values:
        return "-", 0
    mean, half = interval(values)
    half = half if half is not None else math.inf
    sign = 1 if mean - half > 0 else -1 if mean + half < 0 else 0
    if is_error(metric):
        return f"x {math.exp(-mean):.3f} ({math.exp(-mean - half):.3f} to {math.exp(-mean + half):.3f})", sign
    return f"{mean:+.3f} ± {half:.3f}", sign


def claim(name, options):
    scores = read_scores(name)
    than, better, metric = options["than"], options["better"], options["metric"]
    output = options.get("output", "causal").replace("causal", "")
    margin = float(options.get("margin", 0))
    heading = column(metric)[0]
    lines = [f"| scene | object | pairs | {heading}: {than} | {better} | {'ratio' if is_error(metric) else 'difference'} |",
             "|---|---|---:|---:|---:|---:|"]
    gains, signs = [], []
    for scene, item in objects_of(scores, better, output, metric, options):
        a = scores.get((scene, item, than, output, metric), {})
        b = scores[scene, item, better, output, metric]
        pairs = {s: gain(a[s], b[s], metric) for s in b if b[s] is not None and a.get(s) is not None}
        text, sign = gain_text(list(pairs.values()), metric)
        if pairs:
            gains.append(pairs)
            signs.append(sign)
        lines.append(f"| {scene} | {item} | {len(pairs)} | {cell(a, metric)} | {cell(b, metric)} | {text} |")
    all_values = pooled(gains)
    text, sign = gain_text(all_values, metric)
    lines.append(f"| all | mean over objects | {len(all_values)} | | | **{text}** |")
    count = f"better on {signs.count(1)}, worse on {signs.count(-1)} of {len(signs)} objects"
    return "\n".join(lines) + f"\n\n**Verdict: {verdict(all_values, sign, signs, margin)}** ({count})."


def verdict(values, sign, signs, margin):
    """Of a claim that something is better, or with a margin, no worse than by that."""
    if margin:
        mean, half = interval(values)
        if mean - half > -margin:
            return f"reproduced, within a margin of {margin:g}"
        return "refuted" if mean + half < -margin else "not decided"
    if sign > 0:
        return "reproduced" if -1 not in signs else "reproduced on the mean, not on every object"
    return "refuted" if sign < 0 else "not decided"


def level(name, options):
    scores = read_scores(name)
    variant, metric = options["variant"], options["metric"]
    output = options.get("output", "causal").replace("causal", "")
    levels = dict(pair.split(":") for pair in options["level"].split(",") if ":" in pair)
    wanted = [(s, i) for s, i in objects_of(scores, variant, output, metric, options) if not levels or i in levels]
    heading, factor, digits = column(metric)
    lines = [f"| scene | object | {heading} of {variant} | level |", "|---|---|---:|---:|"]
    margins = []
    for scene, item in wanted:
        values = scores[scene, item, variant, output, metric]
        limit = float(levels.get(item, options["level"] if not levels else 0))
        good = {s: (limit - v if is_error(metric) else v - limit) for s, v in values.items() if v is not None}
        margins.append(good)
        lines.append(f"| {scene} | {item} | {cell(values, metric)} | {factor * limit:.{digits}f} |")
    signs = [gain_text(list(of.values()), "share")[1] for of in margins]
    mean, half = interval(pooled(margins))
    if levels:  # each object has its own
        word = "reproduced" if set(signs) == {1} else "refuted" if 1 not in signs else "reproduced in part"
    else:
        lines.append(f"| all | mean over objects | {mean + float(options['level']):.3f} ± {half:.3f} | {options['level']} |")
        word = "reproduced" if mean - half > 0 else "refuted" if mean + half < 0 else "not decided"
    return "\n".join(lines) + f"\n\n**Verdict: {word}** (on the good side: {signs.count(1)} of {len(signs)} objects)."


def section(name, options):
    """The section of report.md whose heading begins with the words given, underscores for blanks."""
    heading = options["heading"].replace("_", " ")
    text = (SCORES / f"{name}.report.md").read_text()
    found = re.search(rf"^## {re.escape(heading)}.*?\n(.*?)(?=^## |\Z)", text, re.S | re.M)
    if not found:
        raise PageError(f"{name}.report.md has no section '{heading}'")
    return found[1].strip()


def made(name, _):
    return (SCORES / f"{name}.txt").read_text().strip()


KINDS = {"table": table, "made": made, "claim": claim, "level": level, "section": section}
BLOCK = re.compile(rf"(<!-- ({'|'.join(KINDS)}) (\S+)((?: \S+=\S+)*) -->\n)(.*?)(<!-- end -->)", re.S)


def with_tables(text):
    """A page's text, its blocks made anew."""
    def block(match):
        options = dict(option.split("=", 1) for option in match[4].split())
        return f"{match[1]}{KINDS[match[2]](match[3], options)}\n{match[6]}"
    return BLOCK.sub(block, text)
