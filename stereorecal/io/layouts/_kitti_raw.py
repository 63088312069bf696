"""KITTI raw data: one day's drives, rectified (`_sync`) or raw (`_extract`), and that day's calibration."""

from pathlib import Path

import numpy as np
from jaxtyping import Shaped

from stereorecal._errors import InputError
from stereorecal.io._read_files import read_text
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._read_rig import read_files
from stereorecal.io.images._load_pairs import load_matched
from stereorecal.io.images._match_by_name import Matched, by_stem, match_equal
from stereorecal.io.layouts._layout import Sequence, log_of, sequences_in, sides_in
from stereorecal.recordings import Log

LAYOUT = "KITTI raw data (DATE/calib_cam_to_cam.txt, DATE/DATE_drive_NNNN_sync or _extract), or one drive of it"
_CALIBRATION, _TIMES, _RECTIFIED, _RAW = "calib_cam_to_cam.txt", "timestamps.txt", "_sync", "_extract"
_DRIVES = "*_drive_*"
_GREY_BEFORE_COLOUR = (("image_00", "image_01"), ("image_02", "image_03"))
# The cameras are triggered together ten times a second (KITTI's raw data paper): images less than half a period apart
# are of the same trigger.
_SAME_SHOT = np.timedelta64(50, "ms")


def recognises(folder: Path) -> bool:
    """Whether the folder is a day or a drive of KITTI's raw data."""
    return (folder / _CALIBRATION).is_file() or bool(sequences_in(folder, _DRIVES, _GREY_BEFORE_COLOUR))


def read(folder: Path, limit: int | None) -> Log:
    """The drives of a day, or one drive, whose calibration lies in the folder above.

    `_sync` images are rectified: the rig comes from P_rect and has no rotation or distortion. `_extract` images are
    raw: the rig comes from K, D, R and T. Their numbers do not correspond between cameras, so they are paired by time,
    and one that only one camera took is left out."""
    return log_of(folder, (_sequence(drive, limit) for drive in sequences_in(folder, _DRIVES, _GREY_BEFORE_COLOUR)))


def _sequence(drive: Path, limit: int | None) -> Sequence:
    day, name = drive.resolve().parent, drive.resolve().name
    left, right = sides_in(drive, _GREY_BEFORE_COLOUR)
    rectified = name.endswith(_RECTIFIED)
    if not rectified and not name.endswith(_RAW):
        raise InputError(
            f"{drive}: the name does not say whether the images are rectified; rename the folder to end in "
            f"{_RECTIFIED} (rectified) or {_RAW}."
        )
    hints = Hints(cameras=(left[-2:], right[-2:]), rectified=rectified)
    missing = f"download {day.name}_calib.zip from KITTI's page and unpack it over the images."
    rig = read_files([day / _CALIBRATION], "kitti-raw", hints=hints, if_missing=missing)
    if rectified:
        matched = match_equal(drive / left / "data", drive / right / "data")
    else:
        matched = _match_by_time(drive / left, drive / right)
    return drive, rig, load_matched(matched, limit, _seconds(drive / left, matched))


def _match_by_time(left: Path, right: Path) -> Matched:
    (left_files, left_times), (right_files, right_times) = _shots(left), _shots(right)
    matched: list[tuple[Path, Path]] = []
    for path, time in zip(left_files, left_times, strict=True):
        gaps = np.abs(right_times - time)
        if gaps.min() < _SAME_SHOT:
            matched.append((path, right_files[int(gaps.argmin())]))
    if not matched:
        raise InputError(f"{left}: no image in there was taken together with one of {right.name}; check {_TIMES}.")
    return matched


def _seconds(camera: Path, matched: Matched) -> list[float] | None:
    """When the left images were taken; None if the file of their times is missing."""
    if not (camera / _TIMES).is_file():
        return None
    files, times = _shots(camera)
    of_file = dict(zip(files, (times - times[0]) / np.timedelta64(1, "s"), strict=True))
    return [float(of_file[path]) for path, _ in matched]


def _shots(camera: Path) -> tuple[list[Path], Shaped[np.ndarray, "n"]]:
    """The images of a camera and their times: the number in an image's name is its line in timestamps.txt, from 0."""
    files = by_stem(camera / "data")
    path = camera / _TIMES
    lines = read_text(path).split("\n")
    try:
        times = np.array([lines[int(stem)].strip() for stem in files], "datetime64[ns]")
    except (IndexError, ValueError):
        times = np.array(["NaT"], "datetime64[ns]")
    if np.isnat(times).any():
        raise InputError(f"{path}: not every image in data has a time in this file; copy or unpack it again.")
    return list(files.values()), times
