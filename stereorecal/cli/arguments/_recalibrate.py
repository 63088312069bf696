"""The arguments of `python -m stereorecal recalibrate`."""

import argparse

from stereorecal.cli.arguments._calibrations import FORMATS
from stereorecal.cli.arguments._executors import EXECUTORS
from stereorecal.cli.arguments._matchers import add_matcher_to
from stereorecal.cli.arguments._motion import add_motion_to
from stereorecal.cli.arguments._prior import add_prior_to
from stereorecal.cli.arguments._recordings import add_recordings_to
from stereorecal.cli.arguments._tolerances import add_tolerances_to
from stereorecal.cli.arguments._view import add_view_to

_DESCRIPTION = """\
Repair the extrinsic calibration of the rig of each recording from its images. The candidate is accepted only if its
row error is smaller with 99 % probability, and a larger row or depth error has a probability below 1 %. Exit code: 0
repaired, or already good; 1 not (the initial calibration stays); 2 bad input; 3 internal failure; 4 cannot tell (too
dark, too little texture, or the images do not determine what is better); 130 interrupted. Of several recordings, the
worst one decides."""


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    parser = verbs.add_parser(
        "recalibrate", parents=[common], help="repair the calibration of a rig", description=_DESCRIPTION
    )
    add_recordings_to(parser)
    add = parser.add_argument
    add_matcher_to(parser)
    add_view_to(parser)
    add(
        "--schedule",
        default="default",
        metavar="NAME",
        help="default (coarse to fine, which is used if nothing is said) or count (the paper's way)",
    )
    add("--strategy", metavar="NAME", help="for the stages of its kind (default: those of the schedule)")
    add("--scale", type=float, metavar="SCALE", help="image scale of the count schedule (default: 1)")
    add("--reach", default="3,0.03", metavar="DEG,FRACTION", help="how far the rig may have drifted (default: 3,0.03)")
    add(
        "--free",
        metavar="NAMES",
        help="what may move: rotation, extrinsics, intrinsics (shared by all recordings), pitch, left.k1 …; by commas "
        "(default: extrinsics; of one recording all else, too, where frames of four places prove that it must)",
    )
    add(
        "--extrinsics",
        default="each",
        metavar="each|one",
        help="where intrinsics are free: each recording has extrinsics of its own, or one set is that of all "
        "(default: %(default)s)",
    )
    add_prior_to(parser)
    add_motion_to(parser)
    add_tolerances_to(parser)
    add(
        "--boards",
        nargs=2,
        metavar=("LEFT", "RIGHT"),
        help="images of the chessboard that the initial calibration was made from, left and right: each a file, a "
        "folder or 'left/*.png'; needs --square",
    )
    add("--board-corners", metavar="NxM", help="inner corners of the chessboard (default: 9x6)")
    add("--square", type=float, metavar="METRES", help="side of its squares, as the calibration had it")
    add(
        "--odometer",
        metavar="FILE",
        help="a CSV of how far the rig travelled, of the clock of the pairs: time_s,metres or time_s,speed_mps or "
        "time_s,x,y,z (metres, to 5 cm); nothing is made of gaps of more than 1.1 s",
    )
    add(
        "--ranges",
        metavar="FILE",
        help="a CSV of distances: pair,column,row,metres,sigma (along the ray; depth for metres: the axis)",
    )
    add(
        "--budget",
        type=float,
        metavar="UNITS",
        help="of each recording; one unit: one matcher run on a full-size frame (default: no limit)",
    )
    add("--seed", type=int, default=0, help="same seed, same result (default: %(default)s)")
    add("--executor", default="serial", metavar="SPEC", help=EXECUTORS)
    add(
        "--output",
        metavar="FILE",
        help="write the calibration there (LEFT,RIGHT where each camera has a file), if it was accepted: in the form "
        "in which it was read, only what was estimated changes",
    )
    add("--output-format", metavar="FORMAT", help=f"of --output, if another: {FORMATS}")
    add("--in-place", action="store_true", help="replace the calibration that was read; the old one becomes NAME.bak")
    add(
        "--maps",
        metavar="FILE.npz",
        help="write maps for cv2.remap, with R1 R2 P1 P2 Q, of the repaired calibration, or of the initial one if that "
        "is already good",
    )
    add("--dry-run", action="store_true", help="write no calibration and no maps, say what would be written")
    add("--force", action="store_true", help="--output, --maps, --json and --html may replace a file that is no input")
    add("--json", metavar="FILE|-", help="write everything as JSON")
    add("--html", metavar="FILE", help="write one HTML page with pictures, to look at and to pass on")
    add("--quiet", action="store_true", help="no progress and no report")
    parser.set_defaults(verb="recalibrate")
