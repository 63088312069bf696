"""The unit of lengths in a calibration file, and warnings about it."""

import warnings

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.geometry import StereoRig, doubt_of_length
from stereorecal.io._read_files import AnyPath
from stereorecal.io.formats._format import Format

_STATED = {"matlab": "WorldUnits", "stereorecal": "baseline_m"}  # keys of files that state their unit


def unit_in(format: Format, given: str | None) -> str | None:
    """The unit of lengths in files: the given one, else that of the format; None if neither tells.

    A format's unit is what its programs expect, and ROS, Kalibr and others write whatever the board was measured in.

    Raises:
        InputError: if the files have a place for their unit, and another one is given.
    """
    if format.NAME in _STATED and given not in (None, format.UNIT):
        raise InputError(
            f"lengths of a {format.NAME} file are in the unit that it states ({_STATED[format.NAME]}), not in {given}; "
            "leave the unit out, or correct the file."
        )
    return given or format.UNIT


def scaled(rig: StereoRig, factor: float) -> StereoRig:
    """The rig with T times a factor."""
    factors = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    return rig if factor == 1.0 else rig.with_extrinsics(rig.extrinsics * factors)


def warn_of_units(path: AnyPath, *rigs: StereoRig | None) -> None:
    """Warn, once for what `path` holds, of a baseline whose unit was inferred, or whose length speaks of another unit
    than its own.

    To be called by the function that users call: the warning points at their line.
    """
    for rig in rigs:
        if rig is None:
            continue
        length, source = float(rig.baseline), rig.source
        message = doubt_of_length(length, "m" if source is None else source.unit)
        if message is None and source is not None and source.inferred:
            message = (
                f"the file has no unit; its translation is taken to be in {source.unit}, a baseline of {length:.3g} m: "
                f"say unit='{source.unit}' (--unit {source.unit}) if that is right, or another unit if it is not."
            )
        if message is not None:
            warnings.warn(f"{path}: {message}", CalibrationWarning, stacklevel=3)
            return
