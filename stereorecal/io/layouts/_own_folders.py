"""Folders as this library has them: scenes, left.* and right.*, or folders of these names, beside a calib.json; and
plain logs, for recordings of one's own, with a folder for each sequence and a calibration file for each date."""

import math
import os
import re
from collections.abc import Iterable, Mapping
from operator import methodcaller
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._atomic import write_text
from stereorecal.io._read_files import AnyPath, about, check_there
from stereorecal.io._scenes import Calibration, fitting, load_calibration
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._load_rig import read_files
from stereorecal.io.formats._read_rig import as_in_file
from stereorecal.io.formats._rig_file import own_prior, with_prior
from stereorecal.io.formats._stereorecal import KEYS, NAME, calibration_of, calibration_text
from stereorecal.io.formats.text._document import Syntax, read_document
from stereorecal.io.images._image_files import images_in, natural_order, write_png
from stereorecal.io.images._load_pairs import Sizes, load_matched
from stereorecal.io.images._match_by_name import match_all
from stereorecal.recordings import LazyPairs, Log, Mission, Pair, Scene, check_pairs

_CALIBRATION_FILE = "calib.json"
_ADVICE = (
    "check the path, or write a calib.json there; or, for a calibration in another format, say --left, --right and "
    "--calibration (in Python: sr.io.load_pairs and sr.io.load_rig)."
)
_TIMES = "times_s"
_READOUT = "readout_s"  # of rolling shutters


def folder_name(folder: Path) -> str:
    """The last two parts of a folder's path, "<parent>/<folder>": the name of a scene or a log."""
    return "/".join(folder.resolve().parts[-2:]).lstrip("/")


def is_scene_folder(folder: Path) -> bool:
    """Whether a folder contains a calib.json."""
    return (folder / _CALIBRATION_FILE).is_file()


def open_scene_folder(folder: Path, limit: int | None) -> tuple[Calibration, LazyPairs]:
    """The calibration of a scene folder, and its pairs, checked against it when they are read."""
    check_there(folder / _CALIBRATION_FILE, _ADVICE)
    calibration = load_calibration((folder / _CALIBRATION_FILE,), NAME, None, Hints())
    pairs = load_sides(folder, limit, calibration.info.get(_TIMES), calibration.sizes)
    if isinstance(readout := calibration.info.get(_READOUT), int | float):
        pairs = pairs.mapped(methodcaller("read_out", readout))
    return calibration, fitting(folder, calibration, pairs)


def load_sides(folder: Path, limit: int | None, times: Any = None, sizes: Sizes | None = None) -> LazyPairs:
    """The pairs of `left.*` and `right.*`, or of the folders `left` and `right` with equal names; with the times of a
    calib.json, in seconds, if these are some, and fitted to the sizes that the calibration is for."""
    matched = match_all(*(_side_files(folder, side) for side in ("left", "right")))
    known = isinstance(times, list) and len(times) == len(matched)
    known = known and all(isinstance(time, int | float) and math.isfinite(time) for time in times)
    return load_matched(matched, limit, times if known else None, sizes)


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
    pairs = tuple(pair.as_taken() for pair in scene.pairs)
    if scene.rig is not None:
        check_pairs(scene.rig, scene.pairs)
    if scene.rig is None:
        facts = {**dict.fromkeys(KEYS), "image_size": list(pairs[0].size)}
    else:
        facts = calibration_of(as_in_file(scene.rig, exchanged=False))
    times = [pair.time for pair in scene.pairs]
    known = {_TIMES: times} if None not in times else {}
    if len(readouts := {pair.readout for pair in scene.pairs}) == 1:
        known |= {_READOUT: readouts.pop()} if any(readouts) else {}
    others = {name: value for name, value in scene.info.items() if name not in (_TIMES, _READOUT)}
    text = calibration_text({**others, **known, **facts, "reference": scene.reference})
    if scene.rig is not None:
        text = with_prior(text, own_prior(scene.rig))
    images: dict[Path, Float[np.ndarray, "h w"]] = {}
    for name, pair in zip(_file_names(scene.pairs), pairs, strict=True):
        images[folder / f"left{name}.png"], images[folder / f"right{name}.png"] = pair.left, pair.right
    _check_free(folder, {*images, folder / _CALIBRATION_FILE}, overwrite)
    for path, image in images.items():
        write_png(path, image)
    write_text(folder / _CALIBRATION_FILE, text)


