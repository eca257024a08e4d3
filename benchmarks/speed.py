#!/usr/bin/env python3
"""Runs the benchmarks one after another and writes a page of what they say: scripts/speed calls it."""
import argparse
import os
import pathlib
import subprocess
import tempfile
import time

import speed_runs as runs

AIM = 0.8  # of bare Embree and bare OSMesa

MODES = {
    "quick": dict(rounds=5, rays=[10, 5], fineness=[0.25], render=(20, 1), frames=60, growth=[30, 60, 120],
                  objects=[1, 2, 4], object_frames=20),
    "medium": dict(rounds=10, rays=[20, 10, 5, 2.5], fineness=[0.25, 0.5, 2], render=(40, 2), frames=150,
                   growth=[100, 300, 1000], objects=[1, 2, 4, 8, 16, 32], object_frames=30),
    "full": dict(rounds=50, rays=[20, 10, 5, 2.5, 1], fineness=[0.25, 0.5, 2], render=(100, 3), frames=300,
                 growth=[100, 300, 1000, 3000], objects=[1, 2, 4, 8, 16, 32], object_frames=90),
}

RATIOS = """
- **LiDAR to bare Embree**: what a scan's pattern, motion, placing of bodies and points leave of
  `rtcIntersect8` over the same rays, ready in packets.
- **Render to bare OSMesa**: what sensors' errors and files leave of a loop that draws the same passes and
  reads them back. They cost a frame the same whatever it shows, and so weigh most where drawing is quick.
- **3D IoU to its arithmetic**: the same additions and multiplications on what registers hold, two doubles at a
  time (SSE2, the compiler's baseline); ours loads 100,000 points and takes four at a time where there is AVX2.
  Exact IoU, without samples:
  {exact_us:.0f} us.
- **Windows to minimal problems**: what our factors, losses and manifolds leave of Ceres with trivial costs
  in as many blocks and residuals, by the same solver in as many iterations. Building the problems is not in
  it, nor what the windows do besides: for that the stages of `estimate` below.
- **Files to raw PNG encoding**: the time of OpenCV's encoder (zlib level 0, to memory) over ours for the
  same pixels; above 1 we are quicker.
"""


def table(head, rows):
    ruler = ["---"] + ["---:"] * (len(head) - 1)
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ruler, *rows]) + "\n"


def against(ratio):
    return f"{AIM}: " + ("met" if ratio >= AIM else f"short by {AIM - ratio:.2f}")


def at_most(growth, limit):
    return f"Aim: up to {limit}, {'met' if growth <= limit else 'not met'}."


def ratio_section(scan, scenes, work):
    iou, png, rows = runs.google("iou_speed"), runs.google("png_speed"), []

    def row(stage, ours, peer, ratio, aim="none set"):
        rows.append([stage, ours, peer, f"{ratio:.2f}", aim])

    bare = f"bare Embree {scan['bare_ns']:.0f} ns"
    for what, key in (("LiDAR: a scan", "whole"), ("LiDAR: a scan with noise", "noise")):
        ratio = scan[key + "_ratio"]
        row(what, f"{scan[key + '_ns']:.0f} ns a ray", bare, ratio, against(ratio))
    for f in scenes:
        bare, triangles = f"bare OSMesa {f['bare_ms']:.1f} ms", f"{f['triangles']:.0f} triangles"
        for what, ms, ratio in (("drawing", f["draw"], f["drawing"]),
                                ("sensors' errors and files too", f["frame_ms"], f["whole"])):
            row(f"render, {triangles}: {what}", f"{ms:.1f} ms", bare, ratio, against(ratio))
    ours, peer = iou["monte_carlo"], iou["monte_carlo_arithmetic"]
    row("3D IoU, 100,000 samples", f"{1e3 * ours:.0f} us", f"its arithmetic {1e3 * peer:.0f} us",
        peer / ours)
    for name, w in runs.windows(f"{work}/data/sequence").items():
        row(f"{name} window, mean of {w['solves']:.0f}: {w['residuals']:.0f} residuals, {w['blocks']:.0f} "
            f"blocks, {w['iterations']:.1f} iterations", f"{w['ours_ms']:.2f} ms",
            f"minimal problem {w['minimal_ms']:.2f} ms", w["ratio"])
    for kind in ("colour", "depth"):
        peer = png[f"encoder/{kind}"]
        for what, key in (("encoded", "encode"), ("encoded and written", "file")):
            ours = png[f"ours/{kind}_{key}"]
            row(f"{kind} image {what}", f"{ours:.2f} ms", f"raw PNG encoder {peer:.2f} ms", peer / ours)
    return ("## Each stage against its limit\nRatio: the limit's or peer's time over ours, in one run; 1 is "
            "as fast. Processor time of one thread.\n\n" +
            table(["stage", "time", "limit or peer", "ratio", "aim"], rows) +
            RATIOS.format(exact_us=1e3 * iou["exact"]))


