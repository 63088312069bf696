"""A rig without images, from what people name: a calibration file of any format, a folder, a data set."""

import argparse
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli import _calibrations
from stereorecal.geometry import StereoRig
from stereorecal.io import is_data_set, load_rig, load_scene, says_its_unit, unsaid_unit


def rig_at(words: str, options: argparse.Namespace) -> StereoRig:
    """The rig in a calibration file, in LEFT,RIGHT, or in a folder, whose images are not looked at if it has a file of
    its own.

    Raises:
        InputError: if there is none.
    """
    where = _calibrations.place(words, words)
    if isinstance(where, Path) and where.is_dir() and is_data_set(where):
        rig = load_scene(where, limit=1).rig
        if rig is None:
            raise InputError(f"{where}: there is no calibration in it; give one that has.")
        return rig
    size = _calibrations.size(options.size)
    return load_rig(*_calibrations.paths(where), format=options.format, unit=options.unit, size=size)


def unit_written(
    read: StereoRig, written: StereoRig, target: _calibrations.Place, format: str | None, unit: str | None
) -> tuple[str | None, str]:
    """What --unit means for a file that is written, and what to say of it after "written".

    It is about the file that was read, if only that one says no unit.
    """
    unsaid = unsaid_unit(written, target, format=format)
    if unsaid is None:
        return unit if says_its_unit(read) else None, ""
    return unit, f" (translation in {unit or unsaid})"
