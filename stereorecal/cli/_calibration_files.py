"""Calibration files as the command line names them, read: one file, a folder, a data set, or LEFT,RIGHT."""

import re
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli._calibration_paths import calibration_path, paths
from stereorecal.cli._shared_options import CalibrationOptions
from stereorecal.geometry import StereoRig
from stereorecal.io import is_data_set, load_rig, load_scene


def image_size(text: str | None) -> tuple[int, int] | None:
    """ "640x480" as (width, height).

    Raises:
        InputError: if it is none.
    """
    if text is None:
        return None
    found = re.fullmatch(r"([1-9]\d{0,6})x([1-9]\d{0,6})", text)
    if found is None:
        raise InputError(f"--size is {text!r}; give width and height in pixels, such as 640x480.")
    return int(found[1]), int(found[2])


def rig_at(words: str, options: CalibrationOptions) -> StereoRig:
    """The rig in a calibration file, in LEFT,RIGHT, or in a folder, whose images are not looked at if it has a file of
    its own.

    Raises:
        InputError: if there is none.
    """
    where = calibration_path(words, words)
    if isinstance(where, Path) and where.is_dir() and is_data_set(where):
        rig = load_scene(where, limit=1).rig
        if rig is None:
            raise InputError(f"{where}: there is no calibration in it; give one that has.")
        return rig
    size = image_size(options.size)
    return load_rig(*paths(where), format=options.format, unit=options.unit, size=size)
