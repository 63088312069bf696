"""Judges that are folders of a user's own: lidar, boards, scenes of a product, a drive with its poses."""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.comparison.judges._board_judge import ROWS_WORSE, by_boards
from stereorecal.comparison.judges._case import AbstractRecipe, Case, prior_of
from stereorecal.comparison.judges._judgement import DISTANCES, Judgement
from stereorecal.comparison.judges._optics import check_lenses
from stereorecal.comparison.judges._pose_judge import Travelled, depth_at, disparity_offset_px, travelled
from stereorecal.comparison.judges._rows import rows
from stereorecal.comparison.judges._true_disparity import depth_by_truth, scene_with_truth
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io import load_pairs, load_scene
from stereorecal.recordings import Board, Scene, find_boards

POSES = "poses.txt"
FEWEST_SCENES = 3  # of a product: one is looked at, the others judge


@dataclass(frozen=True)
class Lidar(AbstractRecipe):
    """A scene whose depth is known for some pixels.

    Attributes:
        folder: a scene folder with true disparities, stored rectified.
    """

    judge: ClassVar[str] = "lidar"

    folder: str

    def make(self) -> Case:
        scene = _with_truth(self.folder)
        stored = _rig(scene)
        return Case(self.drifted(stored), scene.pairs, prior_of(exact=False), _ByLidar(stored, scene))


@dataclass(frozen=True, eq=False)
class _ByLidar:
    stored: StereoRig
    scene: Scene

    def __call__(self, rig: StereoRig) -> Judgement:
        seen = depth_by_truth(rig, self.stored, self.scene)
        return Judgement(seen.rows_px, {distance: seen.depth_error_percent(distance) for distance in DISTANCES})


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

    folder: str
    boards: str
    corners: tuple[int, int]
    square: float

    def make(self) -> Case:
        scene = _scene(self.folder, None)
        stored = _rig(scene)
        seen = _boards(self.boards, self.corners, self.square)
        return Case(self.drifted(stored), scene.pairs, prior_of(exact=False), _ByBoards(stored, seen))


@dataclass(frozen=True, eq=False)
class _ByBoards:
    stored: StereoRig
    boards: tuple[Board, ...]

    def __call__(self, rig: StereoRig) -> Judgement:
        seen = by_boards(rig, self.stored, self.boards)
        depth = {distance: seen.depth_error_percent(distance) for distance in DISTANCES}
        return Judgement(seen.rows_rms_px, depth, rows_worse_px=ROWS_WORSE)


@dataclass(frozen=True)
class Product(AbstractRecipe):
    """A scene of a rig of which there are others: rows of those that nobody looked at. Depth is not judged.

    Attributes:
        folder: of the scene.
        others: folders of the other scenes.
    """

    judge: ClassVar[str] = "product"

    folder: str
    others: tuple[str, ...]

    def make(self) -> Case:
        scene = _scene(self.folder, None)
        stored = _rig(scene)
        others = tuple(_scene(other, None) for other in self.others)
        return Case(self.drifted(stored), scene.pairs, prior_of(exact=False), _ByOthers(stored, others))


@dataclass(frozen=True, eq=False)
class _ByOthers:
    stored: StereoRig
    others: tuple[Scene, ...]

    def __call__(self, rig: StereoRig) -> Judgement:
        return Judgement(float(np.median([rows(rig, self.stored, other).median_px for other in self.others])))


@dataclass(frozen=True)
class Driven(AbstractRecipe):
    """Consecutive pairs of a drive, of which it is known how far it went.

    Attributes:
        folder: a scene folder with `poses.txt`.
        frames: how many pairs methods get, from the first on; the whole drive judges.
    """

    judge: ClassVar[str] = "motion"

    folder: str
    frames: int

    def make(self) -> Case:
        scene = _scene(self.folder, None)
        stored = _rig(scene)
        seen = _travelled(self.folder)
        return Case(
            self.drifted(stored), scene.pairs[: self.frames], prior_of(exact=False), _ByPoses(stored, scene, seen)
        )


