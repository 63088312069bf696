"""Units of length: what a file's numbers are, and whether a translation is in metres."""

import warnings

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._paths import AnyPath

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_USUAL = (0.005, 5.0)  # metres, from the smallest endoscope to the longest ship's rig


def checked_unit(unit: str | None) -> str | None:
    """The unit, if it is one or none is given.

    Raises:
        InputError: otherwise.
    """
    if unit is not None and unit not in METRES:
        raise InputError(f"unknown unit {unit!r}; choose one of: {', '.join(METRES)}.")
    return unit


def inferred_unit(length: float) -> str:
    """Metres, if a baseline of that length would be a usual one, else millimetres."""
    return "m" if length <= _USUAL[1] else "mm"


def scaled(rig: StereoRig, factor: float) -> StereoRig:
    """The rig with T times a factor."""
    factors = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    return rig if factor == 1.0 else rig.with_extrinsics(rig.extrinsics * factors)


def warn_of_units(path: AnyPath, *rigs: StereoRig | None) -> None:
    """Warn, once for what `path` holds, of a baseline whose unit was inferred, or whose length speaks of another unit
    than metres.

    To be called by the function that users call: the warning points at their line.
    """
    shortest, longest = _USUAL
    for rig in rigs:
        if rig is None:
            continue
        length, source = float(rig.baseline), rig.source
        if not shortest <= length <= longest:
            message = f"the baseline is {length:.3g} m long; check that the translation is in metres."
        elif source is not None and source.inferred:
            message = (
                f"the file has no unit; its translation is taken to be in {source.unit}, a baseline of {length:.3g} m: "
                f"say unit='{source.unit}' (--unit {source.unit}) if that is right, or another unit if it is not."
            )
        else:
            continue
        warnings.warn(f"{path}: {message}", CalibrationWarning, stacklevel=3)
        return
