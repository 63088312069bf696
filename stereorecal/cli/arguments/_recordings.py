"""The arguments that say which recordings a command is about."""

import argparse

from stereorecal.cli.arguments._calibrations import FORMATS, UNIT

_LAYOUTS = "scene folder, plain log, MODD2, MODS, KITTI raw, KITTI odometry, KITTI stereo, EuRoC, Middlebury"


def add_recordings_to(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that `recordings` reads."""
    parser.add_argument(
        "scenes",
        nargs="*",
        metavar="SCENE",
        help="folder with left and right images and their calibration, in any layout that is known (documentation, "
        f"page Your data): {_LAYOUTS}",
    )
    add = parser.add_argument_group("images from elsewhere, with --calibration").add_argument
    add("--left", metavar="FILES", help="left images: a file, a folder or 'left/*.png'; or a video")
    add("--right", metavar="FILES", help="their right images, or the right video")
    add("--side-by-side", metavar="FILES", help="instead: images, or a video, with left and right side by side")
    add("--bag", metavar="BAG", help="instead: a bag of ROS 1 (file) or ROS 2 (folder)")
    add("--left-topic", metavar="TOPIC", help="of the bag: the left images, raw or compressed")
    add("--right-topic", metavar="TOPIC", help="of the bag: the right images")
    add(
        "--calibration",
        nargs="+",
        metavar="FILE",
        help="their calibration, in any format; two files where each camera has its own",
    )
    add("--format", metavar="FORMAT", help=f"of --calibration (default: recognised): {FORMATS}")
    add("--unit", metavar="UNIT", help=UNIT)
    add(
        "--tolerance",
        type=float,
        metavar="SECONDS",
        help="how far apart the two frames of a pair may be (default: a quarter of the time between frames; image "
        "files are paired by names, and by times in their names only if this is given)",
    )
    add = parser.add_argument_group("which pairs").add_argument
    add("--from", dest="first", type=int, default=0, metavar="N", help="number of the first pair (default: 0)")
    add("--to", dest="stop", type=int, metavar="N", help="number of the pair to stop before (default: none)")
    add("--every", type=int, default=1, metavar="N", help="every Nth pair (default: 1)")
    add("--frames", default="all", metavar="N|all", help="the first N of those (default: all)")
    add(
        "--limit",
        metavar="N|all",
        help="of those, at most N: of N equal stretches the pair with the most texture (default: 24 of a video, a "
        "bag or more than 100 pairs, else all; monitor: all); all pairs are used jointly",
    )
