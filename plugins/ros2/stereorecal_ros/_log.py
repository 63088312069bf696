"""Lines for the log."""

import enum
from collections.abc import Callable

import numpy as np

from stereorecal import StereoRig


class Level(enum.IntEnum):
    """As in `diagnostic_msgs/DiagnosticStatus`."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


Line = tuple[Level, str]
Tell = Callable[[Level, str], None]


def numbers(rig: StereoRig) -> str:
    """The extrinsics of a calibration."""
    pitch, yaw, roll = np.degrees(rig.extrinsics[:3])
    x, y, z = 1e3 * np.asarray(rig.extrinsics[3:])
    return f"pitch {pitch:+.4f} yaw {yaw:+.4f} roll {roll:+.4f} deg, x {x:+.3f} y {y:+.3f} z {z:+.3f} mm"
