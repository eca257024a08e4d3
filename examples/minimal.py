#!/usr/bin/env python3
"""The smallest estimator: one box for each mask of each frame, nothing more.

usage: minimal.py SEQUENCE OUT. Needs numpy and Pillow (Debian: python3-numpy python3-pil).
The masks, depth images and camera poses of the sequence are given; see docs/own_system.md.
"""
import re
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sequence, out = Path(sys.argv[1]), Path(sys.argv[2])


def rows(name):
    return [line.split() for line in (sequence / name).read_text().splitlines() if line and line[0] != "#"]


def setting(key):  # one number of sequence.yaml
    return float(re.search(rf"\b{key}: ([-+.\de]+)", (sequence / "sequence.yaml").read_text())[1])


def rotation(x, y, z, w):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


fx, fy, cx, cy = (setting(key) for key in ("fx", "fy", "cx", "cy"))
units_per_m = setting("units_per_m")
depth_of, masks_of = ({row[0]: row[1] for row in rows(name)} for name in ("depth.txt", "masks.txt"))
poses = {row[0]: [float(number) for number in row[1:]] for row in rows("camera_given.tum")}
tracks, sizes = {}, {}
for stamp, _ in rows("rgb.txt"):
    if stamp not in depth_of or stamp not in masks_of or stamp not in poses:
        continue
    depth = np.asarray(Image.open(sequence / depth_of[stamp])) / units_per_m
    masks = np.asarray(Image.open(sequence / masks_of[stamp]))
    for label in np.unique(masks[masks > 0]):
        v, u = np.nonzero((masks == label) & (depth > 0))
        if len(u) < 50:
            continue
        z = depth[v, u]
        points = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z])
        world = rotation(*poses[stamp][3:]) @ points + np.array(poses[stamp][:3])[:, None]
        low, high = np.percentile(world, [5, 95], axis=1)  # along the world's axes
        tracks.setdefault(label, []).append((stamp, (low + high) / 2))
        sizes.setdefault(label, []).append(high - low)

(out / "objects").mkdir(parents=True, exist_ok=True)
camera = [" ".join([stamp, *map(repr, pose)]) for stamp, pose in poses.items()]
(out / "camera.tum").write_text("\n".join(camera) + "\n")
for label, states in tracks.items():
    lines = [f"{stamp} {x} {y} {z} 0 0 0 1" for stamp, (x, y, z) in states]
    (out / "objects" / f"{label}.tum").write_text("\n".join(lines) + "\n")
(out / "objects.yaml").write_text("".join(
    f"{label}: {{size_m: {np.median(size, axis=0).tolist()}}}\n" for label, size in sizes.items()))
