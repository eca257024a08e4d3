"""Tables of results/ pages, made from the scores that scripts/results keeps.

A block of a page is `<!-- KIND BENCH key=value .. -->`, then what is made, then `<!-- end -->`. Kinds:
  made    [of=medians]                    commit, command and seeds of the bench, and what its figures are
  table   metrics= [scenes= objects= variants= outputs=]    means over seeds
  claim   than= better= metric= [output= scenes= objects= margin=]   a paired comparison and a verdict
  level   variant= metric= level=0.8 | object:0.8,.. [output= scenes= verdict=no]   a figure against a level
  section heading=                        a section of the bench's report.md
  spread  metrics= [variants= outputs=]   median and worst tenth over the scenes of a family, and failures
  ablation of= metrics= [outputs=]        every other variant against `of`, pair by pair, by group
  success variant= [output= groups= plot=FILE.svg]   share of scene-objects that are followed well, by group
A group of scenes is what bears the same name but for the seed at its end, as families do.
"""
import csv
import functools
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
    "ape_of_distance_rmse": ("APE.t of distance", 1, 4),
    "iou3d_box_mean": ("IoU box", 1, 3),
    "hota": ("HOTA", 1, 3),
    "false_bodies": ("false bodies", 1, 1),
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
WHOLE = ("hota", "false_bodies")  # metrics of a scene, not of an object
# Student's t at 97.5 %, by degrees of freedom
T = [0, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131]


class PageError(Exception):
    """What a page asks for and the scores do not have."""


class MissingScores(PageError):
    """A bench that has not been run."""


def kept(name, ending):
    file = SCORES / f"{name}.{ending}"
    if not file.exists():
        raise MissingScores(f"Not run yet: `scripts/results --page {name}`")
    return file


@functools.cache
def read_scores(name):
    """(scene, object, variant, output, metric) -> {seed: value}; the value is None where a run failed."""
    values = {}
    with gzip.open(kept(name, "csv.gz"), "rt") as lines:
        for row in csv.DictReader(lines):
            variant, _, output = row["variant"].partition("@")
            key = (row["sequence"], row["object"], variant, output, row["metric"])
            values.setdefault(key, {})[int(row["seed"])] = float(row["value"]) if row["value"] else None
    return values


def interval(values):
    """Mean and half its 95 % confidence interval (Student's t), which is infinite for a single value."""
    if len(values) > len(T):
        raise PageError(f"{len(values)} values; Student's t is listed for {len(T)}")
    half = T[len(values) - 1] * statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.inf
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
    text = f"{mean:.{digits}f}" + (f" ± {half:.{digits}f}" if math.isfinite(half) else "")
    return text if len(good) == len(values) else f"{text} ({len(good)}/{len(values)})"


def chosen(options, key, every):
    return options[key].split(",") if key in options else every


def table(name, options):
    scores = read_scores(name)
    rows = list(dict.fromkeys(key[:4] for key in scores))
    metrics = options["metrics"].split(",")
    outputs = chosen(options, "outputs", ["causal", "fixed_lag"])
    scenes, variants = (chosen(options, key, {row[place] for row in rows}) for key, place in (("scenes", 0), ("variants", 2)))
    objects = chosen(options, "objects", {row[1] for row in rows} - {"camera", "all"})
    lines = ["| scene | object | variant | known | " + " | ".join(column(m)[0] for m in metrics) + " |",
             "|---|---|---|---|" + "---:|" * len(metrics)]
    for row in rows:
        scene, item, variant, output = row
        if scene in scenes and variant in variants and item in objects and (output or "causal") in outputs:
            cells = [cell(scores.get((*row, metric), {}), metric) for metric in metrics]
            lines.append(f"| {scene} | {item} | {variant} | {OUTPUTS[output]} | " + " | ".join(cells) + " |")
    if len(lines) == 2:
        raise PageError(f"{name}: no row of the table {options}")
    return "\n".join(lines)


