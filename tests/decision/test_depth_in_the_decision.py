"""When the decision keeps depth, and what asks for another: rows, motion, ranges."""

from dataclasses import fields

import numpy as np
import pytest

from stereorecal.decision import LIMITS, Verdict, decide
from stereorecal.estimation import (
    NO_RANGES,
    Estimate,
    MatchedRanges,
    Posterior,
    Windows,
    points_of_view,
    readings,
)
from stereorecal.objectives import BASELINE
from stereorecal.scoring import Tracks

AXES = ("pitch", "yaw", "roll", "y", "z")


def test_depth_is_kept_where_rows_do_not_tell_it(looks, rig):
    """The candidate that keeps it reads what the calibration reads, within a tenth of a percent."""
    kept = [(seen, decide(seen, AXES)) for _, seen in (looks(seed, 0.1) for seed in range(8))]
    kept = [(seen, said) for seen, said in kept if said.keeps_depth]
    assert kept
    for seen, said in kept:
        used = seen.chart.rig_at(said.theta)
        assert abs(readings(used, rig, points_of_view(rig, 30))[1].mean()) < 1e-3


def test_what_depth_reads_changes_only_where_that_is_worth_it(drifted):
    """It is the better one in 95 % of the rigs for which it matters by a point, or keeping it costs rows."""
    changed = 0
    for _, seen in drifted:
        said, kept = decide(seen, AXES), seen.with_free(AXES, keep_depth=True)
        if said.keeps_depth:
            np.testing.assert_array_equal(said.theta, kept)
            continue
        (rows, depth), (rows_kept, depth_kept) = seen.losses(said.theta), seen.losses(kept)
        gains, costs = depth_kept - depth, np.median(rows_kept.mean(axis=0)) - np.median(rows.mean(axis=0))
        changed += 1
        better, worse = np.count_nonzero(gains > 1.0), np.count_nonzero(gains < -1.0)
        assert (better and better >= 0.95 * (better + worse)) or costs > LIMITS["gain_px"]
    assert changed


@pytest.mark.parametrize(("shown", "after", "verdict"), [(True, 0.2, "MOTION"), (False, 0.2, None), (True, 4.5, None)])
def test_motion_is_a_reason_where_rows_are_none(drifted, shown, after, verdict):
    """Rows are good and stay so; depth is off by five percent, and motion tells it."""
    _, seen = drifted[0]

    class Moving(type(seen)):
        def losses(self, used):
            return np.full((3, 1000), 0.1), np.full(1000, after if np.any(used) else 5.0)

        def rows_of_frames(self, used):
            return np.full(1, 0.1)

    windows = Windows((Tracks(np.zeros((2, 1, 2)), np.zeros((2, 1, 2))),)) if shown else seen.windows
    said = decide(Moving(**{**seen.__getstate__(), "windows": windows}), AXES)
    assert said.refused is (verdict is None)
    assert said.by_motion is (verdict == "MOTION")
    assert not said.by_ranges


@pytest.mark.parametrize(("shown", "verdict"), [(True, Verdict.CANNOT_TELL), (False, Verdict.GOOD)])
def test_a_depth_that_motion_contradicts_is_not_good(drifted, shown, verdict):
    """Though no extrinsics read it better without costing rows."""
    _, seen = drifted[0]

    class Torn(type(seen)):
        def losses(self, used):
            moved = np.any(used) and not np.allclose(used, self.with_free(AXES, keep_depth=True))
            return np.full((3, 1000), 0.2 if moved else 0.1), np.full(1000, 0.2 if moved else 5.0)

        def rows_of_frames(self, used):
            return np.full(1, 0.1)

    windows = Windows((Tracks(np.zeros((2, 1, 2)), np.zeros((2, 1, 2))),)) if shown else seen.windows
    assert decide(Torn(**{**seen.__getstate__(), "windows": windows}), AXES).verdict is verdict


def known_length(chart, percent: float, deviation: float, matched_ranges: MatchedRanges = NO_RANGES) -> Estimate:
    """Of a rig whose baseline is so much longer, and all else as it was calibrated."""
    length = np.eye(chart.dim)[chart.names.index("baseline")]
    covariance = np.diag(1e-12 + (deviation * length) ** 2)
    posterior = Posterior(np.ones(1), percent * length[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 100, 0.0, np.diag(covariance), matched_ranges=matched_ranges)


def ranges_of(true) -> MatchedRanges:
    points = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 4], (40, 3))
    pixels = true.left.project(points), true.right.project(points @ true.rotation.T + true.translation)
    metres = np.linalg.norm(points, axis=1)
    return MatchedRanges(*pixels, metres, 0.01 * metres, np.full(40, 0.1))


def test_ranges_are_a_reason_where_rows_are_none(chart):
    """Rows do not see the length of the baseline."""
    true, free = chart.rig_at(known_length(chart, 3.0, 0.1).theta), (*AXES, "baseline")
    alone, told = (
        decide(known_length(chart, 3.0, 0.1, matched_ranges), free) for matched_ranges in (NO_RANGES, ranges_of(true))
    )
    assert alone.verdict is Verdict.GOOD
    assert (told.verdict, told.by_ranges) == (Verdict.REPAIR, True)
    assert abs(chart.rig_at(told.theta).baseline / true.baseline - 1) < 1e-3
    unsure = decide(known_length(chart, 3.0, 3.0, ranges_of(true)), free)  # as likely worse by a percent as not
    assert unsure.verdict is Verdict.GOOD
    right = decide(known_length(chart, 0.0, 0.1, ranges_of(chart.rig)), free)
    assert right.verdict is Verdict.GOOD


