"""The objective on epipolar residuals: what it is worth, what it costs, and that its solutions are the truth."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.geometry import Camera, StereoRig, rotation_from_euler
from stereorecal.objectives import Reach, epipolar_objective, linear_residuals, linearised, row_chart
from stereorecal.scoring import Correspondences
from stereorecal.strategies import Budget, Status, run_strategy, strategy

CAMERA = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]))
RIG = StereoRig(CAMERA, CAMERA, np.array([0.005, -0.008, 0.004, -0.36, 0.004, -0.003]))
CHART = row_chart(RIG, Reach(1.5, 0.015))  # half a width is 3 degrees
PRIOR = 1 / 6
FRAMES, CELLS = 2, 400
in_box = st.tuples(*[st.floats(-1, 1)] * 5).map(np.array)


def exact(z, seed=0, found=1.0) -> Correspondences:
    """Exact rays of random points in the rig at z; a share `found` of them is there."""
    rng, truth = np.random.default_rng(seed), CHART.extrinsics(np.asarray(z, float))
    left = rng.uniform([-0.5, -0.4, 1.0], [0.5, 0.4, 1.0], (FRAMES, CELLS, 3))
    right = left * rng.uniform(2, 15, (FRAMES, CELLS, 1)) @ rotation_from_euler(truth[:3]).T + truth[3:]
    return Correspondences(
        left.astype(np.float32),
        right.astype(np.float32),
        (rng.random((FRAMES, CELLS)) < found).astype(np.float32),
        np.zeros((FRAMES, CELLS), np.int32),
        *(np.asarray(number, np.float32) for number in (500.0, 1.0, 0.2)),
    )


def made(z=(0.1, -0.2, 0.05, 0.3, -0.1), seed=0, precision=4.0, prior=PRIOR, budget=None, at=(0.0,) * 5):
    found = exact(z, seed)
    weights = np.full(found.weight.size, precision)
    return epipolar_objective(linear_residuals(*flat(found, np.asarray(at)), weights, prior), budget)


def flat(found, at, frames=FRAMES):
    """The arguments of `linear_residuals`, by the rows of all frames, or of the first."""
    rows, jacobian = (500.0 * part for part in linearised((found.left, found.right), found.projection, CHART, at))
    return at, rows[:frames].ravel(), jacobian[:, :frames].reshape(5, -1).T


@given(at=in_box, z=in_box, seed=st.integers(0, 5))
def test_the_value_is_that_of_all_weighted_rows_and_the_prior(at, z, seed):
    """A few rows stand for all: written out, in float64; and the traced residuals have the same norm."""
    found = exact([0.1, -0.2, 0.05, 0.3, -0.1], seed)
    precision = np.random.default_rng(seed).uniform(0, 9, found.weight.size)
    _, rows, jacobian = flat(found, at)
    problem = epipolar_objective(linear_residuals(at, rows, jacobian, precision, PRIOR))
    linear = rows + jacobian @ (z - at)
    expected = -0.5 * (np.sum(precision * linear**2) + np.sum((z / PRIOR) ** 2))
    assert problem.value(z) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert -0.5 * np.sum(problem.traced.residuals(z) ** 2) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    traced = np.asarray(problem.traced.residuals(jnp.asarray(z, jnp.float32)), float)
    assert -0.5 * np.sum(traced**2) == pytest.approx(expected, rel=1e-4, abs=1e-3)
    assert traced.shape == (11,)


def test_an_evaluation_costs_next_to_nothing():
    """However many rows there are: they were summed before."""
    problem = made()
    assert 0 < problem.cost < 1e-5
    problem.batch(np.zeros((7, 5)))
    assert problem.spent == pytest.approx(7 * problem.cost)
    half = flat(exact([0.0] * 5), np.zeros(5), frames=1)
    assert epipolar_objective(linear_residuals(*half, np.ones(CELLS), PRIOR)).cost == problem.cost


def test_one_program_for_any_number_of_rows():
    traces = 0

    @jax.jit
    def residuals(function, z):
        nonlocal traces
        traces += 1
        return function(z)

    found = exact([0.1] * 5)
    asked = [
        epipolar_objective(linear_residuals(*flat(found, np.zeros(5), frames), np.ones(frames * CELLS), 0.2))
        for frames in (FRAMES, 1)
    ]
    answers = [residuals(a.traced.residuals, jnp.zeros(5)) for a in asked]
    assert traces == 1
    assert not np.allclose(*answers)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", [None, "levenberg-marquardt", "optimistix-levenberg-marquardt"])
def test_solved_anew_a_few_times_it_ends_at_the_truth(seed, name):
    """From the centre, 1.8 degrees and 1.8 % off at most: exact rays and a prior of no weight lead back to 0.001°, by
    strategies and by the fit's own step."""
    truth = np.random.default_rng(seed).uniform(-0.6, 0.6, 5)
    at = np.zeros(5)
    for _ in range(3):
        problem = made(truth, seed, precision=400.0, prior=100.0, budget=Budget(evaluations=1.0), at=at)
        if name is None:
            at = problem.traced.residuals.least
        else:
            run = run_strategy(strategy(name), problem, at)
            assert run.status is Status.CONVERGED
            at = run.best
    error = np.abs(at - truth) * [3, 3, 3, 3, 3]  # degrees and percent of the baseline
    assert error[[0, 2]].max() < 1e-3
    assert error[1] < 5e-3
    assert error[3:].max() < 0.02


def test_a_strong_prior_holds_it_back():
    truth = np.full(5, 0.5)
    solver, ends = strategy("levenberg-marquardt"), []
    for prior in (1e-4, 1e-2, 1.0):
        ends.append(np.abs(run_strategy(solver, made(truth, prior=prior), np.zeros(5)).best).max())
    assert ends[0] < 0.02
    assert ends == sorted(ends)
    assert ends[2] > 0.4
