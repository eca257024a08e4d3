import os
import pathlib
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import metrics as metrics

Path = Union[str, "os.PathLike[str]"]
__version__: str

class InputError(ValueError): ...

class Camera(NamedTuple):
    width: int
    height: int
    matrix: NDArray[np.float64]
    distortion: NDArray[np.float64]

class ImuCalibration(NamedTuple):
    rate_hz: float
    camera_from_imu: NDArray[np.float64]
    gyroscope_noise_radps_rthz: float
    gyroscope_walk_radps2_rthz: float
    accelerometer_noise_mps2_rthz: float
    accelerometer_walk_mps3_rthz: float
    gravity_mps2: float

class LidarCalibration(NamedTuple):
    pattern: str
    rate_hz: float
    camera_from_lidar: NDArray[np.float64]

class Trajectory(NamedTuple):
    stamp_ns: NDArray[np.int64]
    poses: NDArray[np.float64]

class Frame:
    index: int
    stamp_ns: int
    masks_arrival_ns: int
    def rgb(self) -> NDArray[np.uint8]: ...
    def depth_m(self) -> Optional[NDArray[np.float32]]: ...
    def masks(self) -> Optional[NDArray[np.uint16]]: ...

class Scan:
    index: int
    stamp_ns: int
    def points(self) -> NDArray[np.void]: ...

class Sequence:
    folder: pathlib.Path
    program: str
    name: str
    seed: int
    rate_hz: float
    camera: Camera
    imu: Optional[ImuCalibration]
    lidar: Optional[LidarCalibration]
    given_camera: Optional[Trajectory]
    frames: list[Frame]
    scans: list[Scan]
    def __init__(self, folder: Path) -> None: ...
    def imu_samples(self) -> Optional[NDArray[np.void]]: ...

class Track:
    id: int
    name: str
    frame: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    world_from_object: NDArray[np.float64]
    semi_axes_m: NDArray[np.float64]
    exponents: NDArray[np.float64]
    profile_axis: list[str]
    variances: NDArray[np.float64]
    status: list[str]
    motion: list[str]

class Truth:
    folder: Path
    camera: Trajectory
    objects: dict[int, Track]
    calibration: Optional[Camera]
    def __init__(self, folder: Path) -> None: ...

class Result:
    def __init__(self, out: Path, force: bool = ...) -> None: ...
    def camera(
        self, world_from_camera: ArrayLike, *, stamp_ns: Optional[int] = ..., stamp_s: Optional[float] = ...
    ) -> None: ...
    def object(
        self,
        id: int,
        world_from_object: ArrayLike,
        semi_axes_m: ArrayLike,
        exponents: Optional[ArrayLike] = ...,
        *,
        stamp_ns: Optional[int] = ...,
        stamp_s: Optional[float] = ...,
    ) -> None: ...
    def write(self) -> None: ...

def scores(folder: Path) -> Any: ...
