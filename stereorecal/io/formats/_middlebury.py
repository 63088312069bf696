"""Middlebury's calib.txt (2014, 2021, MiddEval3): lines `key=values` of a rectified pair."""

from pathlib import Path

import numpy as np

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io._text import read_text
from stereorecal.io.formats._numbers import number_or_word, numbers, pixels

Rows = list[list[float | str]]


def load_middlebury(path: Path) -> StereoRig:
    """The rig that `cam0 cam1 baseline width height` describe, with the baseline in millimetres.

    The cameras have the same orientation; their principal points differ in x, by `doffs`.

    Raises:
        InputError: naming the file, if it cannot be read or does not hold a valid calibration.
    """
    lines = (line.partition("=") for line in read_text(path).splitlines())
    content = {key.strip(): _rows(values) for key, _, values in lines}
    with about(path):
        size = pixels(content, "width"), pixels(content, "height")
        left, right = (Camera(size, numbers(content, key, (3, 3))) for key in ("cam0", "cam1"))
        baseline = float(numbers(content, "baseline", ())) / 1000.0
        return StereoRig.from_rotation(left, right, np.eye(3), np.array([-baseline, 0.0, 0.0]))


def _rows(values: str) -> Rows:
    """The rows of a matrix `[a b; c d]`; a number is a matrix of one."""
    return [[number_or_word(word) for word in row.split()] for row in values.strip(" []").split(";")]
