#!/usr/bin/env python3
"""An opponent: every rigid object is followed by ICP on its masked depth points.

usage: icp_tracker.py SEQUENCE OUT. Needs numpy and Open3D (Debian: python3-numpy python3-open3d).

Camera: RGB-D odometry (Park, Zhou, Koltun, ICCV 2017, as Open3D has it) on what no mask covers, from keyframe to
frame. Objects: the points under a mask are registered by point-to-plane ICP with the object's model, which is all of
its points so far; the first guess is constant velocity. Size: the oriented box of the model. Everything is causal:
the state of a frame depends on it and on earlier ones alone. Masks count at their own frames, whatever their latency.
"""
import re
import sys
from dataclasses import dataclass, field
from itertools import permutations, product
from pathlib import Path

import numpy as np
import open3d as o3d

MIN_POINTS = 60
VOXELS_A_SIZE = 25  # of the model, along the diagonal of the first view
KEYFRAME_SHIFT = 0.05  # of the scene's median depth
KEYFRAME_TURN_RAD = 0.1
ROTATIONS = [m for m in (np.diag(s)[list(p)] for p in permutations(range(3)) for s in product((1, -1), repeat=3))
             if np.linalg.det(m) > 0]  # the 24 of a box


class Sequence:
    """The images of a sequence folder, depth in metres."""

    def __init__(self, folder):
        self.folder = Path(folder)
        text = (self.folder / "sequence.yaml").read_text()
        number = lambda key: float(re.search(rf"\b{key}: ([-+.\de]+)", text)[1])
        self.units_per_m = number("units_per_m")
        size = int(number("width")), int(number("height"))
        self.intrinsic = o3d.camera.PinholeCameraIntrinsic(*size, *(number(key) for key in ("fx", "fy", "cx", "cy")))
        self.stamps = [row[0] for row in self.rows("rgb.txt")]
        self.files = {kind: {row[0]: row[1] for row in self.rows(f"{kind}.txt")} for kind in ("rgb", "depth", "masks")}

    def rows(self, name):
        lines = (self.folder / name).read_text().splitlines()
        return [line.split() for line in lines if line and line[0] != "#"]

    def image(self, kind, stamp):
        name = self.files[kind].get(stamp)
        return None if name is None else np.asarray(o3d.io.read_image(str(self.folder / name)))

    def depth(self, stamp):
        image = self.image("depth", stamp)
        return None if image is None else image.astype(np.float32) / self.units_per_m


@dataclass
class Camera:
    """Follows the camera from its last keyframe."""
    intrinsic: o3d.camera.PinholeCameraIntrinsic
    world_from_camera: np.ndarray = field(default_factory=lambda: np.eye(4))
    keyframe: tuple = None  # image, world_from_camera

    def track(self, rgb, background):
        """world_from_camera of a frame; None where odometry fails."""
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(np.ascontiguousarray(rgb)), o3d.geometry.Image(background), depth_scale=1.0,
            depth_trunc=20.0, convert_rgb_to_intensity=True)
        if self.keyframe is None:
            self.keyframe = image, self.world_from_camera
            return self.world_from_camera
        guess = np.linalg.inv(self.world_from_camera) @ self.keyframe[1]
        ok, camera_from_keyframe, _ = o3d.pipelines.odometry.compute_rgbd_odometry(
            self.keyframe[0], image, self.intrinsic, guess,
            o3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm(),
            o3d.pipelines.odometry.OdometryOption(depth_diff_max=0.07, depth_max=20.0))
        if not ok:
            self.keyframe = image, self.world_from_camera  # go on from here
            return None
        self.world_from_camera = self.keyframe[1] @ np.linalg.inv(camera_from_keyframe)
        near = np.median(background[background > 0]) if (background > 0).any() else 1.0
        turn = np.arccos(np.clip((np.trace(camera_from_keyframe[:3, :3]) - 1) / 2, -1, 1))
        if np.linalg.norm(camera_from_keyframe[:3, 3]) > KEYFRAME_SHIFT * near or turn > KEYFRAME_TURN_RAD:
            self.keyframe = image, self.world_from_camera
        return self.world_from_camera


