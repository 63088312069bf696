"""Writing plain logs: one folder per sequence, one calibration file per date; `stereorecal.io.load_log` reads them."""

import re
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path

from stereorecal import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io import make_folder, save_rig, write_json, write_png
from stereorecal.recordings import Mission, names_of

_CALIBRATIONS, _SEQUENCES, _FACTS, _TRUTH = "calibrations", "sequences", "mission.json", "truth.json"
_IMAGE = re.compile(r"\.(png|jpe?g|jp2|tiff?|bmp|p[gpn]m|webp)$", re.IGNORECASE)


def save_calibrations(
    calibrations: Mapping[str, StereoRig], folder: str | PathLike[str], overwrite: bool = False
) -> None:
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


def save_mission(mission: Mission, folder: str | PathLike[str]) -> None:
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
    names = {name: f"{_IMAGE.sub('', name)}.png" for name in names_of(mission.pairs)}
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


def has_mission(folder: str | PathLike[str], name: str) -> bool:
    """Whether a plain log has a sequence of this name that was written completely."""
    return (Path(folder) / _SEQUENCES / name / _FACTS).exists()
