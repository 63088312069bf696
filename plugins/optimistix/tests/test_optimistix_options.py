"""Options that make no sense are refused with a sentence; those that do mean what they say."""

from dataclasses import fields

import numpy as np
import pytest
from stereorecal_optimistix import BFGS, LBFGS, Adam, GradientDescent, LevenbergMarquardt, NelderMead, NonlinearCG

from stereorecal.strategies import Budget, Objective, Problem, Status, run_strategy


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_every_option_is_a_positive_number(strategy_class, value):
    for option in fields(strategy_class):
        if option.name != "steps":
            with pytest.raises(ValueError, match=f"need {option.name} > 0, got"):
                strategy_class(**{option.name: value})


@pytest.mark.parametrize("steps", [0, -3])
def test_at_least_one_step(strategy_class, steps):
    with pytest.raises(ValueError, match="need steps > 0, got"):
        strategy_class(steps=steps)


def test_steps_are_whole(strategy_class):
    with pytest.raises(Exception, match="steps"):  # the type checker of the test suite may be the first to say so
        strategy_class(steps=2.5)


@pytest.mark.parametrize("cls", [BFGS, Adam, NelderMead])
def test_a_first_step_fits_into_the_box(cls):
    with pytest.raises(ValueError, match=r"the width of the box, got 2\.1"):
        cls(step=2.1)


@pytest.mark.parametrize("cls", [BFGS, LBFGS, NonlinearCG, GradientDescent])
@pytest.mark.parametrize("step", [1 / 16, 1 / 64])
def test_the_first_step_has_the_length_it_says(problem, cls, step):
    objective = Objective(problem())
    cls(step=step, steps=1).run(objective, np.zeros(3), 0)
    start, first = objective.trace.points
    assert np.linalg.norm(first - start) == pytest.approx(step, rel=0.01)


def test_adam_moves_each_coordinate_by_its_step(problem):
    objective = Objective(problem())
    Adam(step=1 / 64, steps=1).run(objective, np.zeros(3), 0)
    np.testing.assert_allclose(np.abs(objective.trace.points[1]), 1 / 64, rtol=0.01)


def test_the_first_simplex_is_the_start_and_a_step_along_each_axis(problem):
    objective = Objective(problem(), Budget(evaluations=4))
    run = run_strategy(NelderMead(step=0.1), objective, np.zeros(3))
    np.testing.assert_allclose(run.trace.points, np.sin([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]), rtol=1e-6)


def test_the_unit_of_the_score_changes_nothing(problem, climb_class):
    traces = []
    for factor in (1.0, 2.0**9):  # a power of two, so nothing is rounded
        objective = Objective(problem(factor=factor))
        climb_class(steps=20).run(objective, np.zeros(3), 0)
        traces.append(objective.trace.points)
    np.testing.assert_allclose(*traces, atol=1e-6)


def test_damping_shortens_the_first_step(problem):
    def first_step(damping: float) -> float:
        objective = Objective(problem())
        LevenbergMarquardt(damping=damping, steps=1).run(objective, np.zeros(3), 0)
        return float(np.linalg.norm(objective.trace.points[1]))

    lengths = [first_step(damping) for damping in (1e-3, 1.0, 1e3)]
    assert lengths[0] > 1.1 * lengths[1] > 11 * lengths[2]


@pytest.mark.parametrize("cls", [BFGS, NelderMead])
def test_looser_tolerances_take_fewer_steps(problem, cls):
    tight, loose = (
        run_strategy(strategy, Objective(problem()), np.full(3, -0.8)) for strategy in (cls(), cls(rtol=0.5, atol=0.5))
    )
    assert tight.status is loose.status is Status.CONVERGED
    assert len(loose.trace.values) < len(tight.trace.values)


def test_a_need_that_is_not_met_is_the_cores_business(strategy_class):
    """Nelder-Mead alone works with values on the host."""
    bare = Objective(Problem(2, lambda points: -(points**2).sum(-1)))
    assert (bare.missing(strategy_class.needs) is None) == (strategy_class is NelderMead)
