"""The decision: what it may change, when it changes nothing, and that it is true to rigs that are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.decision import LIMITS, Verdict, decide
from stereorecal.estimation import Earlier, SavedPrior, around, estimate, readings
from stereorecal.estimation._consequences import points_of_view

AXES = ("pitch", "yaw", "roll", "y", "z")
AWAY = (5, 10, 30)


def of_truth(used, true) -> tuple[np.ndarray, float]:
    """Rows [px] at the distances that are judged, and |error of depth| at 30 baselines [%]."""
    read = [readings(used, true, points_of_view(true, distance)) for distance in AWAY]
    rows = np.array([np.sqrt(np.mean(rows**2)) for rows, _ in read])
    return rows, 100.0 * abs(1.0 / (1.0 + read[-1][1].mean()) - 1.0)


@pytest.fixture(scope="module")
def looks(rig, chart, prior, seen):
    """looks(seed, degrees): a rig that a calibration left and that drifted, and the estimate of it."""

    def make(seed: int, degrees: float):
        rng = np.random.default_rng(seed)
        drift = np.r_[rng.uniform(-degrees, degrees, 5) * [1, 1, 1, 0.6, 0.6], np.zeros(chart.dim - 5)]
        true = chart.rig_at(prior.roots[len(prior.roots) // 2] @ rng.normal(0, 1, chart.dim) + drift)
        return true, estimate(seen(rig, true, seed, cells=900), rig)

    return make


@pytest.fixture(scope="module")
def drifted(looks):
    return [looks(seed, 0.5) for seed in range(6)]


def test_what_drifted_is_repaired_and_is_not_worse(drifted, rig):
    for true, seen in drifted:
        said = decide(seen, AXES)
        assert said.verdict is Verdict.REPAIR
        rows, depth = of_truth(seen.chart.rig_at(said.theta), true)
        before, depth_before = of_truth(rig, true)
        assert (rows < before + LIMITS["worse_rows_px"]).all()
        assert rows.mean() < before.mean() - LIMITS["gain_px"]
        assert depth < depth_before + LIMITS["worse_depth_points"]


def test_what_did_not_drift_stays_or_gets_better(looks, rig):
    for seed in range(6):
        true, seen = looks(100 + seed, 0.0)
        said = decide(seen, AXES)
        assert said.verdict is not Verdict.CANNOT_TELL
        if said.verdict is Verdict.REPAIR:
            assert of_truth(seen.chart.rig_at(said.theta), true)[0].mean() < of_truth(rig, true)[0].mean()


def test_other_images_of_what_was_repaired_ask_for_no_repair(drifted, rig, seen):
    for true, first in drifted:
        new = first.chart.rig_at(decide(first, AXES).theta)
        known = SavedPrior(new, around(first.posterior, first.chart.coordinates_of(new)), (), Earlier(rig, "default"))
        for prior in (known, None):
            assert decide(estimate(seen(new, true, 77, cells=900), new, prior), AXES).verdict is not Verdict.REPAIR


@settings(max_examples=15)
@given(seed=st.integers(0, 5), free=st.sets(st.sampled_from([*AXES, "right.f", "right.cx", "left.k1"]), min_size=1))
def test_only_what_is_free_changes(drifted, seed, free):
    _, seen = drifted[seed]
    theta = decide(seen, tuple(free)).theta
    assert not theta[~np.isin(seen.names, list(free))].any()


@settings(max_examples=10)
@given(seed=st.integers(0, 5))
def test_it_says_the_same_twice(drifted, seed):
    _, seen = drifted[seed]
    first, second = decide(seen, AXES), decide(replace(seen), AXES)
    np.testing.assert_array_equal(first.theta, second.theta)
    assert (first.worse, first.better, first.verdict) == (second.worse, second.better, second.verdict)


def test_a_repair_is_one_that_is_sure(drifted, looks):
    """Its probabilities are those that the limits ask for; and whatever is refused lacks one of them."""
    for _, seen in [*drifted, *(looks(seed, 0.0) for seed in range(100, 104))]:
        said = decide(seen, AXES)
        sure = said.worse < LIMITS["alpha"] and said.better > 1.0 - LIMITS["alpha"]
        assert sure is (said.verdict is Verdict.REPAIR)


def test_where_nothing_is_seen_nothing_is_repaired(rig, seen):
    blind = replace(seen(rig, rig, cells=900), weight=np.zeros((1, 900), np.float32))
    assert decide(estimate(blind, rig), AXES).verdict is not Verdict.REPAIR


def test_depth_is_kept_where_rows_do_not_tell_it(looks, rig):
    """The candidate that keeps it reads what the calibration reads, within a tenth of a percent."""
    kept = [(seen, decide(seen, AXES)) for _, seen in (looks(seed, 0.1) for seed in range(8))]
    kept = [(seen, said) for seen, said in kept if said.keeps_depth]
    assert kept
    for seen, said in kept:
        used = seen.chart.rig_at(said.theta)
        assert abs(readings(used, rig, points_of_view(rig, 30))[1].mean()) < 1e-3


def test_far_rows_do_not_pay_for_near_ones(drifted):
    """What is worse at one distance is worse."""
    _, seen = drifted[0]
    said = decide(seen, AXES)

    class Nearer(type(seen)):
        def losses(self, used):
            rows, depth = super().losses(used)
            return rows + np.array([0.05, -0.05, -0.05])[:, None] * bool(np.any(used)), depth

    other = Nearer(**seen.__getstate__())
    assert said.verdict is Verdict.REPAIR
    assert decide(other, AXES).worse >= said.worse
