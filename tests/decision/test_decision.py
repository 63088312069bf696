"""The decision: what it may change, when it changes nothing, and that it is true to rigs that are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import COSTS
from simulated_tracks import AHEAD, REST, tracks_of

from stereorecal.decision import LIMITS, Criterion, Tolerances, Verdict, decide, decide_together
from stereorecal.estimation import (
    NO_RANGES,
    Estimate,
    HeldOut,
    Losses,
    MatchedRanges,
    Mixture,
    SavedPrior,
    Windows,
    estimate,
    points_of_view,
    readings,
    recentred_posterior,
)
from stereorecal.objectives import BASELINE, EXTRINSICS as AXES

AWAY = (5, 10, 30)


def of_truth(used, true) -> tuple[float, float]:
    """Mean |epipolar error| [px] at the distances that are judged, and mean |error of depth| at 30 baselines [%]."""
    read = [readings(used, true, points_of_view(true, distance)) for distance in AWAY]
    return float(np.mean([np.abs(rows).mean() for rows, _ in read])), 100.0 * float(np.abs(read[-1][1]).mean())


def everything(seen: Estimate) -> list[str]:
    """But what nothing observes."""
    return [name for name in seen.names if name != BASELINE]


# --- rigs that are known --------------------------------------------------------------------------------------


@pytest.mark.parametrize("free", [lambda _: AXES, everything], ids=["extrinsics", "everything"])
def test_what_drifted_is_repaired_and_is_not_worse(drifted, rig, free):
    for true, seen in drifted:
        said = decide(seen, free(seen))
        assert said.verdict is Verdict.REPAIR
        (rows, depth), (before, depth_before) = of_truth(seen.chart.rig_at(said.theta), true), of_truth(rig, true)
        assert rows < 0.5 * before
        assert depth < depth_before + LIMITS["depth_points"]


def test_what_did_not_drift_stays_or_gets_better(looks, rig):
    for seed in range(5):
        true, seen = looks(100 + seed, 0.0)
        said = decide(seen, AXES)
        assert said.verdict is not Verdict.CANNOT_TELL
        assert said.refused or of_truth(seen.chart.rig_at(said.theta), true)[0] < of_truth(rig, true)[0]


def test_other_images_of_what_was_repaired_ask_for_no_repair(drifted, rig, seen):
    for true, first in drifted[:3]:
        new = first.chart.rig_at(decide(first, AXES).theta)
        posterior = recentred_posterior(first.posterior, first.chart.coordinates_of(new))
        for prior in (SavedPrior(new, posterior, (), SavedPrior(rig, "default")), None):
            assert decide(estimate(seen(new, true, 77, cells=900), new, prior), AXES).refused


def test_where_nothing_is_seen_nothing_is_repaired(rig, seen):
    blind = replace(seen(rig, rig, cells=900), weight=np.zeros((1, 900), np.float32))
    assert decide(estimate(blind, rig), AXES).refused


def test_images_must_bear_it_out(drifted):
    """What the posterior is sure of, rows that are there may contradict: a lens that no model has."""
    _, seen = drifted[0]
    groups = seen.shown
    as_given = groups.differences(seen.chart, np.zeros(len(seen.theta)))
    aligned = replace(seen, shown=replace(groups, offset=groups.offset - as_given))  # as if they met as calibrated
    assert decide(aligned, AXES).failed is Criterion.PREDICTS


@settings(max_examples=5)
@given(seed=st.integers(0, 4), free=st.sets(st.sampled_from([*AXES, "right.f", "right.cx", "left.k1"]), min_size=1))
def test_only_what_is_free_changes_and_it_says_the_same_twice(drifted, seed, free):
    _, seen = drifted[seed]
    first, second = decide(seen, tuple(free)), decide(replace(seen), tuple(free))
    assert not first.theta[~np.isin(seen.names, list(free))].any()
    np.testing.assert_array_equal(first.theta, second.theta)
    assert (first.worse, first.better, first.verdict) == (second.worse, second.better, second.verdict)


def test_rows_are_said_with_the_interval_that_holds_them(drifted):
    for _, seen in drifted:
        said = decide(seen, AXES)
        for name, px in (("rows_px", said.rows_px), ("rows_of_view_px", said.view_px)):
            assert (px[:, 1] < px[:, 0]).all()
            assert (px[:, 0] < px[:, 2]).all()
            for one, (value, low, high) in zip(said.as_dict()[name].values(), px.tolist(), strict=True):
                np.testing.assert_allclose([one["value"], one["low"], one["high"]], [value, low, high], atol=1e-3)
        parts = said.as_dict()["held_out"]
        assert [part["name"] for part in parts] == [part.name for part in said.held_out]


# --- depth is corrected as far as does no harm ----------------------------------------------------------------


@settings(max_examples=6)
@given(at=st.integers(0, 4), harms=st.tuples(*[st.floats(1e-3, 0.5)] * 2), points=st.sampled_from([0.2, 1.0, 5.0]))
def test_who_tolerates_less_harm_corrects_no_more_of_depth(hardly, at, harms, points):
    _, seen = hardly[at]
    less, more = (decide(seen, AXES, Tolerances(harm=harm, depth_points=points)) for harm in sorted(harms))
    assert 0.0 <= less.depth_corrected <= more.depth_corrected <= 1.0
    for said in (less, more):
        assert said.worse <= said.tolerances.harm or said.depth_corrected == 0.0


def test_it_lies_between_the_candidate_that_keeps_depth_and_the_one_that_loses_least(hardly):
    """Or, where even the former may harm, where a change of depth costs more."""
    shares, costs = [], []
    for _, seen in hardly:
        said, least = decide(seen, AXES), seen.with_free(AXES)
        cost = 1.0
        if said.depth_corrected == 0.0 and said.failed is not Criterion.HARMLESS:
            kept = (seen.with_free(AXES, keep_depth=some) for some in (1.0, *COSTS))
            cost = next(some for some, theta in zip((1.0, *COSTS), kept, strict=True) if np.allclose(theta, said.theta))
        kept = seen.with_free(AXES, keep_depth=cost)
        np.testing.assert_allclose(said.theta, kept + said.depth_corrected * (least - kept), atol=1e-9)
        shares.append(said.depth_corrected)
        costs.append(cost)
    assert min(shares) < max(shares)
    assert min(costs) < max(costs)


# --- the three tests, one at a time ---------------------------------------------------------------------------

FEW = np.arange(1000) < 100  # as many of the draws
PART = HeldOut("columns 1 of 3", 100, 1.0, 0.2, 0.2)
GAIN = {"seen": 0.2, "even": 0.2, "farthest": 1.0, "total": 4.0}


def said_of(seen: Estimate, before=None, after=None, parts=(PART, PART), **measured):
    """The decision on a rig whose losses are given: of each draw, or the same of all."""
    of_both = {"seen": 1.0, "even": 1.0, "farthest": 1.0, "total": 20.0} | (before or {}), GAIN | (after or {})

    class Given(type(seen)):
        def losses(self, used):
            return Losses(**{name: np.full(1000, 0.0) + value for name, value in of_both[int(np.any(used))].items()})

        def expected_loss(self, used):
            return float(np.mean(self.losses(used).total))

        def held_out(self, names, share=1.0, keep_depth=1.0):
            return list(parts)

    return decide(Given(**(seen.__getstate__() | measured)), AXES)


NAN = np.where(FEW, np.nan, 0.1)
ALIGNED = HeldOut("rows 1 of 3", 100, 0.2, 0.2, 0.1)
CASES = {
    "all pass": ({}, {}, (PART, PART), None),
    "less than a unit": ({"total": 1.5}, {"total": 0.6}, (PART, PART), Criterion.GAINS),
    "too small a share": ({}, {"total": 18.0}, (PART, PART), Criterion.GAINS),
    "not sure to be better": ({}, {"total": np.where(np.arange(1000) < 300, 21.0, 1.0)}, (PART,), Criterion.GAINS),
    "rows where something is seen": ({}, {"seen": np.where(FEW, 1.2, 0.1)}, (PART,), Criterion.HARMLESS),
    "rows over the view": ({}, {"even": np.where(FEW, 1.2, 0.1)}, (PART,), Criterion.HARMLESS),
    "depth": ({}, {"farthest": np.where(FEW, 3.0, 0.1)}, (PART,), Criterion.HARMLESS),
    "seldom": ({}, {"farthest": np.where(np.arange(1000) < 3, 3.0, 0.1)}, (PART,), None),
    "rows that are no number": ({}, {"seen": NAN}, (PART,), Criterion.HARMLESS),
    "depth that is no number": ({}, {"farthest": NAN}, (PART,), Criterion.HARMLESS),
    "one part worse": ({}, {}, (PART, PART, replace(PART, count=5, before=0.5, after=0.7)), Criterion.PREDICTS),
    "one part worse, and aligned": ({}, {}, (PART, PART, replace(PART, before=0.1, after=0.2)), None),
    "parts as they were": ({}, {}, (ALIGNED, ALIGNED), Criterion.PREDICTS),
    "parts that gain little of it": ({}, {}, (replace(PART, before=2.0, after=1.5, fitted=0.2),), Criterion.PREDICTS),
    "parts that gain most of it": ({}, {}, (replace(PART, before=2.0, after=0.5, fitted=0.4),), None),
}


@pytest.mark.parametrize(("before", "after", "parts", "failed"), CASES.values(), ids=CASES)
def test_it_is_repaired_if_it_passes_each_test(drifted, before, after, parts, failed):
    _, seen = drifted[0]
    said = said_of(seen, before, after, parts)
    assert said.failed is failed
    assert said.verdict is (Verdict.REPAIR if failed is None else Verdict.CANNOT_TELL)
    assert said.refused is (failed is not None)
    good = said_of(seen, {"seen": 0.1} | before, {"seen": 0.1} | after, parts)  # the rows are aligned already
    if failed is not None and "seen" not in after:
        assert (good.verdict, good.failed) == (Verdict.GOOD, failed)


@pytest.mark.parametrize("measured", ["motion", "ranges"])
def test_parts_whose_rows_stay_aligned_do_where_something_else_tells_depth(drifted, measured):
    """And not where a rig at rest was tracked, or ranges are of something else."""
    true, seen = drifted[0]
    estimated = seen.chart.rig_at(seen.theta)
    if measured == "motion":
        told, of_nothing = ({"windows": Windows((tracks_of(true, move),))} for move in (AHEAD, REST))
    else:
        ranges = ranges_of(estimated)
        told, of_nothing = ({"matched_ranges": replace(ranges, metres=by * ranges.metres)} for by in (1.0, 3.0))
    assert said_of(seen, parts=(ALIGNED, ALIGNED), **told).verdict is Verdict.REPAIR
    assert said_of(seen, parts=(ALIGNED, ALIGNED), **of_nothing).failed is Criterion.PREDICTS
    torn = replace(ALIGNED, after=0.5)
    assert said_of(seen, parts=(ALIGNED, torn), **told).failed is Criterion.PREDICTS


# --- ranges ---------------------------------------------------------------------------------------------------


def known_length(chart, percent: float, deviation: float, matched_ranges: MatchedRanges = NO_RANGES) -> Estimate:
    """The estimate of a rig whose baseline is so much longer, and all else as it was calibrated."""
    length = np.eye(chart.dim)[chart.names.index(BASELINE)]
    covariance = np.diag(1e-12 + (deviation * length) ** 2)
    posterior = Mixture(np.ones(1), percent * length[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 100, 0.0, np.diag(covariance), matched_ranges=matched_ranges)


def ranges_of(true) -> MatchedRanges:
    points = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 4], (40, 3))
    pixels = true.left.project(points), true.right.project(points @ true.rotation.T + true.translation)
    metres = np.linalg.norm(points, axis=1)
    return MatchedRanges(*pixels, metres, 0.01 * metres, np.full(40, 0.1))


@pytest.mark.parametrize(("percent", "deviation", "repaired"), [(3.0, 0.1, True), (3.0, 3.0, False), (0.0, 0.1, False)])
def test_a_length_that_ranges_tell_is_corrected_where_it_matters(chart, percent, deviation, repaired):
    """Rows do not see it; a length that is as likely worse by a percent as not stays, and so does one that is right."""
    true = chart.rig_at(known_length(chart, percent, 0.1).theta)
    said = decide(known_length(chart, percent, deviation, ranges_of(true)), (*AXES, BASELINE))
    assert said.verdict is (Verdict.REPAIR if repaired else Verdict.GOOD)
    if repaired:
        assert abs(chart.rig_at(said.theta).baseline / true.baseline - 1) < 1e-3


# --- several together -----------------------------------------------------------------------------------------


def test_several_share_what_is_no_drift(drifted, chart):
    """And each of them alone is decided as by itself."""
    some, free = [seen for _, seen in drifted[:3]], (*AXES, "left.f", "right.cx")
    found = decide_together(some, free)
    shared = np.array(["." in name for name in chart.names])
    for seen, said in zip(some, found, strict=True):
        np.testing.assert_allclose(said.theta[shared], found[0].theta[shared], rtol=1e-9)
        assert said.depth_corrected == found[0].depth_corrected
        (alone,), same = decide_together([seen], free), decide(seen, free)
        np.testing.assert_array_equal(alone.theta, same.theta)
    assert np.ptp([said.theta[0] for said in found]) > 0.05  # each keeps its drift


def test_several_correct_no_more_of_depth_than_does_harm_to_none(hardly):
    several = [seen for _, seen in hardly[:3]]
    together = decide_together(several, AXES)
    assert together[0].depth_corrected == min(decide(seen, AXES).depth_corrected for seen in several)
