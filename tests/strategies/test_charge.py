"""Work done inside JAX is declared, and counts like any other."""

import numpy as np
import pytest

from stereorecal.strategies import BudgetExhausted


def test_charge_counts(counter):
    objective = counter.objective(evaluations=10)
    objective.value(np.zeros(2))
    objective.charge(2.5, best=np.array([0.1, 0.2]))
    assert objective.spent == 3.5
    assert objective.remaining == 6.5
    assert counter.evaluated == 1
    assert np.isnan(objective.trace.values[1])
    np.testing.assert_array_equal(objective.trace.points[1], [0.1, 0.2])
    np.testing.assert_array_equal(objective.trace.cost, [1.0, 3.5])


def test_the_charge_that_empties_the_budget_raises_and_is_recorded(counter):
    objective = counter.objective(evaluations=4)
    with pytest.raises(BudgetExhausted):
        objective.charge(4.0, best=np.array([0.3, 0.3]))
    assert objective.spent == 4
    np.testing.assert_array_equal(objective.trace.points, [[0.3, 0.3]])
    with pytest.raises(BudgetExhausted):
        objective.value(np.zeros(2))
    assert counter.evaluated == 0


@pytest.mark.parametrize("best", [[0.0, 1.1], [np.nan, 0.0], [0.0]])
def test_points_outside_the_box_are_refused(counter, best):
    objective = counter.objective(evaluations=4)
    with pytest.raises(ValueError, match=r"unit box|shape"):
        objective.charge(1.0, best=np.array(best))
    assert objective.spent == 0


def test_a_step_that_does_not_fit_is_refused_before_it_begins(counter):
    objective = counter.objective(evaluations=4)
    objective.reserve(0.0)
    objective.reserve(4.0)
    assert objective.spent == 0
    objective.charge(1.5, best=np.zeros(2))
    with pytest.raises(BudgetExhausted):
        objective.reserve(3.0)
    with pytest.raises(BudgetExhausted):
        objective.value(np.zeros(2))
    assert counter.evaluated == 0


def test_a_gradient_costs_one_evaluation_more_than_there_are_coordinates(counter):
    assert counter.objective(cost=0.25).gradient_cost == 0.75
