"""`python -m stereorecal diff`."""

import argparse

from stereorecal._versions import versions
from stereorecal.cli import _values
from stereorecal.cli._json import write_json
from stereorecal.cli._rigs import rig_at
from stereorecal.recalibration import difference

SCHEMA = "stereorecal.difference/1"


def run(options: argparse.Namespace) -> int:
    """Compare, save, print; returns the exit code."""
    _values.output_path(options.json, "--json")
    found = difference(rig_at(options.before, options), rig_at(options.after, options))
    if options.json is not None:
        names = {"before": options.before, "after": options.after}
        write_json({"schema": SCHEMA, "versions": versions(), **names, **found.as_dict()}, options.json)
    if not options.quiet and options.json != "-":
        print(found)
        print("rows and depth: how wrong the first is if the second is right; B: baselines of the second")
    return 0
