"""Points outside the unit box are refused before anything is evaluated."""

import numpy as np
import pytest


@pytest.mark.parametrize("bad", [1.001, -1.5, np.nan, np.inf, -np.inf])
def test_outside(counter, bad):
    objective = counter.objective()
    with pytest.raises(ValueError, match="outside the unit box"):
        objective.batch(np.array([[0.0, 0.0], [0.0, bad]]))
    with pytest.raises(ValueError, match="outside the unit box"):
        objective.value(np.array([bad, 0.0]))
    assert counter.evaluated == 0
    assert len(objective.trace.values) == 0


def test_the_border_belongs_to_the_box(counter):
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
    assert len(counter.objective().batch(corners)) == 4


@pytest.mark.parametrize("shape", [(1, 3), (2, 1), (0, 3)])
def test_wrong_number_of_coordinates(counter, shape):
    with pytest.raises(ValueError, match=r"takes \(k, 2\)"):
        counter.objective().batch(np.zeros(shape))


def test_no_points_cost_nothing(counter):
    objective = counter.objective(evaluations=1)
    assert objective.batch(np.zeros((0, 2))).shape == (0,)
    assert objective.spent == 0


def test_the_caller_may_reuse_its_array(counter):
    """What is recorded is what was asked, not what the array holds later."""
    objective = counter.objective()
    point = np.array([[0.1, 0.2]])
    objective.batch(point)
    point[:] = 0.9
    np.testing.assert_array_equal(objective.trace.points, [[0.1, 0.2]])
