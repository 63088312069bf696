"""Scene folders: left.* and right.*, or folders of these names, beside a calib.json."""

import re
from itertools import chain
from pathlib import Path

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.io._about import about
from stereorecal.io._atomic import write_text
from stereorecal.io._paths import AnyPath
from stereorecal.io._scenes import scene_of
from stereorecal.io.formats._calibration import load_calibration
from stereorecal.io.formats._stereorecal import NAME, calibration_of, calibration_text
from stereorecal.io.images._files import images_in, natural_order, write_png
from stereorecal.io.images._match import match_files
from stereorecal.io.images._pairs import Choose, load_matched
from stereorecal.io.layouts._names import name_of
from stereorecal.recordings import Pair, Scene, check_pairs

_CALIBRATION_FILE = "calib.json"


def is_scene_folder(folder: Path) -> bool:
    """Whether a folder contains a calib.json."""
    return (folder / _CALIBRATION_FILE).is_file()


def load_scene_folder(folder: Path, limit: int | None = None, choose: Choose | None = None) -> Scene:
    """The scene in a folder as `load_scene` describes it."""
    calibration = load_calibration((folder / _CALIBRATION_FILE,), NAME)
    pairs = load_sides(folder, limit, choose)
    with about(folder):
        return scene_of(name_of(folder), calibration, pairs)


def load_sides(folder: Path, limit: int | None, choose: Choose | None = None) -> tuple[Pair, ...]:
    """The pairs of `left.*` and `right.*`, or of the folders `left` and `right` with equal names.

    Raises:
        InputError: naming the file, if one is missing, has no partner, or is damaged.
    """
    matched = match_files(*(_side_files(folder, side) for side in ("left", "right")), by_order=False)
    return load_matched(matched, limit, choose)


def save_scene(scene: Scene, folder: AnyPath, overwrite: bool = False) -> None:
    """Write a scene as a folder that `load_scene` reads back: calib.json and 8-bit grey PNG (values rounded).

    One pair becomes left.png and right.png; several become left/NAME.png and right/NAME.png, or numbered files if
    their names are no valid file names or would change their order. Files that `scene.info` mentions are not copied.
    Each file is written whole or not at all, calib.json last.

    Args:
        overwrite: whether existing files may be replaced.

    Raises:
        InputError: if the scene has no pair or does not fit its calibration, files exist already, or the folder holds
            images that `load_scene` would take for part of the scene. Nothing is written then.
    """
    folder = Path(folder)
    if not scene.pairs:
        raise InputError(f"the scene {scene.name!r} has no image pair; give at least one.")
    if scene.rig is not None:
        check_pairs(scene.rig, scene.pairs)
    facts = calibration_of(scene.rig, scene.pairs[0].size)
    text = calibration_text({**scene.info, **facts, "reference": scene.reference})
    images: dict[Path, Float[np.ndarray, "h w"]] = {}
    for name, pair in zip(_file_names(scene.pairs), scene.pairs, strict=True):
        images[folder / f"left{name}.png"], images[folder / f"right{name}.png"] = pair.left, pair.right
    _check_free(folder, {*images, folder / _CALIBRATION_FILE}, overwrite)
    for path, image in images.items():
        write_png(path, image)
    write_text(folder / _CALIBRATION_FILE, text)


def _side_files(folder: Path, side: str) -> list[Path]:
    """The images of one side: the file `side.*` or those in the folder `side`.

    Raises:
        InputError: if there is none, or both.
    """
    single, several = _images_of(folder, side)
    if not (single or several):
        raise InputError(f"{folder}: there is no image {side}.* and no folder {side} with images; add them.")
    if len(single) > 1 or (single and several):
        other = single[1] if len(single) > 1 else several[0]
        raise InputError(f"{folder}: both {single[0].name} and {other.relative_to(folder)} are there; remove one.")
    return single or several


def _images_of(folder: Path, side: str) -> tuple[list[Path], list[Path]]:
    return [path for path in images_in(folder) if path.stem == side], images_in(folder / side)


def _file_names(pairs: tuple[Pair, ...]) -> list[str]:
    """The part of each pair's file names after "left" and "right", without suffix: "" or "/NAME"."""
    if len(pairs) == 1:
        return [""]
    names = [Path(Path(pair.name).stem) for pair in pairs]
    usable = all(re.fullmatch(r"\w[\w +-]*", str(name)) for name in names)
    if not usable or len(set(names)) < len(names) or natural_order(names) != names:
        names = [Path(f"{index:06d}") for index in range(len(pairs))]
    return [f"/{name}" for name in names]


def _check_free(folder: Path, targets: set[Path], overwrite: bool) -> None:
    existing = natural_order(path for path in targets if path.exists())
    if existing and not overwrite:
        raise InputError(f"{existing[0]}: the file exists already; choose another folder or allow overwriting.")
    for side in ("left", "right"):
        for path in chain(*_images_of(folder, side)):
            if path not in targets:
                raise InputError(f"{path}: this image would mix with the scene; choose another folder.")
