"""Folders of a user's own that judges look into."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from stereorecal import InputError
from stereorecal.cli import existing_folder
from stereorecal.geometry import StereoRig
from stereorecal.io import load_scene
from stereorecal.recordings import Scene
from stereorecal_field.judges._optics import check_lenses


def scene_folders(folder: Path) -> list[Path]:
    """The folder itself if it is a scene, else the scenes in it, at any depth.

    Raises:
        InputError: if there is none.
    """
    found = sorted(file.parent for file in existing_folder(folder).rglob("calib.json"))
    found = [folder] if folder in found else found
    if not found:
        raise InputError(f"{folder}: there is no scene folder (calib.json and images) in it; see docs/data.md.")
    return found


def name_of_scene(scene: Path, folder: Path) -> str:
    """What a scene is called: its place in the folder that was given."""
    return folder.name if scene == folder else scene.relative_to(folder).as_posix()


@lru_cache(maxsize=16)
def whole_scene(folder: str) -> Scene:
    """With all pairs in memory."""
    scene = load_scene(folder)
    return replace(scene, pairs=tuple(scene.pairs))


def judged_rig(scene: Scene) -> StereoRig:
    """The stored calibration.

    Raises:
        InputError: if there is none, or its lenses cannot be judged.
    """
    if scene.rig is None:
        raise InputError(f"{scene.name}: the scene has no calibration; a judge needs one to start from.")
    check_lenses(scene.rig)
    return scene.rig


def check_rigs(folders: list[Path]) -> None:
    """Raises: InputError: if a scene has no calibration, or lenses that cannot be judged."""
    for folder in folders:
        judged_rig(load_scene(folder, limit=1))
