"""Rigs that have drifted, and images that show too little, or something else than a rig would."""

import numpy as np

import stereorecal as sr


def turned(rig: sr.StereoRig, pitch: float = 0.0, yaw: float = 0.0, roll: float = 0.0, y=0.0, z=0.0) -> sr.StereoRig:
    """The rig off by so many degrees, and metres."""
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians([pitch, yaw, roll]), 0.0, y, z]))


def fog(size: tuple[int, int] = (320, 240)) -> sr.Pair:
    """In which nothing is seen."""
    grey = np.full(size[::-1], 128.0, np.float32)
    grey[0, 0] = 129.0
    return sr.Pair(grey, grey[::-1].copy(), "fog")
