"""What the tests share: the program, and a sequence of three frames that it simulates once."""
import atexit
import functools
import os
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np

PROGRAM = os.environ["UNIQUADRIC_PROGRAM"]
SOURCE = pathlib.Path(os.environ["UNIQUADRIC_SOURCE"])

SCENE = """
name: three_frames
frames: 3
rate_hz: 10
camera:
  calibration: {width: 160, height: 120, fx: 131, fy: 132, cx: 79.5, cy: 59.5}
  motion:
    kind: spline
    look_at_m: [0, 0, 0.95]
    waypoints:
      - {time_s: -1, position_m: [-2.40, -0.95, 1.30]}
      - {time_s: 1, position_m: [-2.05, -1.65, 1.45], roll_deg: 2}
      - {time_s: 3, position_m: [-1.05, -2.40, 1.65]}
imu: {rate_hz: 200, body_from_imu: {position_m: [-0.05, 0.02, -0.08]}}
lidar: {pattern: livox_avia, rate_hz: 10, body_from_lidar: {position_m: [0.02, 0, 0.12]}}
world:
  - {name: room, primitive: room, size_m: [6, 6, 3], furniture: 8, material: {seed: 7}}
objects:
  - id: 3
    name: crate
    primitive: rounded_box
    size_m: [0.4, 0.6, 0.3]
    radius_m: 0.015
    motion: {kind: line, start: {position_m: [0.1, 0, 1], rpy_deg: [10, 20, 30]}, velocity_mps: [0.2, 0, 0]}
"""


def run(*arguments):
    """Exit code, stdout and stderr of the program."""
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@functools.lru_cache(maxsize=None)
def temporary():
    folder = pathlib.Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder)
    return folder


@functools.lru_cache(maxsize=None)
def data():
    """The folder with sequence/ and truth/."""
    scene = temporary() / "scene.yaml"
    scene.write_text(SCENE)
    code, _, error = run("simulate", scene, temporary() / "data", "--seed", 1)
    assert code == 0, error
    return temporary() / "data"


def new_folder():
    return pathlib.Path(tempfile.mkdtemp(dir=temporary()))


def error_line(*arguments):
    """What the program says of bad input, without its name."""
    code, _, error = run(*arguments)
    assert code == 2, error
    return error.strip().split(": ", 1)[1]


def matrix(position=(0, 0, 0), quaternion=(0, 0, 0, 1)):
    """a_from_b of a position and x, y, z, w, by the textbook formula."""
    x, y, z, w = quaternion
    result = np.eye(4)
    result[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    result[:3, 3] = position
    return result


def read_tum(path):
    """(stamps [ns], poses) of TUM text, read without the package."""
    stamps, poses = [], []
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            continue
        stamp, *values = line.split()
        seconds, decimals = stamp.split(".")
        stamps.append(int(seconds) * 10**9 + int(decimals))
        poses.append(matrix([float(v) for v in values[:3]], [float(v) for v in values[3:]]))
    return np.array(stamps), np.array(poses)


def path_of(positions, period_ns=100_000_000):
    """A trajectory (stamps, poses) through these positions, each turned a little further about z."""
    poses = np.array([matrix(p, (0, 0, np.sin(0.05 * k), np.cos(0.05 * k))) for k, p in enumerate(positions)])
    return np.arange(len(poses)) * period_ns, poses


CURVE = [(np.cos(t), np.sin(t), 0.1 * t) for t in np.linspace(0, 3, 20)]
