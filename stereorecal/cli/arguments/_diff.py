"""The arguments of `python -m stereorecal diff`."""

import argparse

from stereorecal.cli.arguments._calibrations import add_reading_to

_DESCRIPTION = """\
What calibration B changes against calibration A of the same rig: rotation, direction and length of the baseline; and,
for those who use A if B is right, the epipolar error over the view and the depth error at 5, 10, 30 and 100 baselines.
Without --unit, the unit of a file that states none is inferred from its baseline. Exit code: 0 done; 2 bad input; 3
internal failure."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "diff", parents=[common], help="what one calibration changes against another", description=_DESCRIPTION
    )
    add = parser.add_argument
    add(
        "before",
        metavar="A",
        help="calibration file of any format, LEFT,RIGHT where each camera has its own, or a folder",
    )
    add("after", metavar="B", help="likewise")
    add_reading_to(parser)
    add("--json", metavar="FILE|-", help="write everything as JSON, with a map of the epipolar error")
    add("--force", action="store_true", help="--json may replace a file that is no input")
    add("--quiet", action="store_true", help="print nothing")
    parser.set_defaults(verb="diff")