def pipeline_section(frames, work):
    rows, fps = [], {}

    def row(name, threads, result):
        fps[name, threads] = frames / result.wall_s, frames / result.cpu_s
        rows.append([name, str(threads), f"{frames / result.wall_s:.1f}", f"{frames / result.cpu_s:.1f}",
                     f"{result.peak_mb:.0f}"])

    for threads in (1, 2):
        row("simulate, level `real`", threads,
            runs.simulate(runs.SCENE, f"{work}/real", frames, threads, "real"))
        row("simulate", threads, runs.simulate(runs.SCENE, f"{work}/data", frames, threads))
        row("estimate", threads, runs.estimate(f"{work}/data", f"{work}/estimate{threads}", threads))
    row("evaluate", 1, runs.run(runs.PROGRAM, "evaluate", "-q", f"{work}/data/truth", f"{work}/estimate2",
                                  f"{work}/evaluation", "--force"))
    stages = sorted(runs.stage_ms(f"{work}/estimate1", frames).items(), key=lambda item: -item[1])
    by_wall, by_core = fps["estimate", 1]
    met = "met" if by_wall >= 20 else f"short by {20 - by_wall:.1f}"
    real = fps["simulate, level `real`", 2][0] / fps["simulate", 2][0]
    return (f"## Frames per second\n`{runs.SCENE}` (640x480, two objects), {frames} frames, "
            f"`{runs.VARIANT}`; files, start and end of each program are in it.\n\n" +
            table(["program", "threads", "frames/s", "frames in 1 s of processor time", "peak memory [MB]"],
                  rows) +
            f"\nOn two threads level `real` makes {real:.2f} of the frames of `ideal` (aim: 0.6). It draws colour "
            "twice, with shadows, in four bands of rows; colour is half of a frame's time at `ideal`.\n"
            f"\nThe aim of `estimate` is 20 frames/s: {met} by the clock with one thread; by the processor's "
            f"time, which other programs disturb less, {by_core:.1f}. Its stages by `timing.csv`, one "
            "thread:\n\n" +
            table(["stage", "ms a frame", "frames/s by itself"],
                  [[name, f"{ms:.2f}", f"{1e3 / ms:.0f}"] for name, ms in stages if ms > 0.005]))


def growth(work, objects, frames):
    """A row a run, of `objects` boxes over `frames` frames: both programs' ms a frame and MB."""
    runs.grid_scene(f"{work}/grid.yaml", objects)
    sim = runs.simulate(f"{work}/grid.yaml", f"{work}/grid", frames)
    est = runs.estimate(f"{work}/grid", f"{work}/grid_estimate", 1)
    return [1e3 * sim.cpu_s / frames, 1e3 * est.cpu_s / frames, sim.peak_mb, est.peak_mb]


def growth_table(head, all_rows):
    return table([head, "simulate [ms a frame]", "estimate [ms a frame]", "simulate, peak [MB]",
                  "estimate, peak [MB]"],
                 [[str(n), f"{r[0]:.1f}", f"{r[1]:.1f}", f"{r[2]:.0f}", f"{r[3]:.0f}"]
                  for n, r in all_rows.items()])


