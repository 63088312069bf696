"""The arguments for the limits of the decision."""

import argparse


def add_tolerances_to(parser: argparse.ArgumentParser) -> None:
    """Add `--distances` and `--tolerances`."""
    parser.add_argument(
        "--distances",
        metavar="B,B",
        help="in baselines, at which rows are judged, and depth at the farthest of them (default: 5,10,30)",
    )
    parser.add_argument(
        "--tolerances",
        metavar="NAME=VALUE,…",
        help="limits of the decision, such as alpha=0.001,worse_depth_points=0.5: alpha, gain_px, worse_rows_px, "
        "worse_depth_points, blind_rows_px, good_rows_px, good_surely",
    )