def is_error(metric):
    """Errors compare by their ratio, shares by their difference."""
    return metric.endswith(("_m", "_rad", "_deg"))


def objects_of(scores, variants, output, metric, options):
    """(scene, object) of which any of the variants has runs."""
    found = dict.fromkeys((scene, item) for scene, item, variant, *rest in scores
                          if variant in variants and rest == [output, metric] and item not in ("camera", "all")
                          and scene in chosen(options, "scenes", [scene])
                          and item in chosen(options, "objects", [item]))
    missing = set(variants) - {key[2] for key in scores}
    if missing or not found:
        raise PageError(f"no scores of {', '.join(missing) or metric} for {options}")
    return list(found)


def output_of(options):
    output = options.get("output", "causal").replace("causal", "")
    if output not in OUTPUTS:
        raise PageError(f"there is no output {output}")
    return output


def gain(than, better, metric):
    """Above 0 where `better` is."""
    return math.log(max(than, 1e-9) / max(better, 1e-9)) if is_error(metric) else better - than


def pooled(gains):
    """The mean over objects for each seed that all of them have."""
    seeds = set.intersection(*(set(of_object) for of_object in gains)) if gains else set()
    return [statistics.fmean(of_object[seed] for of_object in gains) for seed in sorted(seeds)]


def sign_of(values, beyond=0.0):
    """1 or -1 where the whole interval lies above or below a value, else 0."""
    if not values:
        return 0
    mean, half = interval(values)
    return 1 if mean - half > beyond else -1 if mean + half < beyond else 0


def gain_text(values, metric):
    """A mean gain with its interval: of errors as the ratio of `better` to `than`."""
    if not values:
        return "-"
    mean, half = interval(values)
    if is_error(metric):
        return f"x {math.exp(-mean):.3f} ({math.exp(-mean - half):.3f} to {math.exp(-mean + half):.3f})"
    return f"{mean:+.3f} ± {half:.3f}"


def claim(name, options):
    scores = read_scores(name)
    than, better, metric, output = options["than"], options["better"], options["metric"], output_of(options)
    margin = float(options.get("margin", 0))
    heading = column(metric)[0]
    lines = [f"| scene | object | pairs | {heading}: {than} | {better} | {'ratio' if is_error(metric) else 'difference'} |",
             "|---|---|---:|---:|---:|---:|"]
    gains, lost = [], 0
    for scene, item in objects_of(scores, (than, better), output, metric, options):
        a, b = (scores.get((scene, item, variant, output, metric), {}) for variant in (than, better))
        pairs = {s: gain(a[s], b[s], metric) for s in b if b[s] is not None and a.get(s) is not None}
        lost += sum(1 for s in a if a[s] is not None and b.get(s) is None)
        gains.append(pairs)
        lines.append(f"| {scene} | {item} | {len(pairs)} | {cell(a, metric)} | {cell(b, metric)} | "
                     f"{gain_text(list(pairs.values()), metric)} |")
    all_values = pooled([pairs for pairs in gains if pairs])
    lines.append(f"| all | mean over objects | {len(all_values)} | | | **{gain_text(all_values, metric)}** |")
    signs = [sign_of(list(pairs.values()), -margin) for pairs in gains]
    text = f"{'no worse' if margin else 'better'} on {signs.count(1)}, worse on {signs.count(-1)} of {len(signs)} objects"
    if lost:
        text += f"; {better} has no figure in {lost} runs where {than} has"
    return "\n".join(lines) + f"\n\n**Verdict: {verdict(sign_of(all_values, -margin), signs, lost, margin)}** ({text})."


def verdict(sign, signs, lost, margin):
    """Of a claim that something is better, or with a margin, no worse than by that. Runs that were lost say
    nothing good of it."""
    if sign < 0:
        return "refuted"
    if sign == 0 or lost:
        return "not decided"
    word = f"reproduced, within a margin of {margin:g}" if margin else "reproduced"
    return word if -1 not in signs else word + " on the mean, not on every object"


