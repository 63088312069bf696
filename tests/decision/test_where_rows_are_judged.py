"""Where the decision judges rows: in regions, near and far, in each frame."""

from dataclasses import fields, replace

import numpy as np
import pytest

from stereorecal.decision import Tolerances, Verdict, decide
from stereorecal.estimation import (
    estimate,
    points_of_view,
    regions as regions_of,
)

AXES = ("pitch", "yaw", "roll", "y", "z")
AWAY = (5, 10, 30)


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
        over, depth = seen._readings.rows_and_nearness(theta)[1][:, 2], seen.losses(theta)[1]  # at 30 baselines
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
