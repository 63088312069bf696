"""What is to be said of a calibration file that was read; to be called by the function that users call: the warning
points at their line."""

import warnings
from dataclasses import replace

import numpy as np

from stereorecal._errors import CalibrationWarning, InputError
from stereorecal.geometry import StereoRig, described_turns, doubt_of_length
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


def warn_of_turns(path: AnyPath, *rigs: StereoRig | None) -> None:
    """Say once, of what `path` holds, that images are turned.

    Warns:
        CalibrationWarning: if they are.
    """
    for turns in {rig.turns for rig in rigs if rig is not None and any(rig.turns)}:
        done = f"{described_turns(turns)} when they are read, and the calibration with them; files stay as they are."
        warnings.warn(f"{path}: {done}", CalibrationWarning, stacklevel=3)