class Track:
    """One object: its model in the frame of its first view, and its poses."""

    def __init__(self, cloud):
        extent = np.linalg.norm(cloud.get_max_bound() - cloud.get_min_bound())
        self.voxel = max(extent / VOXELS_A_SIZE, 1e-4)
        self.model = cloud.voxel_down_sample(self.voxel)
        self.origin = self.model.get_center()
        self.model.translate(-self.origin)
        self.world_from_body, self.last = np.eye(4), None
        self.world_from_body[:3, 3] = self.origin
        self.axes = None

    def follow(self, cloud):
        """Registers a view in the world; whether it fits."""
        cloud = cloud.voxel_down_sample(self.voxel)
        guess = self.world_from_body
        if self.last is not None:
            guess = self.world_from_body @ np.linalg.inv(self.last) @ self.world_from_body
        self.model.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(3 * self.voxel, 30))
        body_from_world = np.linalg.inv(guess)
        for reach in (4, 2):
            fit = o3d.pipelines.registration.registration_icp(
                cloud, self.model, reach * self.voxel, body_from_world,
                o3d.pipelines.registration.TransformationEstimationPointToPlane())
            body_from_world = fit.transformation
        if fit.fitness < 0.5:
            return False
        self.last, self.world_from_body = self.world_from_body, np.linalg.inv(body_from_world)
        self.model += cloud.transform(body_from_world)
        self.model = self.model.voxel_down_sample(self.voxel)
        return True

    def box(self):
        """world_from_box and the semi-axes: the smallest box, turned anew only where that makes it smaller."""
        points = np.asarray(self.model.points)
        turn = smallest_box(self.model)
        if self.axes is not None and volume(points, turn) > 0.95 * volume(points, self.axes):
            turn = self.axes
        self.axes = turn if self.axes is None else nearest_naming(turn, self.axes)
        low, high = np.percentile(points @ self.axes, [1, 99], axis=0)
        body_from_box = np.eye(4)
        body_from_box[:3, :3], body_from_box[:3, 3] = self.axes, self.axes @ ((low + high) / 2)
        return self.world_from_body @ body_from_box, (high - low) / 2


def nearest_naming(turn, last):
    """The same box, its axes named so that they are nearest to the last ones."""
    return max((turn @ other for other in ROTATIONS), key=lambda named: np.trace(named.T @ last))


def volume(points, turn):
    return np.prod(np.ptp(points @ turn, axis=0))


def smallest_box(cloud):
    """Columns: axes of the smallest box with a side on one of the hull's larger faces."""
    hull, _ = cloud.compute_convex_hull()
    vertices, triangles = np.asarray(hull.vertices), np.asarray(hull.triangles)
    crosses = np.cross(vertices[triangles[:, 1]] - vertices[triangles[:, 0]], vertices[triangles[:, 2]] - vertices[triangles[:, 0]])
    angles = np.radians(np.arange(0, 90, 2))
    best = None
    for normal in crosses[np.argsort(-np.linalg.norm(crosses, axis=1))[:30]]:
        normal = normal / np.linalg.norm(normal)
        a = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        u, v = vertices @ a, vertices @ b
        areas = (np.ptp(np.outer(np.cos(angles), u) + np.outer(np.sin(angles), v), axis=1) *
                 np.ptp(np.outer(np.cos(angles), v) - np.outer(np.sin(angles), u), axis=1))
        angle = angles[np.argmin(areas)]
        size = areas.min() * np.ptp(vertices @ normal)
        if best is None or size < best[0]:
            x = np.cos(angle) * a + np.sin(angle) * b
            best = size, np.column_stack([x, np.cross(normal, x), normal])
    return best[1]


