"""A short drive with a knock, for the tests of what runs on the vehicle."""

from dataclasses import dataclass

import numpy as np

from stereorecal.geometry import StereoRig
from stereorecal.online import State, Stepped
from stereorecal.recordings import Pair

BEFORE, AFTER = 6, 12


@dataclass(frozen=True)
class Ride:
    """A rig, and pairs that show a knock of 0.5 degrees of pitch at number BEFORE."""

    rig: StereoRig
    knocked: StereoRig
    pairs: list[Pair]


def kinds(steps: list[Stepped]) -> list[str]:
    """The names of what happened, in order."""
    return [event.kind.name for stepped in steps for event in stepped.events]


def error(state: State, truth: StereoRig) -> np.ndarray:
    """Of the rig in use: pitch, yaw, roll [deg]."""
    return np.abs(state.using - state.offset_of(truth))[:3]
