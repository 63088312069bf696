"""A short drive with a knock, for the tests of what runs on the vehicle."""

from dataclasses import dataclass
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike
from parts_of_estimates import FilterEstimate

from stereorecal.geometry import StereoRig
from stereorecal.online import State, Stepped
from stereorecal.recordings import Pair
from stereorecal.synthetic import Knock, photographs, plan_drive

BEFORE, AFTER = 6, 12


@dataclass(frozen=True)
class Ride:
    """A rig, and pairs that show a knock at number BEFORE."""

    rig: StereoRig
    knocked: StereoRig
    pairs: list[Pair]


def ride_of(degrees: float, after: int) -> Ride:
    """One through a harbour, with a knock of so many degrees of pitch and so many pairs after it."""
    knocks = (Knock(BEFORE, (degrees, 0.0, 0.0)),)
    drive = plan_drive("harbour", 2, BEFORE + after, knocks=knocks, weather=False)
    with TemporaryDirectory() as folder:
        return Ride(drive.rig, drive.truth(len(drive) - 1), list(photographs(drive, folder=folder)))


def kinds(steps: list[Stepped]) -> list[str]:
    """The names of what happened, in order."""
    return [event.kind.name for stepped in steps for event in stepped.events]


def error(state: State, truth: StereoRig) -> np.ndarray:
    """The error of the rig in use: pitch, yaw, roll [deg]."""
    return np.abs(state.using - state.offset_of(truth))[:3]


def keystone(state: State) -> np.ndarray:
    """Changes of θ that bend rows and leave depth: a degree of yaw, and the principal point that undoes it there."""
    chart, found = state.chart, np.zeros(len(state.theta))
    found[[1, chart.names.index("right.cx")]] = 1.0, -np.radians(1.0) * float(state.initial.right.focal[0])
    return found


def standing_at(state: State, offset: ArrayLike, covariance: np.ndarray) -> FilterEstimate:
    """The state's estimate, if the true rig stood at an offset, as well known as that, and lenses were as given."""
    lenses = len(state.theta) - 5
    return state.estimate.moved(np.pad(np.asarray(offset, float), (0, lenses)), np.pad(covariance, (0, lenses)))
