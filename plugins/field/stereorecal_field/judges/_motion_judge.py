"""Consecutive pairs of a rig that moves as judge: of a rendered drive, or of a folder with the poses of one."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.comparison import DISTANCES
from stereorecal.geometry import StereoRig, view
from stereorecal.recordings import Pair, Scene
from stereorecal.synthetic import photographs, plan_drive
from stereorecal_field.judges._case import DEFAULT_PRIOR, AbstractRecipe, Case
from stereorecal_field.judges._distance_travelled import Travelled, depth_at, disparity_offset_px, travelled
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._judgement import Judgement
from stereorecal_field.judges._rows import row_error_px
from stereorecal_field.judges._scene_folders import judged_rig, name_of_scene, scene_folders, whole_scene
from stereorecal_field.judges._true_rig import ByTrueRig

POSES = "poses.txt"
_JUDGED_BY = "consecutive pairs; by the true rig where they are rendered, else by distances between a drive's poses"
_TOURS = ("street", "harbour")
_EVERY = {"street": 3, "harbour": 6}  # frames from one pair to the next: about a baseline
_SECONDS = 0.1  # from one pair to the next


@dataclass(frozen=True)
class Ride(AbstractRecipe):
    """Consecutive pairs of a rig that moves and has drifted. Methods are told that intrinsics are as a calibration
    leaves them, so that depth is not known before.

    Attributes:
        tour: of the drive; the draw is its seed, too.
        frames: how many pairs, about a baseline apart.
    """

    judge: ClassVar[str] = "motion"
    judged_by: ClassVar[str] = _JUDGED_BY

    tour: str
    frames: int

    def make(self) -> Case:
        every, seed = _EVERY[self.tour], self.seed + (self.draw or 0)
        number = (self.frames - 1) * every + 1
        plan = plan_drive(self.tour, seed, number, weather=False)
        pairs = tuple(_timed(islice(photographs(plan), 0, None, every)))
        truth = plan.truth(number // 2)
        start = self.drifted(truth)
        return Case(start, pairs, DEFAULT_PRIOR, ByTrueRig(truth, view(start)))


def _timed(pairs: Iterator[Pair]) -> Iterator[Pair]:
    for number, pair in enumerate(pairs):
        yield replace(pair, time=number * _SECONDS)


@dataclass(frozen=True)
class Driven(AbstractRecipe):
    """Consecutive pairs of a drive, of which it is known how far it went.

    Attributes:
        folder: a scene folder with `poses.txt`.
        frames: how many pairs methods get, from the first on; the whole drive judges.
    """

    judge: ClassVar[str] = "motion"
    judged_by: ClassVar[str] = _JUDGED_BY

    folder: str
    frames: int

    def make(self) -> Case:
        scene = whole_scene(self.folder)
        stored = judged_rig(scene)
        points = _travelled(self.folder)
        return Case(self.drifted(stored), scene.pairs[: self.frames], DEFAULT_PRIOR, _ByPoses(stored, scene, points))


@dataclass(frozen=True, eq=False)
class _ByPoses:
    stored: StereoRig
    scene: Scene
    seen: Travelled

    def __call__(self, rig: StereoRig) -> Judgement:
        offset = disparity_offset_px(rig, self.stored, self.seen)
        depth = {distance: depth_at(offset, self.stored, distance) for distance in DISTANCES}
        return Judgement(row_error_px(rig, self.stored, self.scene), depth)


def motion_recipes(place: str, draws: Draws) -> tuple[AbstractRecipe, ...]:
    """The recipes of rendered drives; or of each scene in a folder, if one is given."""
    if not place:
        tours = [_TOURS[draw % len(_TOURS)] for draw in range(draws.rides)]
        return tuple(Ride(tour, draw, *draws.drift, tour, draws.moving) for draw, tour in enumerate(tours))
    folder = Path(place)
    folders = scene_folders(folder)
    for one in folders:
        _travelled(str(one))
    return tuple(
        Driven(name_of_scene(one, folder), draw, *draws.drift, str(one), draws.moving)
        for one in folders
        for draw in draws.of_folders
    )


@lru_cache(maxsize=2)
def _travelled(folder: str) -> Travelled:
    scene = whole_scene(folder)
    return travelled(judged_rig(scene), scene.pairs, _centres(Path(folder) / POSES, len(scene.pairs)))


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
