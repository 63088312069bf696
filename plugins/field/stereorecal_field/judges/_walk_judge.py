"""A rendered drive as judge, on which every angle walks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import ClassVar

import numpy as np

from stereorecal import InputError
from stereorecal.estimation import EXACT
from stereorecal.geometry import Camera, StereoRig, view
from stereorecal.synthetic import Drive, photographs, plan_drive
from stereorecal_field.judges._case import AbstractRecipe, Case
from stereorecal_field.judges._draws import Draws
from stereorecal_field.judges._true_rig import ByTrueRig

SIZE, FIELD, BASELINE, STEP = (1024, 512), 70.0, 1.0, 0.01  # of the walk: degrees, metres, degrees a pair
_STREAM = 61  # of random numbers


@dataclass(frozen=True)
class Walk(AbstractRecipe):
    """The protocol of TESO (CVPR 2026) on a rendered drive: every angle of the right camera moves by up to 0.01 degrees
    from one pair to the next. Methods see one pair of it, and begin with the calibration of the first; intrinsics are
    exact.

    Attributes:
        tour: of the drive.
        length: pairs of the walk.
        moment: the pair that is seen.
    """

    judge: ClassVar[str] = "walk"
    judged_by: ClassVar[str] = (
        "one pair of a drive on which every angle walks by up to 0.01° a pair (TESO's protocol), from the first pair's "
        "calibration; by the true rig"
    )

    tour: str
    length: int
    moment: int

    def make(self) -> Case:
        drive = walked(self.tour, self.seed, self.length)
        (pair,) = islice(photographs(drive, self.moment), 1)
        return Case(drive.rig, (pair,), EXACT, ByTrueRig(drive.truth(self.moment), view(drive.rig)))


def walked(tour: str, seed: int, frames: int) -> Drive:
    """A drive of such a rig, in clear weather, without things that move."""
    focal = 0.5 * SIZE[0] / np.tan(np.radians(0.5 * FIELD))
    middle = 0.5 * (np.array(SIZE) - 1.0)
    camera = Camera(SIZE, np.array([[focal, 0.0, middle[0]], [0.0, focal, middle[1]], [0.0, 0.0, 1.0]]))
    rig = StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -BASELINE, 0.0, 0.0]))
    steps = np.zeros((frames, 6))
    steps[1:, :3] = np.radians(np.random.default_rng([seed, _STREAM]).uniform(-STEP, STEP, (frames - 1, 3)))
    plan = plan_drive(tour, seed, frames, weather=False, moving=False)
    return replace(plan, rig=rig, extrinsics=np.asarray(rig.extrinsics) + np.cumsum(steps, axis=0))


def walk_recipes(place: str, draws: Draws) -> tuple[Walk, ...]:
    """The recipes of pairs of one walk."""
    if place:
        raise InputError("judge walk is rendered and takes no folder; leave it out.")
    moments = _moments(draws.walk, draws.number)
    return tuple(Walk("street", moment, draws.seed, 0.0, 0.0, "street", draws.walk, moment) for moment in moments)


def _moments(length: int, number: int) -> Sequence[int]:
    """Evenly spread, the last pair among them."""
    return sorted({round((index + 1) * (length - 1) / number) for index in range(number)})
