import os
from typing import Optional, Tuple, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Camera

Shape = Union[str, dict[str, object]]
Body = Union[Tuple[ArrayLike, ArrayLike], Tuple[ArrayLike, ArrayLike, Shape]]
Path = Union[str, "os.PathLike[str]"]
Poses = Union[Path, Tuple[ArrayLike, ArrayLike]]

class Overlap(TypedDict):
    status: str
    gt_status: str
    est_status: str
    rect_iou: Optional[float]
    ellipse_iou: Optional[float]
    aabb_iou: Optional[float]
    rect_iou_clipped: Optional[float]

class PoseErrors(TypedDict):
    translation_error_m: float
    rotation_error_naive_rad: float
    rotation_error_symmetric_rad: Optional[float]
    axis_errors_m: list[float]
    d_shape_m: float

class TrajectoryErrors(TypedDict):
    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    sse: float
    n: int
    unit: str
    stamp_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    coverage: float
    scale: float
    reference_from_estimate: NDArray[np.float64]

def iou3d(truth: Body, estimate: Body) -> float: ...
def iou3d_mesh(vertices: ArrayLike, triangles: ArrayLike, estimate: Body) -> float: ...
def iou3d_box(truth: Body, estimate: Body) -> float: ...
def iou2d(truth: Body, estimate: Body, camera: Camera, world_from_camera: ArrayLike) -> Overlap: ...
def pose_error(truth: Body, estimate: Body) -> PoseErrors: ...
def ape(
    reference: Poses,
    estimate: Poses,
    part: str = ...,
    align: str = ...,
    align_pairs: Optional[int] = ...,
    max_dt_s: float = ...,
    association: str = ...,
) -> TrajectoryErrors: ...
def rpe(
    reference: Poses,
    estimate: Poses,
    part: str = ...,
    align: str = ...,
    align_pairs: Optional[int] = ...,
    delta: str = ...,
    all_pairs: bool = ...,
    max_dt_s: float = ...,
    association: str = ...,
) -> TrajectoryErrors: ...
