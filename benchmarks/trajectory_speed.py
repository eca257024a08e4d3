#!/usr/bin/env python3
"""Loading two TUM trajectories and their APE: `uniquadric trajectory`'s code against an interpreted evaluator.

usage: trajectory_speed.py TRAJECTORY_SPEED [POSES]     (the benchmark's program); needs NumPy

The interpreted evaluator is written here as such programs are: the csv module reads, a loop associates, matrices
are made and compared pose by pose, NumPy does the algebra. Both errors must agree, or there is no figure.
Processor time, best of five runs, each with reading the files; neither has the start of its process in it.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np


def write_trajectory(path, stamps, positions, quaternions):
    with open(path, "w") as file:
        for row in zip(stamps, positions, quaternions):
            file.write(f"{row[0]:.6f} " + " ".join(f"{x:.9f}" for x in (*row[1], *row[2])) + "\n")


def random_walk(rng, count):
    stamps = np.arange(count) / 30
    positions = np.cumsum(rng.normal(0, 0.02, (count, 3)), axis=0)
    quaternions = np.cumsum(rng.normal(0, 0.01, (count, 4)), axis=0) + [0, 0, 0, 1]
    return stamps, positions, quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)


def matrix_of(x, y, z, qx, qy, qz, qw):
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
        [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
        [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)],
    ]
    pose[:3, 3] = x, y, z
    return pose


def load(path):
    with open(path) as file:
        rows = [[float(cell) for cell in row] for row in csv.reader(file, delimiter=" ")]
    return np.array([row[0] for row in rows]), [matrix_of(*row[1:]) for row in rows]


def interpreted_ape(reference, estimate):
    ref_stamps, ref_poses = load(reference)
    est_stamps, est_poses = load(estimate)
    pairs = []
    for i, stamp in enumerate(ref_stamps):
        j = int(np.argmin(np.abs(est_stamps - stamp)))
        if abs(est_stamps[j] - stamp) <= 0.01:
            pairs.append((i, j))
    x = np.array([ref_poses[i][:3, 3] for i, _ in pairs])
    y = np.array([est_poses[j][:3, 3] for _, j in pairs])
    u, _, vt = np.linalg.svd((x - x.mean(0)).T @ (y - y.mean(0)))
    flip = np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    align = np.eye(4)
    align[:3, :3] = u @ flip @ vt
    align[:3, 3] = x.mean(0) - align[:3, :3] @ y.mean(0)
    errors = [np.linalg.norm((np.linalg.inv(ref_poses[i]) @ align @ est_poses[j])[:3, 3]) for i, j in pairs]
    return float(np.sqrt(np.mean(np.square(errors))))


def best_of_five(run):
    seconds = []
    for _ in range(5):
        start = time.process_time()
        value = run()
        seconds.append(time.process_time() - start)
    return min(seconds), value


def main():
    program, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20000
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        reference, estimate = pathlib.Path(folder, "ref.tum"), pathlib.Path(folder, "est.tum")
        stamps, positions, quaternions = random_walk(rng, count)
        write_trajectory(reference, stamps, positions, quaternions)
        write_trajectory(estimate, stamps, positions + rng.normal(0, 0.01, positions.shape), quaternions)
        text = subprocess.run([program, reference, estimate], capture_output=True, check=True).stdout
        theirs_s, theirs = best_of_five(lambda: interpreted_ape(reference, estimate))
    ours, ours_s = map(float, text.split())
    if abs(ours - theirs) > 1e-6 * theirs:
        sys.exit(f"the two disagree: {ours} and {theirs}")
    print(f"{count} poses, APE {ours:.6f} m: uniquadric {ours_s:.3f} s, interpreted {theirs_s:.3f} s, "
          f"{theirs_s / ours_s:.0f} times")


main()
