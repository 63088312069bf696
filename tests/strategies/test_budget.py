"""A budget is kept exactly: what fits is evaluated, the rest raises, for ever."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import InputError
from stereorecal.strategies import Budget, BudgetExhausted, Objective, Problem


@given(
    limit=st.integers(1, 40),
    cost=st.sampled_from([1.0, 0.25, 0.09, 0.01, 3.0]),
    sizes=st.lists(st.integers(0, 12), max_size=15),
)
def test_spent_exactly(limit, cost, sizes):
    """A batch that does not fit is evaluated as far as it fits, from its first point on."""
    evaluated: list[int] = []
    objective = Objective(Problem(1, lambda x: evaluated.append(len(x)) or x[:, 0], cost), Budget(evaluations=limit))
    most = int((limit + 1e-9) // cost)
    points, raised = np.random.default_rng(limit).uniform(-1, 1, (sum(sizes), 1)), False
    asked = 0
    for size in sizes:
        fits = asked + size <= most
        batch = points[asked : asked + size]
        asked += size
        if fits:
            assert len(objective.batch(batch)) == size
            assert objective.remaining == pytest.approx(limit - objective.spent)
        else:
            raised = True
            with pytest.raises(BudgetExhausted):
                objective.batch(batch)
            break
    assert sum(evaluated) == len(objective.trace.values) == min(asked, most)
    np.testing.assert_array_equal(objective.trace.points, points[: min(asked, most)])
    assert objective.spent == pytest.approx(sum(evaluated) * cost)
    assert objective.spent <= limit + 1e-9
    assert not raised or objective.remaining == 0


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


def test_a_deadline_in_the_past_evaluates_nothing(counter):
    objective = counter.objective(seconds=1e-12)
    with pytest.raises(BudgetExhausted):
        objective.value(np.zeros(2))
    assert counter.evaluated == 0
    assert objective.remaining == 0


@pytest.mark.parametrize("limit", [0, -1, float("nan"), 0.0, -0.5])
@pytest.mark.parametrize("name", ["evaluations", "seconds"])
def test_budgets_that_make_no_sense(name, limit):
    with pytest.raises(InputError, match=f"budget of {limit} {name} makes no sense"):
        Budget(**{name: limit})
