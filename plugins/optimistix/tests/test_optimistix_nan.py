"""Where the score has no value."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from stereorecal_optimistix import BFGS, LBFGS, Dogleg, LevenbergMarquardt, NelderMead, NonlinearCG

from stereorecal.strategies import Objective, Status, Traced, run_strategy

START = np.array([-0.2, 0.1, 0.3])
BACKTRACKING = (BFGS, LBFGS, NonlinearCG, LevenbergMarquardt, Dogleg, NelderMead)


@pytest.mark.slow(after=4)
def test_nan_on_the_way_is_never_nominated(strategy_class, problem):
    broken = problem(instead=np.nan)
    outcome = strategy_class().run(Objective(broken), START, 0)
    start, best = broken.values(np.stack([START, outcome.best]))
    assert best >= start
    assert outcome.best[0] <= 0.1


@pytest.mark.parametrize("cls", BACKTRACKING)
def test_those_that_backtrack_go_on_beside_nan(cls, problem):
    broken = problem(instead=np.nan)
    run = run_strategy(cls(), Objective(broken), START)
    assert run.value > 0.5 * run.start_value


@pytest.mark.slow(after=4)
def test_nan_at_the_start_ends_the_run(strategy_class, problem):
    broken = problem(instead=np.nan)
    objective = Objective(broken)
    outcome = strategy_class().run(objective, np.full(3, 0.5), 0)
    assert outcome.status is Status.STALLED
    assert "at the start" in outcome.message
    np.testing.assert_array_equal(outcome.best, np.full(3, 0.5))
    assert objective.spent == 4


@pytest.mark.slow(after=3)
def test_a_value_without_a_slope_is_no_place_to_go_on_from(climb_class, problem):
    """Beyond z_0 = 0.1 there are values, and no slope: the others back away from there, as they do from NaN."""

    def breaking(function):
        return lambda z: function(z) + 0.0 * jnp.sqrt(jnp.maximum(0.0, 0.1 - z[0]))

    bowl = problem()
    traced = Traced(soft_count=breaking(bowl.traced.soft_count), residuals=breaking(bowl.traced.residuals))
    run = run_strategy(climb_class(), Objective(replace(bowl, traced=traced)), START)
    assert run.best[0] > 0.1
    assert run.value > 0.5 * run.start_value
    if climb_class not in BACKTRACKING:
        assert run.status is Status.STALLED
        assert "finite" in run.message


def test_no_slope_at_the_start_ends_the_run(climb_class, problem):
    flat = problem(factor=0.0)
    objective = Objective(flat)
    outcome = climb_class().run(objective, START, 0)
    assert outcome.status is Status.STALLED
    assert outcome.message == "the derivative vanishes at the start"
    assert objective.spent == 4
