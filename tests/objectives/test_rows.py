"""The objective on epipolar residuals: what it is worth, what it costs, and that it leads to the truth."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.geometry import Camera, StereoRig, rotation_from_euler
from stereorecal.objectives import Reach, SearchBox, count_box, epipolar_objective
from stereorecal.scoring import Correspondences, row_differences
from stereorecal.strategies import Budget, Status, run_strategy, strategy

CAMERA = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]))
RIG = StereoRig(CAMERA, CAMERA, np.array([0.005, -0.008, 0.004, -0.36, 0.004, -0.003]))
CHART = count_box(RIG, Reach(3.0, 0.03)).chart
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


def made(z=(0.1, -0.2, 0.05, 0.3, -0.1), seed=0, precision=4.0, prior=PRIOR, budget=None):
    found = exact(z, seed)
    box = SearchBox(CHART, prior)
    return epipolar_objective(found, np.full(found.weight.shape, precision), box, budget)


@settings(max_examples=25)
@given(z=in_box)
def test_the_value_is_that_of_the_residuals(z):
    """On the host and traced; against the rows and the prior written out in float64."""
    problem = made()
    residuals = np.asarray(problem.traced.residuals(jnp.asarray(z, jnp.float32)), float)
    assert residuals.shape == (FRAMES * CELLS + 5,)
    rows = 2.0 * np.asarray(row_differences(exact([0.1, -0.2, 0.05, 0.3, -0.1]), CHART.extrinsics(z))).ravel()
    np.testing.assert_allclose(residuals[:-5], rows, atol=0.02)
    np.testing.assert_allclose(residuals[-5:], 6.0 * z, atol=1e-5)
    assert problem.value(z) == pytest.approx(-0.5 * np.sum(residuals**2), rel=1e-4, abs=1e-4)


def test_weights_of_zero_leave_the_prior_alone():
    found = exact([0.5] * 5)
    problem = epipolar_objective(found, np.zeros(found.weight.shape), SearchBox(CHART, 0.25))
    z = np.array([0.5, -0.25, 0.0, 1.0, -1.0])
    assert problem.value(z) == pytest.approx(-8.0 * np.sum(z**2), rel=1e-6)
    assert problem.value(np.zeros(5)) == 0.0


def test_each_row_has_its_own_weight():
    found = exact([0.1, 0.2, 0.3, 0.4, 0.5])
    precision = np.random.default_rng(0).uniform(0, 9, found.weight.shape)
    residuals = epipolar_objective(found, precision, SearchBox(CHART, PRIOR)).traced.residuals(jnp.zeros(5))[:-5]
    rows = np.asarray(row_differences(found, CHART.extrinsics(np.zeros(5)))).ravel()
    np.testing.assert_allclose(residuals, np.sqrt(precision).ravel() * rows, atol=5e-3)


def test_cost_is_that_of_the_rows():
    """Far below the cost of a matcher run, and proportional to the rows."""
    problem = made()
    assert 0 < problem.cost < 1e-3
    problem.batch(np.zeros((7, 5)))
    assert problem.spent == pytest.approx(7 * problem.cost)
    found = exact([0.0] * 5)
    half = Correspondences(*(leaf[:1] if np.ndim(leaf) else leaf for leaf in vars(found).values()))
    assert epipolar_objective(half, np.ones((1, CELLS)), SearchBox(CHART, PRIOR)).cost == pytest.approx(
        problem.cost / 2
    )


def test_programs_are_shared_by_objectives_of_equal_shape():
    traces = 0

    @jax.jit
    def residuals(function, z):
        nonlocal traces
        traces += 1
        return function(z)

    answers = [residuals(made(z, seed, prior=p).traced.residuals, jnp.zeros(5)) for z, seed, p in CASES]
    assert traces == 1
    assert not np.allclose(*answers)


CASES = (([0.1] * 5, 0, 0.2), ([-0.3] * 5, 1, 0.1))


def test_derivatives():
    """Central differences; what Gauss-Newton rests on."""
    residuals = made().traced.residuals
    z = np.array([0.2, -0.1, 0.1, 0.0, 0.3])
    jacobian = np.asarray(jax.jit(lambda f, q: jax.jacfwd(lambda p: f(p))(q))(residuals, jnp.asarray(z, jnp.float32)))
    step, found = 1e-6, exact([0.1, -0.2, 0.05, 0.3, -0.1])
    ends = [[row_differences(found, CHART.extrinsics(z + s * e)).ravel() for s in (step, -step)] for e in np.eye(5)]
    expected = 2.0 * np.stack([(a - b) / (2 * step) for a, b in ends], axis=-1)
    np.testing.assert_allclose(jacobian[:-5], expected, atol=2e-3 * np.abs(expected).max())
    np.testing.assert_allclose(jacobian[-5:], 6.0 * np.eye(5), atol=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_levenberg_marquardt_finds_the_truth(seed):
    """From the centre, 1.8 degrees and 1.8 % off at most: exact rays and a prior of no weight lead back to 0.001°."""
    truth = np.random.default_rng(seed).uniform(-0.6, 0.6, 5)
    problem = made(truth, seed, precision=400.0, prior=100.0, budget=Budget(evaluations=1.0))
    solver = strategy("optimistix-levenberg-marquardt", rtol=1e-5, atol=1e-5)
    run = run_strategy(solver, problem, np.zeros(5))
    assert run.status is Status.CONVERGED
    error = np.abs(run.best - truth) * [3, 3, 3, 3, 3]  # degrees and percent of the baseline
    assert error[[0, 2]].max() < 1e-3
    assert error[1] < 5e-3
    assert error[3:].max() < 0.02
    assert run.value > 1e-4 * run.start_value


def test_a_strong_prior_holds_it_back():
    truth = np.full(5, 0.5)
    ends = []
    for prior in (1e-4, 1e-2, 1.0):
        solver = strategy("optimistix-levenberg-marquardt")
        ends.append(np.abs(run_strategy(solver, made(truth, prior=prior), np.zeros(5)).best).max())
    assert ends[0] < 0.02
    assert ends == sorted(ends)
    assert ends[2] > 0.4
