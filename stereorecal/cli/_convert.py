"""`python -m stereorecal convert`."""

import argparse
from dataclasses import replace

from stereorecal._errors import InputError
from stereorecal.cli import _calibrations
from stereorecal.cli._rigs import rig_at
from stereorecal.io import save_rig


def run(options: argparse.Namespace) -> int:
    """Read, write, say so; returns the exit code."""
    target = _calibrations.place(options.target, "B")
    rig = rig_at(options.source, options)
    same = {path.resolve() for path in _calibrations.paths(_calibrations.place(options.source, "A"))}
    for path in _calibrations.paths(target):
        if path.resolve() in same:
            raise InputError(f"{path}: this is what is converted; give another name.")
        if path.exists() and not options.force:
            raise InputError(f"{path}: the file exists already; choose another or add --force.")
    # Without --to the name alone decides, whatever the calibration was read from.
    rig = rig if options.to else replace(rig, source=None)
    save_rig(rig, target, format=options.to, overwrite=options.force)
    if not options.quiet:
        print(f"{options.target}: written")
    return 0
