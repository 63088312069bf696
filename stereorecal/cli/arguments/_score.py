"""The arguments of `python -m stereorecal score`."""

import argparse

from stereorecal.cli.arguments._recordings import add_recordings_to

_DESCRIPTION = """\
Check the calibration of each recording against its images, without changing anything: how many pixels match, the median
epipolar (row) error, and how much of the image is covered by correspondences good to a fraction of a pixel. A rig is
healthy if these cover at least 10 % of the image and the row error is at most 0.3 px. A
yaw error hardly shows, since it leaves the rows aligned while depth is already wrong; recalibrate sees more. Exit code:
0 all healthy; 1 not; 2 bad input; 3 internal failure; 130 interrupted."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "score", parents=[common], help="check a calibration against images", description=_DESCRIPTION
    )
    add_recordings_to(parser)
    parser.add_argument("--matcher", default="sad", metavar="NAME", help="sad, bm or sgbm")
    parser.add_argument("--json", metavar="FILE|-", help="write everything as JSON")
    parser.add_argument("--quiet", action="store_true", help="no report, only the exit code")
    parser.set_defaults(verb="score")
