"""What is to be said of a calibration file that was read."""

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


def warn_of_file(path: AnyPath, *rigs: StereoRig | None, sized: bool = True) -> None:
    """Warn, once for what `path` holds, of a baseline whose unit was inferred, or whose length speaks of another unit
    than its own; of turned images; and of principal points far from the middle of images, where the user and not the
    file says the size of these. To be called by the function that users call: the warning points at their line.

    Args:
        sized: whether the size may have come from the user.
    """
    known = [rig for rig in rigs if rig is not None]
    doubts = [_doubt_of_size] if sized else []
    said = [next(filter(None, map(doubt, known)), None) for doubt in (*doubts, _doubt_of_unit)]
    for turns in {rig.turns for rig in known if any(rig.turns)}:
        said.append(
            f"{described_turns(turns)} when they are read, and the calibration with them; files stay as they are."
        )
    for message in filter(None, said):
        warnings.warn(f"{path}: {message}", CalibrationWarning, stacklevel=3)


def _doubt_of_size(rig: StereoRig) -> str | None:
    source = file_of(rig)
    if source is None or source.hints.size is None:
        return None
    for camera in (rig.left, rig.right):
        place, size = np.asarray(camera.matrix)[:2, 2], np.array(camera.size)
        if (np.abs(place + 0.5 - size / 2.0) > _FAR * size).any() and not _states_size(source):
            return (
                f"the file has no image size, and its principal point ({place[0]:.0f}, {place[1]:.0f}) is far from the "
                f"middle of images of {size[0]}x{size[1]}; if it is for images of another size, give that size, and "
                "then resize or crop the rig (rig.resized, rig.cropped)."
            )
    return None


def _states_size(source: RigFile) -> bool:
    """Whether a file is not for images of any size that is said."""
    assert source.hints.size is not None
    other = source.hints.size[0] + 1, source.hints.size[1] + 1
    try:
        rig = rig_in(source.documents, named(source.format), source.unit, replace(source.hints, size=other))
    except InputError:
        return True
    return rig.left.size != other


def _doubt_of_unit(rig: StereoRig) -> str | None:
    length, source = float(rig.baseline), rig.source
    message = doubt_of_length(length, "m" if source is None else source.unit)
    if message is None and source is not None and source.inferred:
        return (
            f"the file has no unit; its translation is taken to be in {source.unit}, a baseline of {length:.3g} m: say "
            f"unit='{source.unit}' (--unit {source.unit}) if that is right, or another unit if it is not."
        )
    return message
