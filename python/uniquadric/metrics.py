"""Evaluation's metrics: the same numbers as `uniquadric metric` and `uniquadric trajectory`.

An ellipsoid or box is a pair (world_from_object, semi_axes_m): a 4x4 matrix and three semi-axes [m], half the
extents. A third entry is its shape for iou3d and iou3d_mesh: "ellipsoid" (the default), "box", or
{"superellipsoid": {"q": [outline, upper, lower], "axis": "z"}}. A trajectory is a TUM file's path or a pair
(stamp_ns, poses): n stamps [ns] and n x 4 x 4 matrices.
"""

import json
import os

import numpy

from . import _uniquadric
from ._result import _shaped
from ._uniquadric import InputError


def _pose(matrix, name):
    matrix = _shaped(matrix, (4, 4), name)
    return _uniquadric.quaternion_of(matrix, name).tolist(), matrix[:3, 3].tolist()


def _body(body, name):
    world_from_object, semi_axes_m, *shape = body
    q, c = _pose(world_from_object, name)
    line = {"c": c, "q": q, "a": _shaped(semi_axes_m, (3,), f"{name}.a").tolist()}
    if len(shape) > 1:
        raise InputError(f"{name}: expected a pose, semi-axes and a shape, found {2 + len(shape)} entries")
    return {**line, "shape": shape[0]} if shape else line


def _pair(truth, estimate):
    return {"gt": _body(truth, "gt"), "est": _body(estimate, "est")}


def _rows_of_three(values, name):
    return _shaped(values, (len(values), 3), name)


def _answer(kind, line):
    answer = json.loads(_uniquadric.metric(kind, json.dumps(line)))
    if "error" in answer:
        raise InputError(answer["error"])
    del answer["id"]
    return answer


def iou3d(truth, estimate):
    """Intersection over union of two bodies; exactly 1 for the same one twice.

    Good to 1e-8 for two ellipsoids or two boxes, else sampled with a standard error of 0.001 or so.
    """
    return _answer("iou3d", _pair(truth, estimate))["iou"]


def iou3d_mesh(vertices, triangles, estimate):
    """Intersection over union of what a mesh encloses and a body, sampled as iou3d does.

    vertices: n x 3 [m]; triangles: m x 3 indices into them. The body's pose is in the mesh's frame. Where the
    mesh is not closed, inside is what its generalised winding number says. Raises InputError for what is no
    mesh or encloses no volume.
    """
    vertices = _rows_of_three(vertices, "vertices")
    triangles = _rows_of_three(triangles, "triangles")
    if not numpy.all(numpy.abs(triangles) < 2**53) or numpy.any(triangles != numpy.round(triangles)):
        raise InputError("triangles: expected whole numbers")
    line = json.dumps({"est": _body(estimate, "est")})
    return _uniquadric.mesh_iou(vertices, triangles.astype(numpy.int64), line)


def iou3d_box(truth, estimate):
    """Intersection over union of two oriented boxes, exact but for rounding."""
    return _uniquadric.box_iou(json.dumps(_pair(truth, estimate)))


def iou2d(truth, estimate, camera, world_from_camera):
    """Overlaps of two ellipsoids' outlines in an image, as a dict.

    camera: a Camera, whose lens distortion is not applied; world_from_camera: 4x4. Keys: status, gt_status,
    est_status (ok, behind, not_an_ellipse, inside), rect_iou (of the rotated rectangles about the outlines),
    ellipse_iou, aabb_iou (of the upright boxes), rect_iou_clipped (to the image); None where not defined.
    """
    q, t = _pose(world_from_camera, "camera")
    matrix = _shaped(camera.matrix, (3, 3), "camera.K").ravel().tolist()
    posed = {"K": matrix, "width": int(camera.width), "height": int(camera.height), "q_wc": q, "t_wc": t}
    return _answer("iou2d", {**_pair(truth, estimate), "camera": posed})


def pose_error(truth, estimate):
    """Differences of two ellipsoids, as a dict.

    Keys: translation_error_m [m], rotation_error_naive_rad [rad], rotation_error_symmetric_rad (with the axes
    renamed as suits the truth; None for a sphere) [rad], axis_errors_m (3) [m], d_shape_m [m].
    """
    return _answer("pose", _pair(truth, estimate))


def _trajectory(given):
    if isinstance(given, (str, os.PathLike)):
        return given
    stamp_ns, poses = given
    stamps = numpy.asarray(stamp_ns)
    if stamps.ndim != 1 or not (stamps.size == 0 or numpy.issubdtype(stamps.dtype, numpy.integer)):
        raise InputError("stamp_ns: expected a list of integers")
    matrices = numpy.asarray(poses, dtype=float).reshape(-1, 4, 4) if stamps.size == 0 else poses
    return stamps.astype(numpy.int64), _shaped(matrices, (stamps.size, 4, 4), "poses")


def _errors(relation, reference, estimate, part, align, align_pairs, delta, all_pairs, max_dt_s, association):
    return _uniquadric.trajectory_errors(_trajectory(reference), _trajectory(estimate), relation, part, align,
                                         align_pairs, delta, all_pairs, max_dt_s, association)


def ape(reference, estimate, part="translation", align="none", align_pairs=None, max_dt_s=0.01,
        association="nearest"):
    """Absolute pose errors of two trajectories, one a pair of poses, as a dict.

    part: translation [m], rotation [rad] or full (no unit); align: none, first, se3, sim3, scale, posyaw, poses,
    fitted on the first align_pairs (default: all); max_dt_s: of two poses that belong together [s];
    association: nearest or one_to_one. Keys: rmse, mean, median, std, min, max, sse, n, unit; values, stamp_ns:
    the errors one by one; coverage: share of the reference's poses with an estimate; reference_from_estimate
    (4x4) and scale of the alignment.
    """
    return _errors("ape", reference, estimate, part, align, align_pairs, "1f", False, max_dt_s, association)


def rpe(reference, estimate, part="translation", align="none", align_pairs=None, delta="1f", all_pairs=False,
        max_dt_s=0.01, association="nearest"):
    """Relative pose errors over steps of delta (1f, 10m, 1s, 10deg), as ape(); stamp_ns are those of the ends.

    all_pairs: a step from every pose, instead of one after the other.
    """
    return _errors("rpe", reference, estimate, part, align, align_pairs, delta, all_pairs, max_dt_s, association)
