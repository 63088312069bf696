"""Middlebury 2014, 2021 and MiddEval3: one rectified pair per folder."""

from pathlib import Path

import numpy as np

from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._about import about
from stereorecal.io.formats._numbers import numbers, whole
from stereorecal.io.formats._text import read_text
from stereorecal.io.images._files import natural_order
from stereorecal.io.images._matched import load_matched
from stereorecal.io.layouts._sequences import Sequence, log_of
from stereorecal.recordings import Log

LAYOUT = "Middlebury 2014, 2021 or MiddEval3 (im0.png, im1.png, calib.txt), or a folder of such scenes"
_CALIBRATION, _LEFT, _RIGHT = "calib.txt", "im0.png", "im1.png"


def recognises(folder: Path) -> bool:
    """Whether the folder is a scene of Middlebury, or has some in it."""
    return (folder / _LEFT).is_file() or any(folder.glob(f"*/{_LEFT}"))


def read(folder: Path, limit: int | None) -> Log:
    """The scene, or each scene in the folder as a mission.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    scenes = [folder] if (folder / _LEFT).is_file() else [image.parent for image in folder.glob(f"*/{_LEFT}")]
    return log_of(folder, (_sequence(scene, limit) for scene in natural_order(scenes)))


def _sequence(scene: Path, limit: int | None) -> Sequence:
    return scene, _rig(scene / _CALIBRATION), load_matched([(scene / _LEFT, scene / _RIGHT)], limit)


def _rig(path: Path) -> StereoRig:
    """The cameras look the same way; their principal columns differ by doffs."""
    lines = (line.partition("=") for line in read_text(path).splitlines())
    content = {key.strip(): [row.split() for row in value.strip(" []").split(";")] for key, _, value in lines}
    with about(path):
        width, height = (whole(numbers(content, key, ()), key) for key in ("width", "height"))
        left, right = (Camera((width, height), numbers(content, key, (3, 3))) for key in ("cam0", "cam1"))
        baseline = float(numbers(content, "baseline", ())) / 1000.0
        return StereoRig.from_rotation(left, right, np.eye(3), np.array([-baseline, 0.0, 0.0]))