def eroded(mask, pixels=2):
    """Without its border, where segmenters err and depth belongs to what lies behind."""
    for _ in range(pixels):
        inner = mask.copy()
        inner[1:] &= mask[:-1]
        inner[:-1] &= mask[1:]
        inner[:, 1:] &= mask[:, :-1]
        inner[:, :-1] &= mask[:, 1:]
        mask = inner
    return mask


def cloud_of(depth, mask, intrinsic, world_from_camera):
    """The largest connected part of the points under a mask, in the world; None where there are few."""
    image = o3d.geometry.Image(np.where(eroded(mask), depth, 0).astype(np.float32))
    cloud = o3d.geometry.PointCloud.create_from_depth_image(image, intrinsic, depth_scale=1.0, depth_trunc=20.0)
    if len(cloud.points) < MIN_POINTS:
        return None
    points = np.asarray(cloud.points)
    spacing = np.median(points[:, 2]) / intrinsic.get_focal_length()[0]  # of neighbouring pixels
    thinned = cloud.voxel_down_sample(2 * spacing)
    parts = np.asarray(thinned.cluster_dbscan(eps=6 * spacing, min_points=5))
    if (parts < 0).all():
        return None
    largest = thinned.select_by_index(np.nonzero(parts == np.bincount(parts[parts >= 0]).argmax())[0])
    return largest.transform(world_from_camera) if len(largest.points) >= MIN_POINTS else None


def tum(stamp, pose):
    m = pose[:3, :3]
    w = np.sqrt(max(0, 1 + m[0, 0] + m[1, 1] + m[2, 2])) / 2
    x, y, z = (np.sqrt(max(0, 1 + 2 * m[i, i] - np.trace(m))) / 2 for i in range(3))
    q = np.array([np.copysign(x, m[2, 1] - m[1, 2]), np.copysign(y, m[0, 2] - m[2, 0]), np.copysign(z, m[1, 0] - m[0, 1]), w])
    q /= np.linalg.norm(q)
    return f"{stamp} " + " ".join(f"{v:.9f}" for v in [*pose[:3, 3], *q])


def main(folder, out):
    sequence, out = Sequence(folder), Path(out)
    camera, tracks, path, lines, rows = Camera(sequence.intrinsic), {}, [], {}, []
    for stamp in sequence.stamps:
        depth, masks = sequence.depth(stamp), sequence.image("masks", stamp)
        if depth is None or masks is None:
            continue
        pose = camera.track(sequence.image("rgb", stamp)[..., :3], np.where(masks == 0, depth, 0).astype(np.float32))
        if pose is None:
            continue
        path.append(tum(stamp, pose))
        for label in np.unique(masks[masks > 0]):
            cloud = cloud_of(depth, masks == label, sequence.intrinsic, pose)
            if cloud is None or (label in tracks and not tracks[label].follow(cloud)):
                continue
            if label not in tracks:
                tracks[label] = Track(cloud)
            world_from_box, semi_axes = tracks[label].box()
            lines.setdefault(label, []).append(tum(stamp, world_from_box))
            seconds, _, decimals = stamp.partition(".")
            stamp_ns = int(seconds) * 10**9 + int(decimals.ljust(9, "0")[:9])
            rows.append(f"{stamp_ns},{label}," + ",".join(f"{a:.6f}" for a in np.maximum(semi_axes, 1e-4)) + ",1,1,1,z")
    (out / "objects").mkdir(parents=True, exist_ok=True)
    (out / "camera.tum").write_text("\n".join(path) + "\n")
    for label, states in lines.items():
        (out / "objects" / f"{label}.tum").write_text("\n".join(states) + "\n")
    head = "timestamp_ns,id,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m,exponent_q,exponent_upper_q,exponent_lower_q,profile_axis"
    (out / "objects.csv").write_text("\n".join([head, *rows]) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:3])
