"""A budget is kept exactly: what fits is evaluated, the rest raises, for ever."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import InputError
from stereorecal.strategies import Budget, BudgetExhausted, Objective, Problem


def objective_with(evaluated, limit, cost=1.0):
    def values(points):
        evaluated.append(len(points))
        return points[:, 0]

    return Objective(Problem(1, values, cost), Budget(evaluations=limit))


@given(
    limit=st.integers(1, 40),
    cost=st.sampled_from([1.0, 0.25, 0.09, 0.01, 3.0]),
    sizes=st.lists(st.integers(0, 12), max_size=15),
)
def test_spent_exactly(limit, cost, sizes):
    evaluated: list[int] = []
    objective = objective_with(evaluated, limit, cost)
    most = int((limit + 1e-9) // cost)
    asked, raised = 0, False
    for size in sizes:
        fits = not raised and asked + size <= most
        asked += size
        if fits:
            assert len(objective.batch(np.zeros((size, 1)))) == size
        elif size:
            raised = True
            with pytest.raises(BudgetExhausted):
                objective.batch(np.zeros((size, 1)))
        if raised:
            break
    assert sum(evaluated) == min(asked, most)
    assert objective.spent == pytest.approx(sum(evaluated) * cost)
    assert objective.spent <= limit + 1e-9
    assert len(objective.trace.values) == sum(evaluated)


def test_a_batch_that_does_not_fit_is_evaluated_as_far_as_it_fits(counter):
    objective = counter.objective(evaluations=5)
    objective.batch(np.zeros((3, 2)))
    points = np.linspace(0.0, 0.8, 8).reshape(4, 2)
    with pytest.raises(BudgetExhausted):
        objective.batch(points)
    assert counter.batches == [3, 2]
    np.testing.assert_array_equal(objective.trace.points[3:], points[:2])


def test_once_exhausted_it_always_raises_and_evaluates_nothing(counter):
    objective = counter.objective(evaluations=2)
    with pytest.raises(BudgetExhausted):
        objective.batch(np.zeros((3, 2)))
    for _ in range(5):
        with pytest.raises(BudgetExhausted):
            objective.value(np.zeros(2))
        with pytest.raises(BudgetExhausted):
            objective.batch(np.zeros((4, 2)))
        with pytest.raises(BudgetExhausted):
            objective.batch(np.zeros((0, 2)))
        with pytest.raises(BudgetExhausted):
            objective.charge(0.1, best=np.zeros(2))
    assert counter.evaluated == 2
    assert objective.spent == 2
    assert objective.remaining == 0


def test_the_last_unit_is_still_served(counter):
    objective = counter.objective(evaluations=3)
    assert len(objective.batch(np.zeros((3, 2)))) == 3
    assert objective.remaining == 0


def test_without_a_limit(counter):
    objective = counter.objective()
    objective.batch(np.zeros((1000, 2)))
    assert objective.remaining == np.inf


def test_a_deadline_in_the_past_evaluates_nothing(counter):
    objective = counter.objective(seconds=1e-12)
    with pytest.raises(BudgetExhausted):
        objective.value(np.zeros(2))
    assert counter.evaluated == 0
    assert objective.remaining == 0


def test_a_deadline_far_away_does_no_harm(counter):
    objective = counter.objective(seconds=1e6)
    assert objective.value(np.full(2, 0.3)) == 1.0


@pytest.mark.parametrize("limit", [0, -1, float("nan"), 0.0, -0.5])
@pytest.mark.parametrize("name", ["evaluations", "seconds"])
def test_budgets_that_make_no_sense(name, limit):
    with pytest.raises(InputError, match=f"budget of {limit} {name} makes no sense"):
        Budget(**{name: limit})
