"""Depth that is known for some pixels, by lidar or dense truth, as judge."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

from stereorecal import InputError
from stereorecal.comparison import DISTANCES
from stereorecal.geometry import StereoRig
from stereorecal.io import load_scene
from stereorecal.recordings import Scene
from stereorecal_field.judges._case import DEFAULT_PRIOR, AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._judgement import Judgement
from stereorecal_field.judges._scene_folders import check_rigs, judged_rig, name_of_scene, scene_folders
from stereorecal_field.judges._true_disparity import depth_by_truth, scene_with_truth


@dataclass(frozen=True)
class Lidar(AbstractRecipe):
    """A scene whose depth is known for some pixels.

    Attributes:
        folder: a scene folder with true disparities, stored rectified.
    """

    judge: ClassVar[str] = "lidar"
    judged_by: ClassVar[str] = "by depths that are known: lidar, or dense truth"

    folder: str

    def make(self) -> Case:
        scene = _true_scene(self.folder)
        stored = judged_rig(scene)
        return Case(self.drifted(stored), scene.pairs, DEFAULT_PRIOR, _ByLidar(stored, scene))


@dataclass(frozen=True, eq=False)
class _ByLidar:
    stored: StereoRig
    scene: Scene

    def __call__(self, rig: StereoRig) -> Judgement:
        errors = depth_by_truth(rig, self.stored, self.scene)
        return Judgement(errors.rows_px, {distance: errors.depth_error_percent(distance) for distance in DISTANCES})


def lidar_recipes(place: str, draws: Draws) -> tuple[Lidar, ...]:
    """The recipes of each scene in a folder that names true disparities."""
    folder = Path(place)
    true = [one for one in scene_folders(folder) if load_scene(one, limit=1).info.get("disparity_gt")]
    for one in true:
        _true_scene(str(one))
    if not true:
        raise InputError(f"{folder}: no scene names a disparity_gt in its calib.json; lidar judges by it.")
    check_rigs(true)
    return tuple(
        Lidar(name_of_scene(one, folder), draw, *draws.drift, str(one)) for one in true for draw in draws.of_folders
    )


@lru_cache(maxsize=4)
def _true_scene(folder: str) -> Scene:
    return scene_with_truth(Path(folder))
