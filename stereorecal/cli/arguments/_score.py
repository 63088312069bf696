"""The arguments of `python -m stereorecal score`."""

import argparse

from stereorecal.cli.arguments._matchers import add_matcher_to
from stereorecal.cli.arguments._motion import add_motion_to
from stereorecal.cli.arguments._prior import add_prior_to
from stereorecal.cli.arguments._recordings import add_recordings_to
from stereorecal.cli.arguments._tolerances import add_tolerances_to
from stereorecal.cli.arguments._view import add_view_to

_DESCRIPTION = """\
Check the calibration of each recording against its images, without changing anything: the share of matched pixels, the
epipolar (row) error, the correction of the rotation, and the depth error without it, with 95 % intervals. Verdicts:
repair it (another calibration has a row error smaller by 0.05 px with 99 % probability, and a larger row or depth error
with less than 1 %; or hardly anything matches although there is texture); healthy (no significant improvement, and a
row error within 0.3 px with 95 %); cannot tell (too dark, too little texture, or no improvement is significant).
`recalibrate` decides in the same way. Exit code: 0 all healthy; 1 repair it (one of them at least); 2 bad input, also
images that are swapped, upside down or of different scenes; 3 internal failure; 4 cannot tell; 130 interrupted."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "score", parents=[common], help="check a calibration against images", description=_DESCRIPTION
    )
    add_recordings_to(parser)
    add_matcher_to(parser)
    add_view_to(parser)
    add_prior_to(parser)
    add_motion_to(parser)
    add_tolerances_to(parser)
    parser.add_argument("--json", metavar="FILE|-", help="write everything as JSON")
    parser.add_argument("--force", action="store_true", help="--json may replace a file that is no input")
    parser.add_argument("--quiet", action="store_true", help="no report, only the exit code")
    parser.set_defaults(verb="score")
