"""The argument that says through which view images are looked at."""

import argparse


def add_view_to(parser: argparse.ArgumentParser) -> None:
    """Add `--view`."""
    parser.add_argument(
        "--view",
        metavar="NAME=VALUE,…",
        help="the rectified images, as sr.view(rig, …) makes them: projection=pinhole or equirectangular, "
        "field=DEGREES across (default: a pinhole; of fisheyes and other wide lenses that show more than a pinhole "
        "can, equirectangular)",
    )
