"""The plain log, the layout that this library writes: one folder per sequence, one calibration file per date."""

import os
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._atomic import make_folder
from stereorecal.io._read_files import AnyPath, about
from stereorecal.io._scenes import fitting
from stereorecal.io._strict_json import write_json
from stereorecal.io.formats._load_and_save import load_rig, save_rig
from stereorecal.io.formats._scene_calibration import Calibration, read_json_object
from stereorecal.io.images._image_files import natural_order, stem_of, write_png
from stereorecal.io.layouts._log_of_sequences import folder_name
from stereorecal.io.layouts._scene_folder import load_sides
from stereorecal.recordings import Log, Mission, names_of

LAYOUT = "a plain log (calibrations/DATE.json, sequences/DATE.../left and right), or one sequence of it"
_CALIBRATIONS, _SEQUENCES, _FACTS, _TRUTH = "calibrations", "sequences", "mission.json", "truth.json"


def recognises(folder: Path) -> bool:
    """Whether the folder is a plain log or one of its sequences."""
    return _is_log(folder) or _is_log(_around(folder))


def _is_log(folder: Path) -> bool:
    return any((folder / _CALIBRATIONS).glob("*.json")) and (folder / _SEQUENCES).is_dir()


def _around(sequence: Path) -> Path:
    """The folder of the log that a sequence would be of; itself, where it lies in none."""
    place = Path(os.path.abspath(sequence))  # "." has no name
    return place.parents[1] if place.parent.name == _SEQUENCES else place


def read(folder: Path, limit: int | None) -> Log:
    """The log of `calibrations/DATE.json`, with the keys of a calib.json, and `sequences/NAME/`, with images as in a
    scene folder. Names of sequences begin with a date; the latest calibration of that date or before it holds.

    A sequence may have a mission.json, in which `calibration` names another calibration and `starred` lists the images
    from which little can be expected, and a truth.json with the true rig.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    one = not _is_log(folder)
    root = _around(folder) if one else folder
    calibrations = {
        path.stem: load_rig(path).side_by_side() for path in natural_order((root / _CALIBRATIONS).glob("*.json"))
    }
    places = (root / _SEQUENCES).iterdir() if not one else [Path(os.path.abspath(folder))]
    sequences = natural_order(path for path in places if path.is_dir())
    with about(folder):
        return Log(folder_name(folder), calibrations, tuple(_mission(path, calibrations, limit) for path in sequences))


def _mission(folder: Path, calibrations: Mapping[str, StereoRig], limit: int | None) -> Mission:
    facts = read_json_object(folder / _FACTS) if (folder / _FACTS).exists() else {}
    truth = load_rig(folder / _TRUTH).side_by_side() if (folder / _TRUTH).exists() else None
    pairs = load_sides(folder, limit)
    with about(folder / _FACTS):
        calibration, starred = _mission_facts(facts)
        unknown = starred - set(pairs.names)
        if unknown and limit is None:
            raise InputError(f"starred names {min(unknown)}, which is no left image of the sequence; correct it.")
    name = calibration or _latest(folder.name, list(calibrations))
    rig = calibrations.get(name)  # the log says if there is none
    if rig is not None:
        pairs = fitting(folder, Calibration(rig.sizes_taken[0], rig), pairs)
    return Mission(folder.name, name, pairs, starred, truth)


def _mission_facts(facts: Mapping[str, Any]) -> tuple[str | None, frozenset[str]]:
    """The calibration and the starred images that a mission.json names."""
    calibration, starred = facts.get("calibration"), facts.get("starred", [])
    if not isinstance(calibration, str | None):
        raise InputError("calibration must be the name of a calibration, in quotes; correct it.")
    if not (isinstance(starred, list) and all(isinstance(name, str) for name in starred)):
        raise InputError('starred must be a list of image names, such as ["0004.png"]; correct it.')
    return calibration, frozenset(starred)


def _latest(name: str, dates: list[str]) -> str:
    before = bisect_right(sorted(dates), name)
    if before == 0:
        raise InputError(
            f"{name}: no calibration is of that date or before it; begin the names of sequences and of calibrations "
            f"with a date such as 2026-05-31, or name the calibration in {_FACTS}."
        )
    return sorted(dates)[before - 1]


def save_calibrations(calibrations: Mapping[str, StereoRig], folder: AnyPath, overwrite: bool = False) -> None:
    """Write the calibrations of a plain log, each under its name.

    Args:
        overwrite: whether existing files may be replaced.

    Raises:
        InputError: if a file exists already and may not be replaced, or the place cannot be written to.
    """
    for name in calibrations:
        _check_name(name)
    place = Path(folder) / _CALIBRATIONS
    make_folder(place)
    for name, rig in calibrations.items():
        save_rig(replace(rig, source=None), place / f"{name}.json", overwrite=overwrite, format="stereorecal")


def save_mission(mission: Mission, folder: AnyPath) -> None:
    """Write one sequence of a plain log: images as 8-bit grey PNG, named after the pairs, and mission.json last.

    Raises:
        InputError: if the sequence exists already, two pairs would have the same file name, or the place cannot be
            written to.
    """
    _check_name(mission.name)
    for name in names_of(mission.pairs):
        _check_name(name)
    place = Path(folder) / _SEQUENCES / mission.name
    if has_mission(folder, mission.name):
        raise InputError(f"{place}: the sequence is there already; choose another name or folder.")
    names = {name: f"{stem_of(name)}.png" for name in names_of(mission.pairs)}
    if len(set(names.values())) < len(mission.pairs):
        raise InputError(f"{mission.name}: two pairs would be written under the same name; rename one.")
    for pair in mission.pairs:
        taken = pair.as_taken()
        for side, image in (("left", taken.left), ("right", taken.right)):
            write_png(place / side / names[pair.name], image)
    if mission.truth is not None:
        save_rig(replace(mission.truth, source=None), place / _TRUTH, overwrite=True, format="stereorecal")
    facts = {"calibration": mission.calibration, "starred": sorted(names[name] for name in mission.starred)}
    write_json(place / _FACTS, facts)


def _check_name(name: str) -> None:
    """Refuse a name that would lead out of its folder.

    Raises:
        InputError: if it is no plain name of a file.
    """
    if name in ("", ".", "..") or any(sign in name for sign in "/\\\0"):
        raise InputError(f"{name!r} cannot be the name of a file; give one without slashes.")


def has_mission(folder: AnyPath, name: str) -> bool:
    """Whether a plain log has a sequence of this name that was written completely."""
    return (Path(folder) / _SEQUENCES / name / _FACTS).exists()
