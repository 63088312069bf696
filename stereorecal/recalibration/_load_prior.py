"""The prior that was saved with a calibration file."""

from collections.abc import Sequence
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.estimation import SavedPrior
from stereorecal.io import load_rig
from stereorecal.recalibration._prior_use import saved_with


def load_prior(path: str | Path | Sequence[str | Path]) -> SavedPrior | None:
    """What was saved with a calibration, as `sr.io.load_rig` finds it; None if nothing was.

    `recalibrate` looks it up by itself, for a rig that `sr.io.load_rig` has read.

    Args:
        path: of the calibration: a file, two, or a folder that holds one.

    Raises:
        InputError: naming the file, if it cannot be read, or belongs to other parameters than are in the calibration.
    """
    saved, note = saved_with(load_rig(path))
    if note is not None:
        raise InputError(f"{note}; recalibrate again.")
    return saved
