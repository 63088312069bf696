"""Chessboards that the rig saw as judge."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

from stereorecal_boards import Board, find_boards

from stereorecal import InputError
from stereorecal.comparison import DISTANCES
from stereorecal.geometry import StereoRig
from stereorecal.io import load_pairs
from stereorecal_field.judges._board_errors import by_boards
from stereorecal_field.judges._case import DEFAULT_PRIOR, AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._judgement import Judgement
from stereorecal_field.judges._scene_folders import (
    check_rigs,
    judged_rig,
    name_of_scene,
    scene_folders,
    whole_scene,
)


@dataclass(frozen=True)
class Boards(AbstractRecipe):
    """A scene of a rig that saw chessboards.

    Attributes:
        folder: of the scene.
        boards: folder of the boards' images.
        corners: inside of the board, columns and rows.
        square: its side [m].
    """

    judge: ClassVar[str] = "boards"
    judged_by: ClassVar[str] = (
        "by chessboards that the rig saw: epipolar error of their corners (RMS), and the length of squares"
    )

    folder: str
    boards: str
    corners: tuple[int, int]
    square: float

    def make(self) -> Case:
        scene = whole_scene(self.folder)
        stored = judged_rig(scene)
        boards = _boards(self.boards, self.corners, self.square)
        return Case(self.drifted(stored), scene.pairs, DEFAULT_PRIOR, _ByBoards(stored, boards))


@dataclass(frozen=True, eq=False)
class _ByBoards:
    stored: StereoRig
    boards: tuple[Board, ...]

    def __call__(self, rig: StereoRig) -> Judgement:
        errors = by_boards(rig, self.stored, self.boards)
        depth = {distance: errors.depth_error_percent(distance) for distance in DISTANCES}
        return Judgement(errors.rows_rms_px, depth)


def board_recipes(place: str, draws: Draws) -> tuple[Boards, ...]:
    """The recipes of each scene in a folder, beside which the boards' images lie."""
    folder = Path(place)
    folders = scene_folders(folder)
    check_rigs(folders)
    if draws.square is None:
        raise InputError("judge boards needs --square, the side of a square in metres, such as 0.03.")
    how = str(_folder_of_boards(folder)), draws.corners, draws.square
    _boards(*how)
    return tuple(
        Boards(name_of_scene(one, folder), draw, *draws.drift, str(one), *how)
        for one in folders
        for draw in draws.of_folders
    )


def _folder_of_boards(folder: Path) -> Path:
    """The folder of the boards' images in a folder of scenes: `boards`, or one whose name begins with calibration.

    Raises:
        InputError: if there is none, or several.
    """
    found = [one for one in sorted(folder.iterdir()) if one.is_dir() and one.name.startswith(("boards", "calibration"))]
    if len(found) != 1:
        raise InputError(
            f"{folder}: {len(found)} folders are called boards… or calibration…; keep one, with images left*.* and "
            "right*.* of the chessboards."
        )
    return found[0]


@lru_cache(maxsize=2)
def _boards(folder: str, corners: tuple[int, int], square: float) -> tuple[Board, ...]:
    return find_boards(load_pairs(Path(folder) / "left*", Path(folder) / "right*"), corners, square)
