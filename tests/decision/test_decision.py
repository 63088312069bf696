"""The decision: what it may change, when it changes nothing, and that it is true to rigs that are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.decision import LIMITS, Verdict, decide, decide_for_trial, decide_together, fewer_parameters_suffice
from stereorecal.estimation import (
    Earlier,
    SavedPrior,
    estimate,
    points_of_view,
    readings,
    recentred_posterior,
)

AXES = ("pitch", "yaw", "roll", "y", "z")
AWAY = (5, 10, 30)


def of_truth(used, true) -> tuple[np.ndarray, float]:
    """Rows [px] at the distances that are judged, and |error of depth| at 30 baselines [%]."""
    read = [readings(used, true, points_of_view(true, distance)) for distance in AWAY]
    rows = np.array([np.sqrt(np.mean(rows**2)) for rows, _ in read])
    return rows, 100.0 * abs(1.0 / (1.0 + read[-1][1].mean()) - 1.0)


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
        known = SavedPrior(
            new, recentred_posterior(first.posterior, first.chart.coordinates_of(new)), (), Earlier(rig, "default")
        )
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


BLIND = 2.0 * LIMITS["blind_rows_px"]


@pytest.mark.parametrize(("rows", "left", "repaired"), [(BLIND, 0.1, True), (0.5, 0.1, False), (BLIND, 0.6, False)])
def test_a_blind_rig_has_no_depth_to_lose_to_one_that_explains_the_rows(drifted, rows, left, repaired):
    """In one draw of twenty, depth is worse by two points: too often for a rig that sees, and for one that leaves rows
    misaligned."""
    _, seen = drifted[0]

    class Doubtful(type(seen)):
        def losses(self, used):
            given = not np.any(used)
            depth = np.zeros(1000) if given else np.where(np.arange(1000) < 50, 2.0, 0.0)
            return np.full((3, 1000), rows if given else left), depth

    said = decide(Doubtful(**seen.__getstate__()), AXES)
    assert said.worse == pytest.approx(0.05)
    assert (said.verdict is Verdict.REPAIR) is repaired


@pytest.mark.parametrize(("before", "after", "repaired"), [(0.7, 0.25, True), (0.7, 0.5, False), (1.4, 0.6, True)])
def test_a_repair_explains_the_rows_or_corrects_more_than_it_leaves(drifted, before, after, repaired):
    """Where intrinsics are wrong, extrinsics gain over the view what single places lose."""
    _, seen = drifted[0]

    class Leaving(type(seen)):
        def losses(self, used):
            return np.full((3, 1000), after if np.any(used) else before), np.full(1000, 1.0)

    said = decide(Leaving(**seen.__getstate__()), AXES)
    assert (said.verdict is Verdict.REPAIR) is repaired
    assert said.explains is (after <= LIMITS["good_rows_px"])
    assert (said.explains or said.corrects_most) is repaired


@pytest.mark.parametrize(("intrinsics_leave", "repaired"), [(0.1, True), (0.5, False)])
def test_what_a_repair_leaves_may_be_explained_by_intrinsics(drifted, intrinsics_leave, repaired):
    _, seen = drifted[0]

    class Leaving(type(seen)):
        def losses(self, used):
            rows = 0.7 if not np.any(used) else intrinsics_leave if np.array_equal(used, seen.theta) else 0.5
            return np.full((3, 1000), rows), np.full(1000, 1.0)

    found = decide(Leaving(**seen.__getstate__()), AXES, intrinsics_explain=True)
    assert not found.explains
    assert not found.corrects_most
    assert (found.verdict is Verdict.REPAIR) is found.left_to_intrinsics is found.is_understood is repaired
    assert decide(Leaving(**seen.__getstate__()), AXES).refused, "of intrinsics that something may refute"


def test_a_blind_rig_has_no_depth_to_lose_either_where_intrinsics_explain_the_rows(drifted):
    _, seen = drifted[0]

    class Doubtful(type(seen)):
        def losses(self, used):
            rows = BLIND if not np.any(used) else 0.1 if np.array_equal(used, seen.theta) else 0.6
            depth = np.where(np.arange(1000) < 50, 2.0, 0.0) if np.any(used) else np.zeros(1000)
            return np.full((3, 1000), rows), depth

    blind = Doubtful(**seen.__getstate__())
    assert decide(blind, AXES, intrinsics_explain=True).verdict is Verdict.REPAIR
    assert decide(blind, AXES).refused


@pytest.mark.parametrize("what", ["rows", "depth"])
def test_what_is_no_number_is_not_harmless(drifted, what):
    _, seen = drifted[0]

    class Unknown(type(seen)):
        def losses(self, used):
            rows, depth = np.full((3, 1000), 0.1 if np.any(used) else 1.0), np.full(1000, 1.0)
            if np.any(used):
                {"rows": rows[2], "depth": depth}[what][:20] = np.nan
            return rows, depth

    said = decide(Unknown(**seen.__getstate__()), AXES)
    assert said.worse == pytest.approx(0.02)
    assert said.verdict is not Verdict.REPAIR


def test_several_share_what_is_no_drift(drifted, chart):
    """And each of them alone is decided as by itself."""
    some, free = [seen for _, seen in drifted[:3]], (*AXES, "left.f", "right.cx")
    found = decide_together(some, free)
    shared = np.array(["." in name for name in chart.names])
    for seen, said in zip(some, found, strict=True):
        np.testing.assert_allclose(said.theta[shared], found[0].theta[shared])
        assert said.keeps_depth == found[0].keeps_depth
        (alone,), same = decide_together([seen], free), decide(seen, free)
        np.testing.assert_array_equal(alone.theta, same.theta)
        assert said.loss > alone.loss - 0.5  # what is shared suits none better than its own


def test_fewer_parameters_that_do_as_well(drifted):
    one = decide(drifted[0][1], AXES)
    assert fewer_parameters_suffice([one], [one])
    assert not fewer_parameters_suffice([replace(one, loss=one.loss + 1.5)], [one])
    rows = one.rows_px + np.array([[0.0], [0.1]])
    assert not fewer_parameters_suffice([replace(one, rows_px=rows)], [one])  # whatever depth makes of the loss
    stays = replace(one, verdict=Verdict.GOOD)
    assert not fewer_parameters_suffice([stays], [one])
    assert fewer_parameters_suffice([one], [stays])


def test_rows_are_said_with_the_interval_that_holds_them(drifted):
    for _, seen in drifted:
        said = decide(seen, AXES)
        assert (said.rows_px[:, 1] < said.rows_px[:, 0]).all()
        assert (said.rows_px[:, 0] < said.rows_px[:, 2]).all()
        for one, (value, low, high) in zip(said.as_dict()["rows_px"].values(), said.rows_px.tolist(), strict=True):
            np.testing.assert_allclose([one["value"], one["low"], one["high"]], [value, low, high], atol=1e-3)


def test_what_blinds_in_one_draw_of_twenty_has_depth_to_lose(drifted):
    """Rows blind the matcher with 5 %, and depth becomes worse with 5 %."""
    _, seen = drifted[0]

    class Doubtful(type(seen)):
        def losses(self, used):
            few = np.arange(1000) < 50
            if np.any(used):
                return np.full((3, 1000), 0.1), np.where(few, 2.0, 0.0)
            return np.tile(np.where(few, BLIND, 0.5), (3, 1)), np.zeros(1000)

    said = decide(Doubtful(**seen.__getstate__()), AXES)
    assert said.worse == pytest.approx(0.05)
    assert said.verdict is not Verdict.REPAIR


def test_a_trial_of_a_blind_rig_asks_for_rows_alone(drifted):
    """A change that is better on average, and worse in depth as often as not, of a rig that has no depth to lose."""
    _, seen = drifted[0]

    class Blind(type(seen)):
        def losses(self, used):
            blind = np.full(1000, BLIND)
            if not np.any(used):
                return np.tile(blind, (3, 1)), np.zeros(1000)
            rows = np.where(np.arange(1000) < 100, blind, 0.1)  # no better in one draw of ten
            return np.tile(rows, (3, 1)), np.where(np.arange(1000) < 500, 2.0, 0.0)

    decision, change = decide_for_trial(Blind(**seen.__getstate__()), AXES, harm=0.05)
    assert decision.refused
    assert decision.worse == pytest.approx(0.5)
    assert change is not None
