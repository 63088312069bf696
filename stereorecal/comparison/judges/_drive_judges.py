"""Judges that are rendered drives: a rig that moves, and one whose angles walk."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import ClassVar

import numpy as np

from stereorecal.comparison.judges._case import AbstractRecipe, Case, prior_of
from stereorecal.comparison.judges._true_rig import ByTrueRig
from stereorecal.geometry import Camera, StereoRig, view
from stereorecal.recordings import Pair
from stereorecal.synthetic import Drive, photographs, plan_drive

SIZE, FIELD, BASELINE, STEP = (1024, 512), 70.0, 1.0, 0.01  # of the walk: degrees, metres, degrees a pair
_EVERY = {"street": 3, "harbour": 6}  # frames from one pair to the next: about a baseline
_SECONDS = 0.1  # from one pair to the next
_STREAM = 61  # of random numbers


@dataclass(frozen=True)
class Ride(AbstractRecipe):
    """Consecutive pairs of a rig that moves and has drifted. Methods are told that intrinsics are as a calibration
    leaves them, so that depth is not known before.

    Attributes:
        tour: of the drive; the draw is its seed, too.
        frames: how many pairs, about a baseline apart.
    """

    judge: ClassVar[str] = "motion"

    tour: str
    frames: int

    def make(self) -> Case:
        every, seed = _EVERY[self.tour], self.seed + (self.draw or 0)
        number = (self.frames - 1) * every + 1
        plan = plan_drive(self.tour, seed, number, weather=False)
        pairs = tuple(_timed(islice(photographs(plan), 0, None, every)))
        truth = plan.truth(number // 2)
        start = self.drifted(truth)
        return Case(start, pairs, prior_of(exact=False), ByTrueRig(truth, view(start)))


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

    tour: str
    length: int
    moment: int

    def make(self) -> Case:
        drive = walked(self.tour, self.seed, self.length)
        (pair,) = islice(photographs(drive, self.moment), 1)
        return Case(drive.rig, (pair,), prior_of(exact=True), ByTrueRig(drive.truth(self.moment), view(drive.rig)))


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


def _timed(pairs: Iterator[Pair]) -> Iterator[Pair]:
    for number, pair in enumerate(pairs):
        yield replace(pair, time=number * _SECONDS)