def object_section(counts, frames, work):
    rows = {n: growth(work, n, frames) for n in counts}
    most, text = max(counts), ""
    for which, name in enumerate(("simulate", "estimate")):
        ms = {n: row[which] for n, row in rows.items()}
        mean, last = (ms[most] - ms[1]) / (most - 1), (ms[most] - ms[most // 2]) / (most - most // 2)
        text += (f"- `{name}`: {last:.2f} ms for each of the last {most - most // 2} objects, {mean:.2f} ms "
                 f"for one of all beyond the first: {last / mean:.2f} times (linear 1, quadratic 1.5). "
                 f"{at_most(last / mean, 1.2)}\n")
    return (f"## Objects\nBoxes of one size in a grid, {frames} frames, those in the middle first; processor "
            "time, the programs' starts in it.\n\n" + growth_table("objects", rows) + "\n" + text)


def frame_section(counts, work):
    rows, text = {n: growth(work, 2, n) for n in counts}, ""
    for which, name in ((2, "simulate"), (3, "estimate")):
        peak = {n: row[which] for n, row in rows.items()}
        ratio = peak[counts[-1]] / peak[counts[0]]
        kb = 1e3 * (peak[counts[-1]] - peak[counts[-2]]) / (counts[-1] - counts[-2])
        text += (f"- `{name}`: {ratio:.2f} times the memory for {counts[-1] / counts[0]:.0f} times the "
                 f"frames; each of the last {counts[-1] - counts[-2]} costs {max(0, kb):.0f} kB. "
                 f"{at_most(ratio, 1.1)}\n")
    return ("## Frames\nTwo boxes of the grid; processor time. Of `simulate` the memory is that of its "
            "largest process, of which there is one a core.\n\n" +
            growth_table("frames", rows) + "\n" + text +
            "\nWhat grows in `estimate` is mostly the map that the camera is followed by "
            "(`ego: {source: rgbd}`).\n")


def scan_row(figure, scan):
    return [f"{scan[figure]:.0f}", f"{scan['whole_ns']:.0f}", f"{scan['bare_ns']:.0f}",
            f"{scan['whole_ratio']:.2f}", against(scan["whole_ratio"])]


def size_section(mode, scan, scenes):
    rounds = max(3, mode["rounds"] // 2)
    by_rate = [scan if rate == 10 else runs.lidar(rounds, 1, rate) for rate in mode["rays"]]
    by_size = sorted([scan] + [runs.lidar(rounds, f) for f in mode["fineness"]], key=lambda s: s["triangles"])
    head = ["ns a ray", "bare Embree [ns]", "ratio", "aim"]
    rays = by_rate[-1]["rays"] / by_rate[0]["rays"]
    slower = by_rate[-1]["whole_ns"] / by_rate[0]["whole_ns"]
    bare = by_rate[-1]["bare_ns"] / by_rate[0]["bare_ns"]
    drawn = [[f"{f['triangles']:.0f}", f"{f['draw']:.1f}", f"{f['bare_ms']:.1f}", f"{f['drawing']:.2f}",
              f"{f['fps']:.1f}"] for f in scenes]
    return ("## Rays\nLonger and longer scans of `livox_avia`, without noise, one thread.\n\n" +
            table(["rays a scan", *head], [scan_row("rays", s) for s in by_rate]) +
            f"\n{slower:.2f} times the time a ray for {rays:.0f} times the rays (bare Embree: {bare:.2f}). "
            f"{at_most(slower, 1.2)}\n\n## Triangles\nOf the LiDAR's course:\n\n" +
            table(["triangles", *head], [scan_row("triangles", s) for s in by_size]) +
            "\nPattern, path and points cost a ray much the same whatever it meets, and so weigh most where "
            "there is little to meet.\n\nOf the drawn scene:\n\n" +
            table(["triangles", "drawing [ms]", "bare OSMesa [ms]", "ratio", "simulate [frames/s]"], drawn) +
            "\n## Threads\n`simulate` and `estimate`: above. A LiDAR scan on all cores takes "
            f"{1 / scan['gain']:.2f} of the time on one, and {scan['work']:.2f} times the processor time.\n")


def machine():
    with open("/proc/cpuinfo") as file:
        names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    return f"{os.cpu_count()} cores" + (f" of {names[0]}" if names else "")


def commit():
    def git(*words):
        return subprocess.run(["git", *words], capture_output=True, text=True).stdout.strip()

    changed = git("status", "--porcelain", "-uno", "--", ":!results")
    return git("rev-parse", "--short", "HEAD") + (" with changes" if changed else "")


def busy_s():
    """Of all cores together, whoever worked; and of the programs that this one has run."""
    with open("/proc/stat") as file:
        user, nice, system = map(int, file.readline().split()[1:4])
    ours = os.times()
    return (user + nice + system) / os.sysconf("SC_CLK_TCK"), ours.children_user + ours.children_system


def main():
    parser = argparse.ArgumentParser(prog="scripts/speed")
    parser.add_argument("--quick", dest="mode", action="store_const", const="quick", default="full")
    parser.add_argument("--medium", dest="mode", action="store_const", const="medium")
    parser.add_argument("page", nargs="?", type=pathlib.Path, default="results/speed.md")
    options = parser.parse_args()
    mode, version, start, busy_before = MODES[options.mode], commit(), time.monotonic(), busy_s()
    with tempfile.TemporaryDirectory(prefix="speed.") as work:
        pipeline = pipeline_section(mode["frames"], work)
        scan, scenes = runs.lidar(mode["rounds"]), runs.rendering(*mode["render"])
        sections = [ratio_section(scan, scenes, work), pipeline,
                    object_section(mode["objects"], mode["object_frames"], work),
                    frame_section(mode["growth"], work), size_section(mode, scan, scenes)]
    took_s, (busy, ours) = time.monotonic() - start, (b - a for a, b in zip(busy_before, busy_s()))
    flag = "" if options.mode == "full" else f" --{options.mode}"
    others = max(0, busy - ours) / took_s
    head = (f"# Speed\n```\nscripts/speed{flag}\n```\nwrites this page, here in {took_s / 60:.1f} minutes on "
            f"{machine()}, at commit {version}. Other programs kept {others:.1f} cores busy meanwhile, which "
            "slows down what is by the clock: frames/s, the stages of `estimate`, and what threads gain.\n\n")
    aside = options.page.with_name(options.page.name + ".partial")
    aside.parent.mkdir(parents=True, exist_ok=True)
    aside.write_text(head + "\n".join(sections))
    aside.rename(options.page)
    print(f"speed: {options.page}")


main()
