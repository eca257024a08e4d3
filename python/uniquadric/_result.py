"""The writer of estimate folders."""

import operator

import numpy

from . import _uniquadric
from ._uniquadric import InputError


def _shaped(values, shape, name):
    try:
        array = numpy.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected numbers") from None
    if array.shape != shape:
        expected = "x".join(str(n) for n in shape)
        raise InputError(f"{name}: expected {expected} numbers, found an array of shape {array.shape}")
    return array


def _stamp_ns(stamp_ns, stamp_s):
    if (stamp_ns is None) == (stamp_s is None):
        raise InputError("expected one of stamp_ns and stamp_s")
    if stamp_s is not None:
        return _uniquadric.stamp_ns_of(float(stamp_s))
    try:
        stamp = operator.index(stamp_ns)
    except TypeError:
        raise InputError(f"stamp_ns: {stamp_ns} is not an integer") from None
    if not -(2**63) <= stamp < 2**63:
        raise InputError(f"stamp_ns: {stamp} is too large")
    return stamp


class Result:
    """An estimate that is gathered pose by pose and written as an estimate folder.

    Each call checks what it is given and raises InputError; what was given before stays as it was. Stamps
    increase strictly, those of the camera and those of each object by themselves.

    out: the folder to write; force: replace it, if it is an estimate that this program wrote.
    """

    def __init__(self, out, force=False):
        self._out, self._force = out, force
        self._writer = _uniquadric.ResultWriter()

    def camera(self, world_from_camera, *, stamp_ns=None, stamp_s=None):
        """Adds a pose of the camera (4x4, optical frame) at stamp_ns (whole nanoseconds) or stamp_s (seconds)."""
        self._writer.camera(_stamp_ns(stamp_ns, stamp_s), _shaped(world_from_camera, (4, 4), "world_from_camera"))

    def object(self, id, world_from_object, semi_axes_m, exponents=None, *, stamp_ns=None, stamp_s=None):
        """Adds a state of an object.

        id: greater than 0; world_from_object: 4x4; semi_axes_m: 3 [m], half the extents; exponents: one number,
        or three (outline, upper, lower), from 1 (a box) to 2 (an ellipsoid, the default).
        """
        if exponents is None:
            exponents = 2.0
        if numpy.ndim(exponents) == 0:
            exponents = (exponents, exponents, exponents)
        try:
            number = operator.index(id)
        except TypeError:
            number = 0
        if not 0 < number < 2**31:
            raise InputError(f"id: {id} is not an integer greater than 0")
        self._writer.object(number, _stamp_ns(stamp_ns, stamp_s),
                            _shaped(world_from_object, (4, 4), "world_from_object"),
                            _shaped(semi_axes_m, (3,), "semi_axes_m"), _shaped(exponents, (3,), "exponents"))

    def write(self):
        """Writes the folder, all of it or nothing. Raises InputError where it exists and is not to be replaced."""
        self._writer.write(self._out, self._force)
