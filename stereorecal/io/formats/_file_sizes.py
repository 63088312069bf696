"""The size of images that the user says, where a calibration file says none."""

import warnings
from dataclasses import replace

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import AnyPath
from stereorecal.io.formats._format_list import named
from stereorecal.io.formats._read_rig import rig_in
from stereorecal.io.formats._rig_file import RigFile, file_of

_FAR = 0.15  # of the width or height: principal points of cameras whose images are whole lie nearer to the middle


def warn_of_size(path: AnyPath, *rigs: StereoRig | None) -> None:
    """Warn, once for what `path` holds, of principal points far from the middle of images, where the user and not the
    file says the size of these; to be called by the function that users call.

    Warns:
        CalibrationWarning: if there is such a rig.
    """
    for rig in rigs:
        source = None if rig is None else file_of(rig)
        if rig is None or source is None or source.hints.size is None:
            continue
        for camera in (rig.left, rig.right):
            place, size = np.asarray(camera.matrix)[:2, 2], np.array(camera.size)
            if (np.abs(place + 0.5 - size / 2.0) > _FAR * size).any() and not _states_size(source):
                warnings.warn(
                    f"{path}: the file has no image size, and its principal point ({place[0]:.0f}, {place[1]:.0f}) is "
                    f"far from the middle of images of {size[0]}x{size[1]}; if it is for images of another size, give "
                    "that size, and then resize or crop the rig (rig.resized, rig.cropped).",
                    CalibrationWarning,
                    stacklevel=3,
                )
                return


def _states_size(source: RigFile) -> bool:
    """Whether a file is not for images of any size that is said."""
    assert source.hints.size is not None
    other = source.hints.size[0] + 1, source.hints.size[1] + 1
    try:
        rig = rig_in(source.documents, named(source.format), source.unit, replace(source.hints, size=other))
    except InputError:
        return True
    return rig.left.size != other
