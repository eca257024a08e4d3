"""Uniquadric's folders and metrics in Python.

Sequence reads what a sensor saw, Truth what was there or what a program estimated, Result writes an estimate,
metrics compares, scores reads the scores of a bench.

Conventions: lengths in metres, angles in radians, times in nanoseconds. A transform is a 4x4 matrix
`a_from_b`: p_in_a = a_from_b @ p_in_b. Camera frame: x right, y down, z forward. Bad input raises
InputError with the text that the program prints.
"""

import csv
import io
import pathlib

from . import _uniquadric, metrics
from ._folders import Camera, Frame, ImuCalibration, LidarCalibration, Scan, Sequence, Track, Trajectory, Truth
from ._result import Result
from ._uniquadric import InputError, __version__

__all__ = ["Camera", "Frame", "ImuCalibration", "InputError", "LidarCalibration", "Result", "Scan", "Sequence",
           "Track", "Trajectory", "Truth", "metrics", "scores"]


def _number(text, kind):
    return kind(text) if text else None


def scores(folder):
    """The scores.csv of a bench's results folder (or that file itself).

    Columns: sequence, object, variant, seed, metric, value, better (lower or higher), status (ok or failed).
    Returns a pandas.DataFrame where pandas is installed; else a list of dicts, where a missing value is None.
    """
    path = pathlib.Path(folder)
    if path.is_dir():
        path = path / "scores.csv"
    text = _uniquadric.read_text(path)
    try:
        import pandas
    except ImportError:
        rows = list(csv.DictReader(io.StringIO(text)))
        for row in rows:
            row["seed"] = _number(row["seed"], int)
            row["value"] = _number(row["value"], float)
        return rows
    return pandas.read_csv(io.StringIO(text), float_precision="round_trip", keep_default_na=False,
                           na_values={"value": [""]})
