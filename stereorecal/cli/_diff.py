"""`python -m stereorecal diff`."""

import argparse
from pathlib import Path

from stereorecal._errors import InputError
from stereorecal._versions import versions
from stereorecal.cli import _values
from stereorecal.cli._json import write_json
from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, load_scene
from stereorecal.recalibration import difference

SCHEMA = "stereorecal.difference/1"


def run(options: argparse.Namespace) -> int:
    """Compare, save, print; returns the exit code."""
    _values.output_path(options.json, "--json")
    found = difference(_rig(Path(options.before)), _rig(Path(options.after)))
    if options.json is not None:
        names = {"before": options.before, "after": options.after}
        write_json({"schema": SCHEMA, "versions": versions(), **names, **found.as_dict()}, options.json)
    if not options.quiet and options.json != "-":
        print(found)
        print("rows and depth: how wrong the first is if the second is right; B: baselines of the second")
    return 0


def _rig(path: Path) -> StereoRig:
    """The rig in a calibration file, or in a folder, whose images are not looked at if it has a calib.json."""
    inside = path / "calib.json"
    if inside.is_file() or not path.is_dir():
        return load_rig(inside if inside.is_file() else path)
    rig = load_scene(path, limit=1).rig
    if rig is None:
        raise InputError(f"{path}: there is no calibration in it; give one that has.")
    return rig
