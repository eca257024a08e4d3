"""Readers of sequence, truth and estimate folders."""

from typing import NamedTuple

from . import _uniquadric


class Camera(NamedTuple):
    """A pinhole camera. matrix: K, 3x3 [px]; distortion: k1 k2 p1 p2 k3. Pixel centres are whole numbers."""

    width: int
    height: int
    matrix: object
    distortion: object


class ImuCalibration(NamedTuple):
    """Rate [Hz], place (4x4) and noise of an IMU: densities of the noise, walks of the biases."""

    rate_hz: float
    camera_from_imu: object
    gyroscope_noise_radps_rthz: float
    gyroscope_walk_radps2_rthz: float
    accelerometer_noise_mps2_rthz: float
    accelerometer_walk_mps3_rthz: float
    gravity_mps2: float


class LidarCalibration(NamedTuple):
    """Scan pattern, scans a second [Hz] and place (4x4) of a LiDAR."""

    pattern: str
    rate_hz: float
    camera_from_lidar: object


class Trajectory(NamedTuple):
    """stamp_ns: n stamps (int64) [ns], increasing; poses: n x 4 x 4, world_from_camera or world_from_object."""

    stamp_ns: object
    poses: object


class Frame:
    """One camera frame; its images are read when they are asked for.

    index: place in the sequence, from 0; stamp_ns [ns]; masks_arrival_ns: when the segmenter's result is there.
    """

    def __init__(self, raw, index, stamp_ns, masks_arrival_ns):
        self._raw = raw
        self.index = index
        self.stamp_ns = stamp_ns
        self.masks_arrival_ns = masks_arrival_ns

    def rgb(self):
        """The colour image: height x width x 3, uint8, in the order red, green, blue."""
        return self._raw.rgb(self.index)

    def depth_m(self):
        """z along the optical axis [m]: height x width, float32, 0 where there is none. None without a file."""
        return self._raw.depth(self.index)

    def masks(self):
        """Instance ids: height x width, uint16, 0 is background. None without a file."""
        return self._raw.masks(self.index)


class Scan:
    """One LiDAR scan; stamp_ns is its start [ns]. Its points are read when they are asked for."""

    def __init__(self, raw, index, stamp_ns):
        self._raw = raw
        self.index = index
        self.stamp_ns = stamp_ns

    def points(self):
        """The points, a structured array of n.

        Fields: x, y, z [m] (float32) in the LiDAR's frame at the point's time, intensity (float32), offset_ns
        since the scan's start (uint32), ring (uint16), tag (uint8).
        """
        return self._raw.scan(self.index)


class Sequence:
    """A sequence folder: observations and calibration, nothing of the truth. Checked when it is opened.

    folder, program (that made it), name, seed, rate_hz [Hz], camera (Camera), imu (ImuCalibration or None),
    lidar (LidarCalibration or None), frames (list of Frame), scans (list of Scan), given_camera (Trajectory of
    world_from_camera from another system, or None).
    """

    def __init__(self, folder):
        raw = _uniquadric.Sequence(folder)
        self._raw = raw
        self.folder, self.program, self.name = raw.folder, raw.program, raw.name
        self.seed, self.rate_hz = raw.seed, raw.rate_hz
        self.camera = Camera(*raw.camera())
        imu, lidar, given = raw.imu(), raw.lidar(), raw.given_camera()
        self.imu = ImuCalibration(*imu) if imu else None
        self.lidar = LidarCalibration(*lidar) if lidar else None
        self.given_camera = Trajectory(*given) if given else None
        self.frames = [Frame(raw, k, *stamps) for k, stamps in enumerate(raw.frame_stamps())]
        self.scans = [Scan(raw, k, stamp_ns) for k, stamp_ns in enumerate(raw.scan_stamps())]

    def imu_samples(self):
        """The IMU's samples, a structured array of n; None without an IMU.

        Fields: stamp_ns (int64), angular_velocity_radps (3), specific_force_mps2 (3), in the IMU's frame. The
        specific force is the acceleration less gravity: it points up at rest.
        """
        return self._raw.imu_samples() if self.imu else None


class Track:
    """An object at n times.

    id; name (empty: unknown); frame, stamp_ns: n; world_from_object: n x 4 x 4; semi_axes_m: n x 3 [m], half the
    extents; exponents: n x 3 (outline, upper, lower; 2 is the ellipsoid, 1 the box); profile_axis: n of x, y, z;
    variances: n x 9 (semi-axes [m^2], translation [m^2], rotation vector [rad^2]; NaN: not estimated);
    status, motion: lists of n names.
    """

    def __init__(self, values):
        self.__dict__.update(values)


class Truth:
    """A truth folder; an estimate folder is read in the same way.

    folder; camera: Trajectory of world_from_camera; objects: dict of Track by id; calibration: Camera or None.
    """

    def __init__(self, folder):
        camera, objects, calibration = _uniquadric.read_tracks(folder)
        self.folder = folder
        self.camera = Trajectory(*camera)
        self.objects = {values["id"]: Track(values) for values in objects}
        self.calibration = Camera(*calibration) if calibration else None
