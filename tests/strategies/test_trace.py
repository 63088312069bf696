"""The trace holds every evaluation: point, value, cost so far, seconds, index."""

import numpy as np
from hypothesis import given, strategies as st

from stereorecal.strategies import Objective, Problem


def test_contents(counter):
    objective = counter.objective(cost=0.25)
    points = np.array([[0.0, 0.0], [0.3, 0.3], [0.5, -0.5]])
    first = objective.value(points[0])
    rest = objective.batch(points[1:])
    trace = objective.trace
    np.testing.assert_array_equal(trace.points, points)
    np.testing.assert_array_equal(trace.values, [first, *rest])
    np.testing.assert_array_equal(trace.cost, [0.25, 0.5, 0.75])
    np.testing.assert_array_equal(trace.evaluations, [1, 2, 3])
    assert np.all(np.diff(trace.seconds) >= 0)
    assert trace.seconds[0] >= 0
    assert trace.total_cost == 0.75


def test_empty(counter):
    trace = counter.objective().trace
    assert trace.points.shape == (0, 2)
    assert trace.total_cost == 0.0
    assert trace.best_within(100) is None


@given(values=st.lists(st.one_of(st.floats(-10, 10), st.just(float("nan"))), min_size=1, max_size=12))
def test_best_within(values):
    queue = np.array(values)
    objective = Objective(Problem(1, lambda points: queue[: len(points)], 0.1))
    objective.batch(np.zeros((len(values), 1)))
    for number in range(len(values) + 1):
        seen = queue[:number][~np.isnan(queue[:number])]
        expected = seen.max() if seen.size else None
        assert objective.trace.best_within(0.1 * number) == expected


def test_a_fresh_meter(counter):
    objective = counter.objective(evaluations=1)
    objective.value(np.zeros(2))
    again = objective.with_budget(objective.budget)
    assert again.spent == 0
    again.value(np.zeros(2))
    assert len(objective.trace.values) == 1
