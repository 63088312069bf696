"""Middlebury 2014, 2021 and MiddEval3: one rectified pair per folder."""

from pathlib import Path

from stereorecal.io.layouts import Sequence, load_matched, log_of, natural_order, read_files
from stereorecal.recordings import Log

LAYOUT = "Middlebury 2014, 2021 or MiddEval3 (im0.png, im1.png, calib.txt), or a folder of such scenes"
_CALIBRATION, _LEFT, _RIGHT = "calib.txt", "im0.png", "im1.png"


def recognises(folder: Path) -> bool:
    """Whether the folder is a Middlebury scene or contains some."""
    return (folder / _LEFT).is_file() or any(folder.glob(f"*/{_LEFT}"))


def read(folder: Path, limit: int | None) -> Log:
    """The scene, or each scene in the folder as a mission.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    scenes = [folder] if (folder / _LEFT).is_file() else [image.parent for image in folder.glob(f"*/{_LEFT}")]
    return log_of(folder, (_sequence(scene, limit) for scene in natural_order(scenes)))


def _sequence(scene: Path, limit: int | None) -> Sequence:
    rig = read_files([scene / _CALIBRATION], "middlebury")
    return scene, rig, load_matched([(scene / _LEFT, scene / _RIGHT)], limit)
