"""Levenberg-Marquardt in NumPy: the contract, the walls of the box, and SciPy as oracle."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.optimize import lsq_linear
from stereorecal_levenberg_marquardt import LevenbergMarquardt

from stereorecal.strategies import Objective, Problem, Status, Traced, run_strategy
from stereorecal.testing import StrategyConformance


class TestLevenbergMarquardt(StrategyConformance):
    strategy = LevenbergMarquardt()


def linear(jacobian: np.ndarray, offset: np.ndarray) -> Objective:
    def residuals(z):
        return jacobian @ z + offset

    def values(points):
        return -0.5 * np.sum((points @ jacobian.T + offset) ** 2, axis=-1)

    return Objective(Problem(jacobian.shape[1], values, traced=Traced(residuals=residuals)))


@given(seed=st.integers(0, 10**6), dim=st.integers(1, 6), far=st.floats(0.1, 5.0), weak=st.floats(-3.0, 0.0))
def test_linear_problems_in_the_box_as_scipy_solves_them(seed: int, dim: int, far: float, weak: float):
    draw = np.random.default_rng(seed)
    jacobian = draw.normal(size=(2 * dim + 1, dim)) * np.logspace(0, weak, dim) * 100
    offset = jacobian @ draw.uniform(-far, far, dim) + draw.normal(size=2 * dim + 1)
    objective, start = linear(jacobian, offset), draw.uniform(-1, 1, dim)
    run = run_strategy(LevenbergMarquardt(), objective, start)
    best = lsq_linear(jacobian, -offset, bounds=(-1, 1), tol=1e-14).x
    assert run.status is Status.CONVERGED
    assert np.linalg.norm(jacobian @ (run.best - best)) < 0.01
    assert np.abs(run.best).max() <= 1.0


def test_one_step_and_a_look_solve_a_linear_problem():
    objective = linear(np.diag([1e3, 1.0, 30.0]), np.array([100.0, 0.3, -3.0]))
    run = run_strategy(LevenbergMarquardt(), objective, np.zeros(3))
    np.testing.assert_allclose(run.best, [-0.1, -0.3, 0.1], atol=1e-6)
    assert run.trace.total_cost == 2 * objective.gradient_cost


def test_a_start_without_residuals_is_said():
    problem = Problem(2, lambda p: np.full(len(p), np.nan), traced=Traced(residuals=lambda z: z * np.nan))
    run = run_strategy(LevenbergMarquardt(), Objective(problem), np.zeros(2))
    assert run.status is Status.STALLED
    assert "not finite" in run.message


@pytest.mark.parametrize("wrong", [{"damping": 0.0}, {"tolerance": -1.0}, {"steps": 0}])
def test_options_that_make_no_sense(wrong: dict):
    with pytest.raises(ValueError, match="above 0"):
        LevenbergMarquardt(**wrong)
