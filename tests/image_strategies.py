"""Strategies that look at images and never ask the score: a rig to find, and what they are held to beside the rest."""

from collections.abc import Iterable
from typing import ClassVar

import numpy as np
import pytest

from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameters, Reach, StereoImages, count_chart
from stereorecal.recordings import Pair, Scene
from stereorecal.strategies import AbstractStrategy, Budget, Objective, Outcome, Problem, Status
from stereorecal.synthetic import default_rig

SIZE = (480, 360)
RIG = default_rig().resized(SIZE)
_SLOPE = np.linspace(0, 255, SIZE[0], dtype=np.float32) * np.ones((SIZE[1], 1), np.float32)


@pytest.fixture(scope="session")
def coast(scene) -> Scene:
    """Two frames that the rig sees."""
    return scene("coast", 1, SIZE, 2)


def images_around(
    rig: StereoRig, pairs: Iterable[Pair] = (), reach: Reach | None = None, free: tuple[str, ...] = ("extrinsics",)
) -> StereoImages:
    return StereoImages(rig, tuple(pairs), count_chart(rig, reach or Reach(), Parameters(free)))


def repair(
    strategy: AbstractStrategy,
    images: StereoImages,
    *,
    start: np.ndarray | None = None,
    budget: Budget | None = None,
    seed: int = 0,
) -> tuple[Outcome, np.ndarray]:
    """Its outcome, and how far its rig is from the true one: degrees, and percent of the baseline."""

    def values(points: np.ndarray) -> np.ndarray:
        raise AssertionError("it asked the score")

    objective = Objective(Problem(images.chart.dim, values, images=images)).with_budget(budget)
    outcome = strategy.run(objective, np.zeros(images.chart.dim) if start is None else start, seed)
    assert objective.spent == 0
    error = np.asarray(images.chart.extrinsics(outcome.best)) - RIG.extrinsics
    return outcome, np.abs([*np.degrees(error[:3]), *100 * error[3:] / RIG.baseline])


class OfImages:
    """What is asked of them beside `StrategyConformance`; `lacks` is what they say without texture."""

    strategy: ClassVar[AbstractStrategy]
    lacks = "matches"

    def test_stalls_without_texture(self):
        start = np.full(5, 0.5)
        outcome, _ = repair(self.strategy, images_around(RIG, [Pair(_SLOPE, _SLOPE)]), start=start)
        assert outcome.status is Status.STALLED
        assert self.lacks in outcome.message
        np.testing.assert_array_equal(outcome.best, start)

    def test_keeps_a_limit_in_seconds(self, coast):
        outcome, _ = repair(self.strategy, images_around(RIG, coast.pairs), budget=Budget(seconds=1e-9))
        assert outcome.status is Status.BUDGET