def test_ranges_are_heard_although_depth_could_be_kept(chart):
    """The baseline is 0.8 % longer, pitch has drifted: the candidate that keeps depth agrees with no range."""
    names, n = list(chart.names), chart.dim
    free = (*AXES, BASELINE)
    sigma = np.where([name in free for name in names], 1e-3, 0.0)
    mean = np.zeros(n)
    mean[names.index("pitch")], mean[names.index(BASELINE)] = 0.1, 0.8
    posterior = Posterior(np.ones(1), mean[None], np.diag(sigma**2)[None])
    true = chart.rig_at(mean)
    points = points_of_view(true, 20)
    pixels = [
        np.asarray(true.left.project(points)),
        np.asarray(true.right.project(points @ true.rotation.T + true.translation)),
    ]
    metres = np.linalg.norm(points, axis=1)
    matched_ranges = MatchedRanges(*pixels, metres, 0.002 * metres, np.full(len(metres), 0.02))
    seen = Estimate(chart, posterior, (0.05, 0.0), 0, float("nan"), sigma**2, matched_ranges=matched_ranges)

    class Aligned(Estimate):
        def rows_of_frames(self, used):
            return np.full(1, 0.1 if np.any(used) else 1.0)

    said = decide(Aligned(**{field.name: getattr(seen, field.name) for field in fields(seen)}), free)
    assert said.verdict is Verdict.REPAIR
    assert said.ranges_agree
    assert said.theta[names.index(BASELINE)] == pytest.approx(0.8, abs=0.2)


def test_depth_of_a_point_costs_as_rows_that_a_matcher_notices(drifted):
    """Of two candidates with equal rows, the one that reads depth worse loses more."""
    _, seen = drifted[0]

    def loss(rows: float, depth: float) -> float:
        class Fixed(type(seen)):
            def losses(self, used):
                return np.full((3, 1000), rows), np.full(1000, depth)

        return decide(Fixed(**seen.__getstate__()), AXES).loss

    deeper, apart = loss(0.1, 1.0 + LIMITS["worse_depth_points"]), loss(0.1 + LIMITS["gain_px"], 1.0)
    assert deeper == pytest.approx(apart)
    assert deeper > loss(0.1, 1.0) + 0.5


@pytest.mark.parametrize(("share", "changed"), [(0.97, True), (0.9, False)])
def test_depth_changes_if_that_is_surely_for_the_better(drifted, share, changed):
    """Less is lost on average in both cases; in one of ten rigs, depth would be worse by two points."""
    _, seen = drifted[0]
    kept = seen.with_free(AXES, keep_depth=True)
    better = np.arange(1000) < 1000 * share

    class Gaining(type(seen)):
        def losses(self, used):
            depth = np.full(1000, 10.0) if not np.any(used) else np.where(better, 3.0, 7.0)
            if np.allclose(used, kept):
                depth = np.full(1000, 5.0)
            return np.full((3, 1000), 0.1 if np.any(used) else 1.0), depth

    assert decide(Gaining(**seen.__getstate__()), AXES).keeps_depth is not changed


@pytest.mark.parametrize(("costs", "repaired"), [(0.0, True), (2.0 * LIMITS["worse_rows_px"], False)])
def test_motion_is_no_reason_against_what_frames_show(drifted, costs, repaired):
    """Depth would be better for sure; most frames show that rows would be worse."""
    _, seen = drifted[0]

    class Moving(type(seen)):
        def losses(self, used):
            return np.full((3, 1000), 0.1), np.full(1000, 0.2 if np.any(used) else 5.0)

        def rows_of_frames(self, used):
            return np.full(3, 0.1 + costs * bool(np.any(used)))

    windows = Windows((Tracks(np.zeros((2, 1, 2)), np.zeros((2, 1, 2))),))
    said = decide(Moving(**{**seen.__getstate__(), "windows": windows}), AXES)
    assert said.refused is not repaired


def test_the_harmless_of_two_changes_is_the_candidate(drifted, chart):
    """All free parameters together would gain rows and may cost depth; the length of the baseline alone costs none."""
    _, seen = drifted[0]
    free = (*AXES, BASELINE)
    length, kept = chart.names.index(BASELINE), seen.with_free(free, keep_depth=True)

    class Harmful(type(seen)):
        def losses(self, used):
            rows, depth = 0.1, 1.0
            if np.delete(used, length).any():
                rows, depth = (0.5, 1.0) if np.allclose(used, kept) else (0.01, 2.5)
            return np.full((3, 1000), rows), np.full(1000, depth)

    said = decide(Harmful(**{**seen.__getstate__(), "matched_ranges": ranges_of(chart.rig)}), free)
    assert said.refused
    assert said.worse == 0.0
    assert not np.delete(said.theta, length).any()
