"""What a repair says that it cost is what the matcher was asked to do."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from parts_of_estimates import _survey

import stereorecal as sr

SIZE = (320, 240)
AREAS: list[int] = []


@dataclass(frozen=True)
class Counting(sr.BM):
    """OpenCV's block matcher; every run leaves the area of its images."""

    def search(self, left, right):
        AREAS.append(left.shape[0] * left.shape[1])
        return super().search(left, right)


@pytest.fixture
def runs():
    """The matcher's runs in a test, in units: weighted by image area."""
    AREAS.clear()
    return lambda: sum(AREAS) / (SIZE[0] * SIZE[1])


@pytest.fixture
def looks(monkeypatch):
    """Looks of surveys, each at one frame at the survey's own scale."""
    seen = []

    def metered(function):
        def counted(data, candidates, matcher):
            seen.append(np.atleast_2d(candidates).shape[0] * data.cost)
            return function(data, candidates, matcher)

        return counted

    for name in ("counts", "disparities"):
        monkeypatch.setattr(_survey, name, metered(getattr(_survey, name)))
    return lambda: sum(seen)


def repaired(scene, frames=1, **options):
    given = scene("street", 0, SIZE, frames)
    drift = np.array([*np.radians([0.9, 0.4, -0.8]), 0.0, 0.002, -0.002])
    bad = given.rig.with_extrinsics(given.rig.extrinsics + drift)
    return sr.recalibrate(bad, given.pairs, **options)


@pytest.mark.slow
@pytest.mark.parametrize(("schedule", "frames"), [("default", 2), ("count", 1), ("count", 2)])
def test_every_run_of_the_matcher_is_metered(scene, runs, looks, monkeypatch, schedule, frames):
    """Of a search, too: one look settles this drift by default."""
    monkeypatch.setattr("stereorecal.recalibration._recalibrate.assessed", lambda *given, **_: (None, given[2]))
    cost = repaired(scene, frames, matcher=Counting(), schedule=schedule).cost
    assert cost.total - cost.survey == pytest.approx(runs(), rel=0.01)
    assert cost.survey == pytest.approx(looks(), rel=1e-9)
    assert cost.survey > 0
    assert cost.search > 0
    assert cost.judging >= 2 * frames
    assert (cost.correspondences > 0) == (schedule == "default")
    assert cost.total == pytest.approx(
        cost.survey + cost.starts + cost.search + cost.correspondences + cost.judging, rel=1e-12
    )


def test_a_budget_pays_for_the_search_alone(scene, runs):
    """And what it leaves undone costs nothing: neither later stages, nor a count that judges their nominations."""
    cost = repaired(scene, matcher=Counting(num_disparities=64), budget=4.0).cost
    assert cost.budgeted <= 4.0
    assert cost.total - cost.survey == pytest.approx(runs(), rel=0.01)


def test_nominations_that_were_not_evaluated_are_judged_and_metered(scene, runs):
    """A strategy that works on the images evaluates nothing: its start and its end are counted for it."""
    schedule = sr.Schedule.count(replace(sr.strategy("features"), min_matches=8))
    solution = repaired(scene, matcher=Counting(num_disparities=64), schedule=schedule)
    assert solution.cost.search == 0
    assert solution.cost.judging == pytest.approx(runs())
    assert 3 <= runs() <= 4  # start, end (unless they are one), and both again at full scale