@dataclass(frozen=True, eq=False)
class _ByPoses:
    stored: StereoRig
    scene: Scene
    seen: Travelled

    def __call__(self, rig: StereoRig) -> Judgement:
        offset = disparity_offset_px(rig, self.stored, self.seen)
        depth = {distance: depth_at(offset, self.stored, distance) for distance in DISTANCES}
        return Judgement(rows(rig, self.stored, self.scene).median_px, depth)


def scene_folders(folder: Path) -> list[Path]:
    """The folder itself if it is a scene, else the scenes in it, at any depth.

    Raises:
        InputError: if there is none.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder; check the path.")
    found = sorted(file.parent for file in folder.rglob("calib.json"))
    found = [folder] if folder in found else found
    if not found:
        raise InputError(f"{folder}: there is no scene folder (calib.json and images) in it; see docs/data.md.")
    return found


def with_truth(folders: list[Path]) -> list[Path]:
    """Those that name true disparities, checked."""
    found = [folder for folder in folders if load_scene(folder, limit=1).info.get("disparity_gt")]
    for folder in found:
        _with_truth(str(folder))
    return found


def boards_beside(folder: Path) -> Path:
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


def check_rigs(folders: list[Path]) -> None:
    """Raises: InputError: if a scene has no calibration, or lenses that cannot be judged."""
    for folder in folders:
        _rig(load_scene(folder, limit=1))


def check_boards(folder: Path, corners: tuple[int, int], square: float) -> None:
    """Raises: InputError: if no board is found."""
    _boards(str(folder), corners, square)


def check_drive(folder: Path) -> None:
    """Raises: InputError: if it is no drive with poses."""
    _travelled(str(folder))


def check_one_rig(folders: list[Path]) -> None:
    """Raises: InputError: if there are too few scenes, or of several rigs."""
    if len(folders) < FEWEST_SCENES:
        raise InputError(
            f"{folders[0].parent}: {len(folders)} scenes; a product needs {FEWEST_SCENES} of one rig or more."
        )
    first, *others = (_rig(load_scene(folder, limit=1)) for folder in folders)
    for folder, rig in zip(folders[1:], others, strict=True):
        if not same_rig(first, rig):
            raise InputError(f"{folder}: has another calibration than {folders[0]}; give scenes of one rig.")


@lru_cache(maxsize=16)
def _scene(folder: str, limit: int | None) -> Scene:
    scene = load_scene(folder, limit=limit)
    return replace(scene, pairs=tuple(scene.pairs))


@lru_cache(maxsize=4)
def _with_truth(folder: str) -> Scene:
    return scene_with_truth(Path(folder))


@lru_cache(maxsize=2)
def _boards(folder: str, corners: tuple[int, int], square: float) -> tuple[Board, ...]:
    return find_boards(load_pairs(Path(folder) / "left*", Path(folder) / "right*"), corners, square)


@lru_cache(maxsize=2)
def _travelled(folder: str) -> Travelled:
    scene = _scene(folder, None)
    return travelled(_rig(scene), scene.pairs, _centres(Path(folder) / POSES, len(scene.pairs)))


def _centres(file: Path, pairs: int) -> Float[np.ndarray, "k 3"]:
    """Where the left camera stood."""
    if not file.is_file():
        raise InputError(
            f"{file}: there is no such file; motion is judged by the distances between the poses of a drive."
        )
    try:
        poses = np.loadtxt(file, ndmin=2)
    except ValueError:
        poses = np.zeros((0, 0))
    if poses.shape != (pairs, 12) or not np.isfinite(poses).all():
        raise InputError(f"{file}: holds no pose for each of {pairs} pairs; give a line of 12 numbers, 3x4, for each.")
    return poses.reshape(-1, 3, 4)[:, :, 3]


def _rig(scene: Scene) -> StereoRig:
    if scene.rig is None:
        raise InputError(f"{scene.name}: the scene has no calibration; a judge needs one to start from.")
    check_lenses(scene.rig)
    return scene.rig
