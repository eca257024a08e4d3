"""What scripts/speed runs: benchmarks and the program itself, and the figures in what they print and take.

Figures come from the benchmarks' own lines, from timing.csv, and from what the system says of a process when
it has ended: its time, and the most memory that it had.
"""
import collections
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

BUILD = pathlib.Path("build/release")
PROGRAM = BUILD / "harness/uniquadric"
VARIANT = "configs/variants/superquadric.yaml"
SCENE = "scenes/cube_cuboid.yaml"

Run = collections.namedtuple("Run", "text wall_s cpu_s peak_mb")


def run(*command):
    command = [str(word) for word in command]
    print("speed:", " ".join(command), file=sys.stderr, flush=True)
    with tempfile.TemporaryFile("w+") as output:
        start = time.monotonic()
        child = subprocess.Popen(command, stdout=output)
        _, status, usage = os.wait4(child.pid, 0)
        wall_s = time.monotonic() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read()
    if child.returncode != 0:
        sys.exit(f"speed: {' '.join(command)} ended with {child.returncode}")
    return Run(text, wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def numbers(pattern, text):
    """Of the groups of its only match."""
    found = re.search(pattern, text)
    if not found:
        sys.exit(f"speed: nothing like '{pattern}' in:\n{text}")
    return [float(group) for group in found.groups()]


def lidar(rounds, fineness=1, rate_hz=10):
    text = run(BUILD / "benchmarks/lidar_speed", rounds, "livox_avia", fineness, rate_hz).text
    figures = {}
    figures["rays"], figures["triangles"] = numbers(r"(\d+) rays, (\d+) triangles", text)
    for key, row in [("bare", "bare Embree loop, 1 thread"), ("whole", "whole scan, 1 thread"),
                     ("noise", "whole scan with noise")]:
        figures[key + "_ns"], figures[key + "_ratio"] = numbers(
            row + r".* ([\d.]+) ns a ray +([\d.]+) of", text)
    figures["gain"], figures["work"] = numbers(r"threads: ([\d.]+) times.*time ([\d.]+) of", text)
    return figures


def rendering(frames, rounds):
    """Figures of each of two scenes: as it is, and of many triangles."""
    scenes = []
    for part in run(BUILD / "benchmarks/simulation_speed", SCENE, frames, rounds).text.split("scene ")[1:]:
        figures = {name: float(ms) for name, ms in
                   re.findall(r"(\w+) ([\d.]+)", re.search(r"ms =(.*);", part).group(1))}
        for name, pattern in [("triangles", r"(\d+) triangles"), ("bare_ms", r"bare loop ([\d.]+) ms"),
                              ("frame_ms", r"time a frame ([\d.]+) ms"), ("fps", r"written +([\d.]+) fps"),
                              ("whole", r"bare over simulate: ([\d.]+)"), ("drawing", r"alone ([\d.]+)")]:
            figures[name], = numbers(pattern, part)
        scenes.append(figures)
    return scenes


def google(program):
    """Processor milliseconds of each benchmark."""
    text = run(BUILD / "benchmarks" / program, "--benchmark_format=json", "--benchmark_min_time=0.5").text
    unit = {"ns": 1e-6, "us": 1e-3, "ms": 1.0}
    return {b["name"]: b["cpu_time"] * unit[b["time_unit"]] for b in json.loads(text)["benchmarks"]}


def windows(sequence):
    """Means over the solves of each window."""
    text = run(BUILD / "benchmarks/window_speed", sequence, VARIANT).text
    names = ("solves", "residuals", "blocks", "iterations", "ours_ms", "minimal_ms", "ratio")
    pattern = (r" window: (\d+) solves, (\d+) residuals, (\d+) blocks, ([\d.]+) iterations each: "
               r"([\d.]+) ms, minimal ([\d.]+) ms, ratio ([\d.]+)")
    return {window: dict(zip(names, numbers(window + pattern, text))) for window in ("short", "long")}


def grid_scene(path, objects):
    """Boxes of one size in a grid of 8 x 4 that turn each in its place; those in the middle come first."""
    cells = sorted(((i - 3.5) * 0.42, 1.5 + (j - 1.5) * 0.5) for i in range(8) for j in range(4))
    cells.sort(key=lambda cell: cell[0] ** 2 + (cell[1] - 1.5) ** 2)
    text = """name: grid
rate_hz: 30
camera:
  motion: {kind: circle, center_m: [0, -3, 1.5], normal: [0, 1, 0], radius_m: 0.2, rate_degps: 40,
           facing: target, look_at_m: [0, 0, 1.5]}
world:
  - {name: room, primitive: room, size_m: [8, 8, 4]}
objects:
"""
    for k, (x, z) in enumerate(cells[:objects]):
        text += f"""  - id: {k + 1}
    name: box{k + 1}
    primitive: rounded_box
    size_m: [0.3, 0.24, 0.26]
    motion: {{kind: screw, rate_degps: {20 + k % 5 * 3}, axis: [0, {k % 2}, 1],
             start: {{position_m: [{x:.2f}, {k % 3 * 0.05:.2f}, {z:.2f}]}}}}
"""
    pathlib.Path(path).write_text(text)


def simulate(scene, out, frames, threads=0, level="ideal"):
    return run(PROGRAM, "simulate", "-q", scene, out, "--frames", frames, "--threads", threads, "--force",
               "--set", f"realism={level}")


def estimate(data, out, threads):
    return run(PROGRAM, "estimate", "-q", f"{data}/sequence", out, "--variant", VARIANT,
               "--threads", threads, "--force")


def stage_ms(folder, frames):
    """Milliseconds a frame of each stage of an estimate."""
    sums = collections.Counter()
    with open(f"{folder}/timing.csv") as file:
        for row in csv.DictReader(file):
            sums[row["stage"]] += float(row["ms"])
    return {stage: ms / frames for stage, ms in sums.items()}
