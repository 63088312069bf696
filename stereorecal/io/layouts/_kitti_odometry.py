"""KITTI odometry: rectified sequences with their projection matrices."""

from pathlib import Path

import numpy as np

from stereorecal.io._read_files import read_text
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._read_rig import read_files
from stereorecal.io.images._load_pairs import load_matched
from stereorecal.io.images._match_by_name import match_equal
from stereorecal.io.layouts._layout import Sequence, log_of, sequences_in, sides_in
from stereorecal.recordings import Log

LAYOUT = "KITTI odometry (sequences/NN), or one sequence of it (calib.txt, image_0 and image_1, or image_2 and image_3)"
_CALIBRATION, _SEQUENCES, _TIMES = "calib.txt", "sequences/*", "times.txt"
_IF_MISSING = "download data_odometry_calib.zip from KITTI's page and unpack it over the images."
_GREY_BEFORE_COLOUR = (("image_0", "image_1"), ("image_2", "image_3"))


def recognises(folder: Path) -> bool:
    """Whether the folder is KITTI odometry, or one of its sequences."""
    return bool(sequences_in(folder, _SEQUENCES, _GREY_BEFORE_COLOUR))


def read(folder: Path, limit: int | None) -> Log:
    """The sequences whose images have been unpacked."""
    return log_of(folder, (_sequence(place, limit) for place in sequences_in(folder, _SEQUENCES, _GREY_BEFORE_COLOUR)))


def _sequence(folder: Path, limit: int | None) -> Sequence:
    left, right = sides_in(folder, _GREY_BEFORE_COLOUR)
    matched = match_equal(folder / left, folder / right)
    pairs = load_matched(matched, limit, _read_times(folder / _TIMES, len(matched)))
    hints = Hints(size=pairs[0].size, cameras=(f"P{left[-1]}", f"P{right[-1]}"))
    rig = read_files([folder / _CALIBRATION], "kitti-odometry", hints=hints, if_missing=_IF_MISSING)
    return folder, rig, pairs


def _read_times(path: Path, pairs: int) -> list[float] | None:
    """Seconds, a line for each image; None if the file is missing, or not of these images."""
    try:
        times = [float(line) for line in read_text(path).split()] if path.is_file() else []
    except ValueError:
        return None
    return times if len(times) == pairs and np.isfinite(times).all() else None