def level(name, options):
    scores = read_scores(name)
    variant, metric, output = options["variant"], options["metric"], output_of(options)
    levels = dict(pair.split(":") for pair in options["level"].split(",") if ":" in pair)
    if is_error(metric) and not levels:
        raise PageError("an error has a level for each object")
    heading, factor, digits = column(metric)
    lines = [f"| scene | object | {heading} of {variant} | level |", "|---|---|---:|---:|"]
    margins = []
    for scene, item in objects_of(scores, (variant,), output, metric, options):
        if levels and item not in levels:
            continue
        values = scores[scene, item, variant, output, metric]
        limit = float(levels.get(item, 0) if levels else options["level"])
        margins.append({s: (limit - v if is_error(metric) else v - limit) for s, v in values.items() if v is not None})
        lines.append(f"| {scene} | {item} | {cell(values, metric)} | {factor * limit:.{digits}f} |")
    signs = [sign_of(list(of.values())) for of in margins]
    if levels:  # each object has its own
        sign = signs[0] if len(set(signs)) == 1 else 0
        word = "in part" if 1 in signs and -1 in signs else {1: "reproduced", 0: "not decided", -1: "refuted"}[sign]
    else:
        mean, half = interval(pooled([of for of in margins if of]))
        lines.append(f"| all | mean over objects | {mean + float(options['level']):.3f} ± {half:.3f} | {options['level']} |")
        word = "reproduced" if mean - half > 0 else "refuted" if mean + half < 0 else "not decided"
    count = f"on the good side: {signs.count(1)} of {len(signs)} objects"
    if options.get("verdict") == "no":
        return "\n".join(lines) + f"\n\nAll of the interval {count}."
    return "\n".join(lines) + f"\n\n**Verdict: {word}** ({count})."


def group_of(scene):
    return re.sub(r"_\d+$", "", scene)


def by_group(scores, variants, outputs):
    """(group, variant, output) -> {(scene, object, seed): {metric: value}}, in the order of the scores."""
    groups = {}
    for (scene, item, variant, output, metric), values in scores.items():
        if variant in variants and (output or "causal") in outputs:
            of_group = groups.setdefault((group_of(scene), variant, output), {})
            for seed, value in values.items():
                of_group.setdefault((scene, item, seed), {})[metric] = value
    return groups


def of_objects(rows):
    return [row for (_, item, _), row in rows.items() if item not in ("camera", "all")]


