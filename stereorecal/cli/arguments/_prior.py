"""The argument that says how well the initial calibration is known."""

import argparse


def add_prior_to(parser: argparse.ArgumentParser) -> None:
    """Add `--prior`."""
    parser.add_argument(
        "--prior",
        metavar="saved|default|exact",
        help="how well the initial calibration is known: saved, as an earlier repair left it; default, as after a "
        "chessboard calibration of this rig; exact: every epipolar error is a drift (default: saved, if it was)",
    )
