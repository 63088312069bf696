"""Calibration files as the command line names them, read: one file, a folder, a data set, or LEFT,RIGHT."""

import re
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal.cli._calibration_paths import calibration_path, paths
from stereorecal.cli._option_values import camera_pair
from stereorecal.cli._shared_options import CalibrationOptions
from stereorecal.geometry import StereoRig
from stereorecal.io import has_own_unit, is_data_set, load_rig, load_scene


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


def says_no_unit(words: str, options: CalibrationOptions) -> bool:
    """Whether the format of a calibration has no unit; False for one that cannot be read, which its reader says."""
    try:
        return not has_own_unit(paths(calibration_path(words, words)), options.format)
    except InputError:
        return False


def rig_at(words: str, options: CalibrationOptions, *, other_says_none: bool = False) -> StereoRig:
    """The rig in a calibration file, in LEFT,RIGHT, or in a folder, whose images are not looked at if it has a file of
    its own.

    Args:
        other_says_none: whether the format of the command's other file has no unit: --unit may be of that one.

    Raises:
        InputError: if there is none.
    """
    where = calibration_path(words, words)
    if isinstance(where, Path) and where.is_dir() and is_data_set(where):
        rig = load_scene(where, limit=1).rig
        if rig is None:
            raise InputError(f"{where}: there is no calibration in it; give one that has.")
        return rig
    size, cameras = image_size(options.size), camera_pair(options.cameras)
    of_other = options.unit is not None and other_says_none and has_own_unit(paths(where), options.format)
    unit = None if of_other else options.unit
    return load_rig(*paths(where), format=options.format, unit=unit, size=size, cameras=cameras)
