"""The decision: what it may change, when it changes nothing, and that it is true to rigs that are known."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.decision import LIMITS, Tolerances, Verdict, decide, decide_together, fewer_parameters_suffice, judged
from stereorecal.estimation import (
    NO_BEAMS,
    Beams,
    Earlier,
    Estimate,
    Posterior,
    SavedPrior,
    Windows,
    estimate,
    points_of_view,
    readings,
    recentred_posterior,
)
from stereorecal.estimation._consequences import regions as regions_of
from stereorecal.objectives import BASELINE
from stereorecal.scoring import Tracks

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
        return true, judged(estimate(seen(rig, true, seed, cells=900), rig), Tolerances())

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


@pytest.mark.parametrize(("rows", "repaired"), [(2.0 * LIMITS["blind_rows_px"], True), (0.5, False)])
def test_a_blind_rig_has_no_depth_to_lose(drifted, rows, repaired):
    """In one draw of twenty, depth is worse by two points: too often for a rig that sees."""
    _, seen = drifted[0]

    class Doubtful(type(seen)):
        def losses(self, used):
            given = not np.any(used)
            depth = np.zeros(1000) if given else np.where(np.arange(1000) < 50, 2.0, 0.0)
            return np.full((3, 1000), rows if given else 0.1), depth

    said = decide(Doubtful(**seen.__getstate__()), AXES)
    assert said.worse == pytest.approx(0.05)
    assert (said.verdict is Verdict.REPAIR) is repaired


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


@pytest.mark.parametrize(("free", "repaired"), [(AXES, True), ((*AXES, "left.k1"), False)])
def test_other_lenses_must_not_cost_rows_anywhere(drifted, free, repaired):
    """In one of ten draws a corner is worse by what a matcher notices; of a drift alone that is no reason."""
    _, seen = drifted[0]

    class Corner(type(seen)):
        def rows_of_regions(self, used):
            rows = np.full((1000, 27), 0.1)
            rows[:100, 8] += 0.06 * bool(np.any(used))
            return rows

        def losses(self, used):
            return np.full((3, 1000), 0.1 if np.any(used) else 1.0), np.full(1000, 1.0)

    assert (decide(Corner(**seen.__getstate__()), free).verdict is Verdict.REPAIR) is repaired


@pytest.mark.parametrize(
    ("had", "share", "cost", "repaired"),
    [
        (0.6, 0.1, 0.1, True),  # hardly ever worse, and half a pixel better on average
        (0.6, 0.0, 0.0, True),
        (0.12, 0.1, 0.5, False),  # as seldom, of a region that has little to gain
        (0.05, 1.0, 1.3, False),  # what other regions gain is no excuse
    ],
)
def test_a_region_that_gains_on_average_may_be_unsure(drifted, had, share, cost, repaired):
    _, seen = drifted[0]

    class Corner(type(seen)):
        def rows_of_regions(self, used):
            rows = np.full((1000, 27), 0.1 if np.any(used) else 1.4)
            rows[:, 8] = 0.1 if np.any(used) and share < 1.0 else had
            rows[: int(1000 * share), 8] = had + cost * bool(np.any(used))
            return rows

        def losses(self, used):
            return np.full((3, 1000), 0.1 if np.any(used) else 1.4), np.full(1000, 1.0)

    said = decide(Corner(**seen.__getstate__()), (*AXES, "left.k1"))
    assert (said.verdict is Verdict.REPAIR) is repaired


def test_rows_of_regions_are_those_of_the_view(drifted):
    """The mean of their squares, by the points in each, is the view's, at each distance; and a roll moves the rows of
    the left and the right ones, hardly those of the middle."""
    _, seen = drifted[0]
    theta = decide(seen, AXES).theta
    regions, (rows, _) = seen.rows_of_regions(theta), seen.losses(theta)
    start = 0
    for distance, of_view in zip(seen.judged_at, rows, strict=True):
        points = points_of_view(seen.mean_rig, distance)
        count = np.unique(regions_of(seen.mean_rig, points), return_counts=True)[1]
        squares = regions[:, start : start + len(count)] ** 2
        np.testing.assert_allclose(np.sqrt(squares @ count / len(points)), of_view, rtol=1e-9)
        start += len(count)
    assert start == regions.shape[1]
    rolled = seen.rows_of_regions(seen.theta + 0.5 * np.eye(len(seen.names))[seen.names.index("roll")])[:, -9:]
    sides, middle = rolled[:, [0, 2, 3, 5, 6, 8]], rolled[:, [1, 4, 7]]
    assert np.median(sides) > 2.0 * np.median(middle)


def test_depth_ahead_counts_as_depth_over_the_view_does(drifted):
    """A lens that is right on average, and wrong where the rig goes."""
    _, seen = drifted[0]
    larger = []
    for name in ("left.cx", "right.cx", "left.k1", "right.k1"):
        theta = seen.theta + np.eye(len(seen.names))[seen.names.index(name)] * (0.5 if name.endswith("x") else 0.01)
        over, depth = seen._read(theta)[1][:, 2], seen.losses(theta)[1]  # at 30 baselines
        each = 100.0 * np.abs(1.0 / (1.0 + over) - 1.0)
        np.testing.assert_allclose(depth, each.max(axis=1))
        larger.append(each[:, 1] > each[:, 0])
    assert 0 < np.count_nonzero(larger) < np.size(larger)


def test_far_rows_do_not_pay_for_near_ones(drifted):
    """What is worse at one distance is worse."""
    _, seen = drifted[0]
    said = decide(seen, AXES)

    class Nearer(type(seen)):
        def losses(self, used):
            rows, depth = super().losses(used)
            return rows + np.r_[0.05, np.full(len(rows) - 1, -0.05)][:, None] * bool(np.any(used)), depth

    other = Nearer(**seen.__getstate__())
    assert said.verdict is Verdict.REPAIR
    assert decide(other, AXES).worse >= said.worse


def known_length(chart, percent: float, deviation: float, beams: Beams = NO_BEAMS) -> Estimate:
    """Of a rig whose baseline is so much longer, and all else as it was calibrated."""
    length = np.eye(chart.dim)[chart.names.index("baseline")]
    covariance = np.diag(1e-12 + (deviation * length) ** 2)
    posterior = Posterior(np.ones(1), percent * length[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 100, 0.0, np.diag(covariance), beams=beams)


def ranges_of(true) -> Beams:
    points = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 4], (40, 3))
    pixels = true.left.project(points), true.right.project(points @ true.rotation.T + true.translation)
    metres = np.linalg.norm(points, axis=1)
    return Beams(*pixels, metres, 0.01 * metres, np.full(40, 0.1))


def test_ranges_are_a_reason_where_rows_are_none(chart):
    """Rows do not see the length of the baseline."""
    true, free = chart.rig_at(known_length(chart, 3.0, 0.1).theta), (*AXES, "baseline")
    alone, told = (decide(known_length(chart, 3.0, 0.1, beams), free) for beams in (NO_BEAMS, ranges_of(true)))
    assert alone.verdict is Verdict.GOOD
    assert (told.verdict, told.by_ranges) == (Verdict.REPAIR, True)
    assert abs(chart.rig_at(told.theta).baseline / true.baseline - 1) < 1e-3
    unsure = decide(known_length(chart, 3.0, 3.0, ranges_of(true)), free)  # as likely worse by a percent as not
    assert unsure.verdict is Verdict.GOOD
    right = decide(known_length(chart, 0.0, 0.1, ranges_of(chart.rig)), free)
    assert right.verdict is Verdict.GOOD


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


def test_images_must_bear_it_out(drifted):
    """What the posterior is sure of, rows that are there may contradict: a lens that no model has."""
    _, seen = drifted[0]
    assert decide(seen, AXES).verdict is Verdict.REPAIR
    groups = seen.shown
    as_given = groups.rows(seen.chart, np.zeros(len(seen.theta))).differences[0]
    aligned = replace(seen, shown=replace(groups, offset=groups.offset - as_given))  # as if they met as calibrated
    assert decide(aligned, AXES).verdict is not Verdict.REPAIR


@pytest.mark.parametrize(("after", "repaired"), [((0.1, 0.9, 1.2), True), ((0.1, 1.1, 1.1), False)])
def test_most_frames_must_bear_it_out(drifted, after, repaired):
    """One frame may gain what others lose, on average."""
    _, seen = drifted[0]

    class Frames(type(seen)):
        def rows_of_frames(self, used):
            return np.array(after) if np.any(used) else np.ones(3)

    said = decide(Frames(**{field.name: getattr(seen, field.name) for field in fields(seen)}), AXES)
    assert (said.verdict is Verdict.REPAIR) == repaired


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
    beams = Beams(*pixels, metres, 0.002 * metres, np.full(len(metres), 0.02))
    seen = Estimate(chart, posterior, (0.05, 0.0), 0, float("nan"), sigma**2, beams=beams)

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


def test_rows_are_said_with_the_interval_that_holds_them(drifted):
    for _, seen in drifted:
        said = decide(seen, AXES)
        assert (said.rows_px[:, 1] < said.rows_px[:, 0]).all()
        assert (said.rows_px[:, 0] < said.rows_px[:, 2]).all()
        for one, (value, low, high) in zip(said.as_dict()["rows_px"].values(), said.rows_px.tolist(), strict=True):
            np.testing.assert_allclose([one["value"], one["low"], one["high"]], [value, low, high], atol=1e-3)


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

    said = decide(Harmful(**{**seen.__getstate__(), "beams": ranges_of(chart.rig)}), free)
    assert said.refused
    assert said.worse == 0.0
    assert not np.delete(said.theta, length).any()


@pytest.mark.parametrize("near", [3.0, 8.0])
def test_what_images_show_nearer_is_judged_there_too(rig, chart, prior, seen, near):
    """A translation of the drift moves the rows of near things more."""
    true = chart.rig_at(0.3 * np.eye(chart.dim)[chart.names.index("z")])
    found = estimate(seen(rig, true, cells=900, nearest=near), rig)
    said = decide(found, AXES)
    assert found.nearest == pytest.approx(near, rel=0.2)
    assert said.judged_at == ((found.nearest, *AWAY) if near < AWAY[0] else AWAY)
    assert said.as_dict()["distances"] == list(said.judged_at)


def test_an_estimate_without_images_is_judged_where_it_is_asked_for(looks):
    _, seen = looks(0, 0.5)
    alone = replace(seen, shown=None)
    assert alone.nearest == float("inf")
    assert decide(alone, AXES, Tolerances(distances=(7.0, 40.0))).judged_at == (7.0, 40.0)
