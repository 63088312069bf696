"""Other scenes of the same rig as judge. Depth is not judged."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from stereorecal import InputError
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io import load_scene
from stereorecal.recordings import Scene
from stereorecal_field.judges._case import DEFAULT_PRIOR, AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._judgement import Judgement
from stereorecal_field.judges._rows import row_error_px
from stereorecal_field.judges._scene_folders import judged_rig, name_of_scene, scene_folders, whole_scene

FEWEST_SCENES = 3  # one is looked at, the others judge


@dataclass(frozen=True)
class Product(AbstractRecipe):
    """A scene of a rig of which there are others: rows of those that nobody looked at. Depth is not judged.

    Attributes:
        folder: of the scene.
        others: folders of the other scenes.
    """

    judge: ClassVar[str] = "product"
    judged_by: ClassVar[str] = "by the epipolar error of scenes of the same rig that no method saw; depth is not judged"

    folder: str
    others: tuple[str, ...]

    def make(self) -> Case:
        scene = whole_scene(self.folder)
        stored = judged_rig(scene)
        others = tuple(whole_scene(other) for other in self.others)
        return Case(self.drifted(stored), scene.pairs, DEFAULT_PRIOR, _ByOthers(stored, others))


@dataclass(frozen=True, eq=False)
class _ByOthers:
    stored: StereoRig
    others: tuple[Scene, ...]

    def __call__(self, rig: StereoRig) -> Judgement:
        return Judgement(float(np.median([row_error_px(rig, self.stored, other) for other in self.others])))


def product_recipes(place: str, draws: Draws) -> tuple[Product, ...]:
    """The recipes of each scene in a folder, judged by the others."""
    folder = Path(place)
    folders = scene_folders(folder)
    _check_one_rig(folder, folders)
    found = []
    for one in folders:
        others = tuple(str(other) for other in folders if other != one)
        name = name_of_scene(one, folder)
        found += [Product(name, draw, *draws.drift, str(one), others) for draw in draws.of_folders]
    return tuple(found)


def _check_one_rig(folder: Path, folders: list[Path]) -> None:
    """Raises: InputError: if there are too few scenes, or of several rigs."""
    if len(folders) < FEWEST_SCENES:
        raise InputError(f"{folder}: a product needs {FEWEST_SCENES} scenes of one rig or more; {len(folders)} found.")
    first, *others = (judged_rig(load_scene(folder, limit=1)) for folder in folders)
    for one, rig in zip(folders[1:], others, strict=True):
        if not same_rig(first, rig):
            raise InputError(f"{one}: has another calibration than {folders[0]}; give scenes of one rig.")
