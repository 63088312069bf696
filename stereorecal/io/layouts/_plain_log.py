"""The plain log, a layout for recordings of one's own: one folder per sequence, one calibration file per date."""

import os
from bisect import bisect_right
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._scenes import Calibration, fitting, read_json_object
from stereorecal.io.formats._load_rig import load_rig
from stereorecal.io.images._image_files import natural_order
from stereorecal.io.layouts._layout import folder_name
from stereorecal.io.layouts._scene_folder import load_sides
from stereorecal.recordings import Log, Mission

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
    from which little can be expected, and a truth.json with the true rig."""
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
