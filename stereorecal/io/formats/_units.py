"""Is a translation in metres? What is read from files cannot tell, but its length can."""

import warnings

from stereorecal._errors import CalibrationWarning
from stereorecal.geometry import StereoRig
from stereorecal.io._paths import AnyPath

_USUAL = (0.005, 5.0)  # metres, from the smallest endoscope to the longest ship's rig


def warn_of_units(path: AnyPath, *rigs: StereoRig | None) -> None:
    """Warn, once for what `path` holds, of a baseline whose length speaks of another unit than metres.

    To be called by the function that users call: the warning points at their line.
    """
    shortest, longest = _USUAL
    lengths = [float(rig.baseline) for rig in rigs if rig is not None]
    unusual = [length for length in lengths if not shortest <= length <= longest]
    if unusual:
        message = f"{path}: the baseline is {unusual[0]:.3g} m long; check that the translation is in metres."
        warnings.warn(message, CalibrationWarning, stacklevel=3)