def _side_files(folder: Path, side: str) -> list[Path]:
    """The images of one side: the file `side.*` or those in the folder `side`."""
    found = _images_of(folder, side)
    if not found:
        raise InputError(f"{folder}: there is no image {side}.* and no folder {side} with images; add them.")
    if found[0].parent == folder and len(found) > 1:
        raise InputError(f"{folder}: both {found[0].name} and {found[1].relative_to(folder)} are there; remove one.")
    return found


def _images_of(folder: Path, side: str) -> list[Path]:
    """The images `side.*`, and those in the folder `side`."""
    return [path for path in images_in(folder) if path.stem == side] + images_in(folder / side)


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
        raise InputError(f"{existing[0]}: the file exists already; choose another folder, or say overwrite=True.")
    for side in ("left", "right"):
        for path in _images_of(folder, side):
            if path not in targets:
                raise InputError(f"{path}: this image would mix with the scene; choose another folder.")


# --- plain logs

LAYOUT = "a plain log (calibrations/DATE.json, sequences/DATE.../left and right), or one sequence of it"
_CALIBRATIONS, _SEQUENCES, _FACTS, _TRUTH = "calibrations", "sequences", "mission.json", "truth.json"


def recognises(folder: Path) -> bool:
    """Whether the folder is a plain log or one of its sequences."""
    return _log_of(folder) is not None


def _log_of(folder: Path) -> Path | None:
    """The folder of the plain log that a folder is, or is a sequence of; None if it is neither."""
    place = Path(os.path.abspath(folder))  # "." has no name
    for root in (folder, place.parents[1]) if place.parent.name == _SEQUENCES else (folder,):
        if any((root / _CALIBRATIONS).glob("*.json")) and (root / _SEQUENCES).is_dir():
            return root
    return None


def read(folder: Path, limit: int | None) -> Log:
    """The log of `calibrations/DATE.json`, with the keys of a calib.json, and `sequences/NAME/`, with images as in a
    scene folder. Names of sequences begin with a date; the latest calibration of that date or before it holds.

    A sequence may have a mission.json, in which `calibration` names another calibration and `starred` lists the images
    from which little can be expected, and a truth.json with the true rig."""
    root = _log_of(folder) or folder
    calibrations = {
        path.stem: read_files([path]).side_by_side() for path in natural_order((root / _CALIBRATIONS).glob("*.json"))
    }
    places = (root / _SEQUENCES).iterdir() if root == folder else [Path(os.path.abspath(folder))]
    sequences = natural_order(path for path in places if path.is_dir())
    with about(folder):
        return Log(folder_name(folder), calibrations, tuple(_mission(path, calibrations, limit) for path in sequences))


def _mission(folder: Path, calibrations: Mapping[str, StereoRig], limit: int | None) -> Mission:
    facts = read_document(folder / _FACTS, Syntax.JSON).content if (folder / _FACTS).exists() else {}
    truth = read_files([folder / _TRUTH]).side_by_side() if (folder / _TRUTH).exists() else None
    pairs = load_sides(folder, limit)
    with about(folder / _FACTS):
        calibration, starred = facts.get("calibration"), facts.get("starred", [])
        if not isinstance(calibration, str | None):
            raise InputError("calibration must be the name of a calibration, in quotes; correct it.")
        if not (isinstance(starred, list) and all(isinstance(name, str) for name in starred)):
            raise InputError('starred must be a list of image names, such as ["0004.png"]; correct it.')
        unknown = set(starred) - set(pairs.names)
        if unknown and limit is None:
            raise InputError(f"starred names {min(unknown)}, which is no left image of the sequence; correct it.")
    name = calibration or _latest(folder.name, calibrations)
    rig = calibrations.get(name)  # the log says if there is none
    if rig is not None:
        pairs = fitting(folder, Calibration(rig), pairs)
    return Mission(folder.name, name, pairs, frozenset(starred), truth)


def _latest(name: str, dates: Iterable[str]) -> str:
    before = [date for date in dates if date <= name]
    if not before:
        raise InputError(
            f"{name}: no calibration is of that date or before it; begin the names of sequences and of calibrations "
            f"with a date such as 2026-05-31, or name the calibration in {_FACTS}."
        )
    return max(before)
