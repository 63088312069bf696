"""`python -m stereorecal diff`."""

import argparse

from stereorecal._environment import versions
from stereorecal.cli._calibration_files import rig_at
from stereorecal.cli._json import write_json
from stereorecal.cli._places import check_places, deliver, places_of, spare
from stereorecal.io import files_read
from stereorecal.recalibration import Difference, difference

SCHEMA = "stereorecal.difference/1"


def run(options: argparse.Namespace) -> int:
    """Compare, save, print; returns the exit code."""
    places = places_of(options, "json")
    check_places(places, force=options.force)
    with files_read() as read:
        found = difference(rig_at(options.before, options), rig_at(options.after, options))
    spare(places, read)
    deliver(lambda: _show(found, options), lambda: _save(found, options))
    return 0


def _save(found: Difference, options: argparse.Namespace) -> None:
    if options.json is not None:
        names = {"before": options.before, "after": options.after}
        content = {"schema": SCHEMA, "versions": versions(), **names, **found.as_dict()}
        write_json(content, options.json, force=options.force)


def _show(found: Difference, options: argparse.Namespace) -> None:
    if not options.quiet and options.json != "-":
        print(found)
        print("rows and depth: how wrong the first is if the second is right; B: baselines of the second")
