"""The arguments for the use of the rig's own motion."""

import argparse

_MOTION = {"auto": None, "on": True, "off": False}


def add_motion_to(parser: argparse.ArgumentParser) -> None:
    """Add `--motion` and `--readout`."""
    parser.add_argument(
        "--motion",
        default="auto",
        choices=tuple(_MOTION),
        help="use of the rig's own motion between pairs for depth: auto, where times are known and at most half a "
        "second apart; on, the pairs are consecutive, whatever their times; off (default: %(default)s)",
    )

    parser.add_argument(
        "--readout",
        type=float,
        metavar="SECONDS",
        help="time that the cameras' rolling shutters take from the first row of an image to the last, for --motion "
        "(default: that of a scene folder's calib.json, or 0, all rows at once)",
    )


def motion_of(options: argparse.Namespace) -> bool | None:
    """As `sr.recalibrate` has it."""
    return _MOTION[options.motion]
