"""The arguments that say how calibration files are read."""

import argparse

FORMATS = "opencv, ros, kalibr, kitti-raw, kitti-odometry, middlebury, euroc, basalt, depthai, boofcv, stereorecal"
TWO_FILES = "the two files of a calibration are named as LEFT,RIGHT"
UNIT = (
    "of lengths in a calibration that states none, read or written: m, cm, mm, in (default: inferred from the baseline)"
)


def add_reading_to(parser: argparse.ArgumentParser, option: str = "--format") -> None:
    """Add --format, or the same under another name, --unit and --size."""
    add = parser.add_argument
    add(option, dest="format", metavar="FORMAT", help=f"of the calibration file (default: recognised): {FORMATS}")
    add("--unit", metavar="UNIT", help=UNIT)
    add("--size", metavar="WxH", help="of the images, for a calibration that says none")
