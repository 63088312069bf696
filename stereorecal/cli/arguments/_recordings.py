"""The arguments that say which recordings a command is about."""

import argparse

from stereorecal.cli.arguments._calibrations import FORMATS, UNIT


def add_recordings_to(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that `recordings` reads."""
    add = parser.add_argument
    add("scenes", nargs="*", metavar="SCENE", help="scene folder: left.*, right.* (or folders of images), calib.json")
    add("--left", metavar="FILES", help="instead of a scene: left images; file, folder or 'left/*.png'")
    add("--right", metavar="FILES", help="their right images")
    add(
        "--calibration",
        nargs="+",
        metavar="FILE",
        help="their calibration, in any format; two files where each camera has its own",
    )
    add("--format", metavar="FORMAT", help=f"of --calibration (default: recognised): {FORMATS}")
    add("--unit", metavar="UNIT", help=UNIT)
    add("--frames", default="all", metavar="N|all", help="pairs of each recording to use, jointly (default: all)")
