"""The argument for the use of the rig's own motion."""

import argparse

_MOTION = {"auto": None, "on": True, "off": False}


def add_motion_to(parser: argparse.ArgumentParser) -> None:
    """Add `--motion`."""
    parser.add_argument(
        "--motion",
        default="auto",
        choices=tuple(_MOTION),
        help="use of the rig's own motion between pairs for depth: auto, where times are known and at most half a "
        "second apart; on, the pairs are consecutive, whatever their times; off (default: %(default)s)",
    )


def motion_of(options: argparse.Namespace) -> bool | None:
    """As `sr.recalibrate` has it."""
    return _MOTION[options.motion]