def quantile(values, share):
    """The smallest value that so large a share is no greater than."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


def spread_cell(rows, metric):
    _, factor, digits = column(metric)
    values = [row[metric] for row in rows if row.get(metric) is not None]
    if not values:
        return "-"
    lower_is_better = is_error(metric) or metric in ("ape_of_distance_rmse", "false_bodies")
    worst = quantile(values, 0.9) if lower_is_better else quantile(values, 0.1)
    return f"{factor * statistics.median(values):.{digits}f} ({factor * worst:.{digits}f})"


def spread(name, options):
    scores = read_scores(name)
    metrics = options["metrics"].split(",")
    variants = chosen(options, "variants", {key[2] for key in scores})
    groups = by_group(scores, variants, chosen(options, "outputs", ["causal"]))
    if not groups:
        raise PageError(f"{name}: no row of the spread {options}")
    lines = ["| scenes | variant | known | objects | never found | " + " | ".join(column(m)[0] for m in metrics) + " |",
             "|---|---|---|---:|---:|" + "---:|" * len(metrics)]
    for (group, variant, output), rows in groups.items():
        objects = of_objects(rows)
        lost = sum(1 for row in objects if not row.get("coverage"))
        whole = [row for (_, item, _), row in rows.items() if item == "all"]
        cells = [spread_cell(whole if metric in WHOLE else objects, metric) for metric in metrics]
        lines.append(f"| {group} | {variant} | {OUTPUTS[output]} | {len(objects)} | {lost} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def change_cell(pairs, metric):
    """By how much the second of each pair differs: the mean, how often it is better and worse, and how often it has no
    figure where the first has."""
    both = [(a, b) for a, b in pairs if a is not None and b is not None]
    lost = sum(1 for a, b in pairs if a is not None and b is None)
    if not both:
        return f"{lost} lost" if lost else "-"
    gains = [gain(a, b, metric) for a, b in both]
    mean = statistics.fmean(gains)
    counts = f"{sum(g > 0 for g in gains)}:{sum(g < 0 for g in gains)}" + (f", {lost} lost" if lost else "")
    return (f"x {math.exp(-mean):.2f}" if is_error(metric) else f"{mean:+.3f}") + f" ({counts})"


def ablation(name, options):
    scores, base, metrics = read_scores(name), options["of"], options["metrics"].split(",")
    variants = list(dict.fromkeys(key[2] for key in scores))
    outputs = chosen(options, "outputs", ["causal"])
    groups = by_group(scores, variants, outputs)
    names = list(dict.fromkeys(group for group, *_ in groups))
    if base not in variants:
        raise PageError(f"{name}: no variant {base}")
    lines = ["| variant | known | " + " | ".join(f"{group}: {column(m)[0].partition(' [')[0]}" for group in names for m in metrics) + " |",
             "|---|---|" + "---:|" * (len(names) * len(metrics))]
    for variant in variants:
        for output in dict.fromkeys(key[2] for key in groups):
            cells = []
            for group in names:
                before, after = (groups.get((group, v, output), {}) for v in (base, variant))
                for metric in metrics:
                    rows = [key for key in before if (key[1] == "all") == (metric in WHOLE) and key[1] != "camera"]
                    cells.append(change_cell([(before[key].get(metric), after.get(key, {}).get(metric)) for key in rows], metric))
            if variant != base:
                lines.append(f"| {variant} | {OUTPUTS[output]} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def is_success(row):
    """Followed well: the boxes overlap by 0.7, and the centre is off by less than 5 % of the distance."""
    box, off = row.get("iou3d_box_mean"), row.get("ape_of_distance_rmse")
    return box is not None and off is not None and box > 0.7 and off < 0.05


def successes(name, options):
    """(group, objects followed well, objects) of a success block."""
    output = output_of(options)
    groups = by_group(read_scores(name), [options["variant"]], [output or "causal"])
    for group in chosen(options, "groups", [key[0] for key in groups]):
        rows = of_objects(groups.get((group, options["variant"], output), {}))
        if not rows:
            raise PageError(f"{name}: no scenes of the group {group}")
        yield group, sum(map(is_success, rows)), len(rows)


def success(name, options):
    lines = ["| scenes | followed well |", "|---|---:|"]
    lines += [f"| {group} | {good} of {count} |" for group, good, count in successes(name, options)]
    plot = [f"![share followed well]({options['plot']})", ""] if "plot" in options else []
    return "\n".join(plot + lines)


def wilson(good, count):
    """The 95 % interval of a share (Wilson, JASA 1927)."""
    z = 1.96
    middle = (good + z * z / 2) / (count + z * z)
    half = z * math.sqrt(good * (count - good) / count + z * z / 4) / (count + z * z)
    return middle - half, middle + half


def success_plot(rows):
    """An SVG of shares from 0 to 1 with their intervals, a group a row."""
    left, width, step, top = 190, 420, 26, 46
    bottom = top + step * len(rows)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + width + 30} {bottom + 30}" role="img" '
             'aria-label="share of objects followed well, by scenes">',
             "<style>text{font:12px sans-serif;fill:#1d2126}.back{fill:#fff}.grid{stroke:#e2dfd9}"
             ".bar{stroke:#0072b2;stroke-width:2}.dot{fill:#0072b2}"
             "@media(prefers-color-scheme:dark){text{fill:#e8e6e3}.back{fill:#1c2024}.grid{stroke:#2f353b}"
             ".bar{stroke:#4aa8e8}.dot{fill:#4aa8e8}}</style>",
             '<rect class="back" width="100%" height="100%"/>',
             f'<text x="{left}" y="20">share of objects followed well; bars: 95 % interval (Wilson)</text>']
    for tick in range(0, 11, 2):
        x = left + width * tick / 10
        parts.append(f'<path class="grid" d="M{x:.0f} {top - 14}V{bottom - 8}"/>'
                     f'<text x="{x:.0f}" y="{bottom + 10}" text-anchor="middle">{tick / 10:g}</text>')
    for k, (group, good, count) in enumerate(rows):
        y = top + step * k
        low, high = (left + width * share for share in wilson(good, count))
        parts.append(f'<text x="{left - 10}" y="{y + 4}" text-anchor="end">{group} ({count})</text>'
                     f'<path class="bar" d="M{low:.1f} {y}H{high:.1f}"/>'
                     f'<circle class="dot" cx="{left + width * good / count:.1f}" cy="{y}" r="4"/>')
    return "\n".join(parts + ["</svg>", ""])


def section(name, options):
    """The section of report.md whose heading begins with the words given, underscores for blanks."""
    heading = options["heading"].replace("_", " ")
    text = gzip.decompress(kept(name, "report.md.gz").read_bytes()).decode()
    found = re.search(rf"^## {re.escape(heading)}.*?\n(.*?)(?=^## |\Z)", text, re.S | re.M)
    if not found:
        raise PageError(f"the report of {name} has no section '{heading}'")
    return found[1].strip()


def made(name, options):
    figures = {"means": "Means over seeds of root mean squares or means over frames, ± half the 95 % confidence interval "
                        "(Student's t).",
               "medians": "Medians over objects and, in brackets, the worst tenth.",
               "pairs": "Mean changes over objects; in brackets, how many are better and worse."}
    return kept(name, "txt").read_text().strip() + " " + figures[options.get("of", "means")]


# kind: (what makes it, the keys it needs, those that it may have)
KINDS = {
    "made": (made, set(), {"of"}),
    "table": (table, {"metrics"}, {"scenes", "objects", "variants", "outputs"}),
    "claim": (claim, {"than", "better", "metric"}, {"output", "scenes", "objects", "margin"}),
    "level": (level, {"variant", "metric", "level"}, {"output", "scenes", "verdict"}),
    "section": (section, {"heading"}, set()),
    "spread": (spread, {"metrics"}, {"variants", "outputs"}),
    "ablation": (ablation, {"of", "metrics"}, {"outputs"}),
    "success": (success, {"variant"}, {"output", "groups", "plot"}),
}
BLOCK = re.compile(r"(<!-- (\w+) (\S+)((?: \S+=\S+)*) -->\n)(.*?)(<!-- end -->)", re.S)


def benches_of(text):
    return [match[3] for match in BLOCK.finditer(text)]


def options_of(match):
    return dict(option.split("=", 1) for option in match[4].split())


def plots_of(text):
    """file: SVG of each block of a page that has a plot; none of benches that have not been run."""
    plots = {}
    for match in BLOCK.finditer(text):
        options = options_of(match)
        if "plot" in options and (SCORES / f"{match[3]}.csv.gz").exists():
            plots[options["plot"]] = success_plot(list(successes(match[3], options)))
    return plots


def with_tables(text):
    """A page's text, its blocks made anew; those of benches that have not been run say so."""
    def block(match):
        kind, name = match[2], match[3]
        options = options_of(match)
        if kind not in KINDS:
            raise PageError(f"there is no block of the kind {kind}")
        make, needed, possible = KINDS[kind]
        if not needed <= set(options) <= needed | possible:
            raise PageError(f"a {kind} needs {', '.join(needed)} and may have {', '.join(possible)}: {match[1].strip()}")
        try:
            made_text = make(name, options)
        except MissingScores as error:
            made_text = f"*{error}.*"
        return f"{match[1]}{made_text}\n{match[6]}"
    new, count = BLOCK.subn(block, text)
    if count != text.count("<!-- end -->"):
        raise PageError("a block does not begin with <!-- KIND BENCH key=value -->")
    return new
