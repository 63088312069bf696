"""Residuals turned into a triangle: their lengths and angles are those of all rows, and steps are compiled once."""

import hypothesis.extra.numpy as hnp
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_optimistix import Dogleg, GaussNewton, LevenbergMarquardt
from stereorecal_optimistix._evaluation import triangle

from stereorecal.strategies import Objective, Problem, Traced, run_strategy


@pytest.mark.slow
@settings(deadline=None)
@given(rows=st.sampled_from([2, 7, 127, 128, 129, 1000]), seed=st.integers(0, 2**32 - 1))
def test_it_is_the_triangle_of_a_qr_decomposition(rows, seed):
    dense = np.random.default_rng(seed).normal(size=(rows, 6)).astype(np.float32)
    expected = np.linalg.qr(dense.astype(float), mode="r")
    expected *= np.where(np.diag(expected) < 0, -1, 1)[:, None]
    np.testing.assert_allclose(triangle(jnp.asarray(dense)), expected, atol=1e-5 * np.sqrt(rows))


@settings(deadline=None)
@given(dense=hnp.arrays(np.float32, (150, 3), elements=st.floats(-10, 10, width=32)))
def test_any_rows_keep_their_lengths_and_angles(dense):
    found = np.asarray(triangle(jnp.asarray(dense)), float)
    assert found.shape == (3, 3)
    assert (np.diag(found) >= 0).all()
    gram = dense.astype(float).T @ dense
    np.testing.assert_allclose(found.T @ found, gram, atol=1e-5 * max(1.0, np.abs(gram).max()))


def test_nan_stays_nan():
    assert np.isnan(triangle(jnp.ones((300, 3)).at[200, 1].set(jnp.nan))).any()


def lines(m: int) -> Objective:
    """m residuals, linear in z, that vanish at (0.3, -0.2)."""
    slopes = np.random.default_rng(m).normal(size=(m, 2)).astype(np.float32)
    summit = np.array([0.3, -0.2], np.float32)

    def residuals(z: jax.Array) -> jax.Array:
        return slopes @ (z - summit)

    def values(points: np.ndarray) -> np.ndarray:
        return -0.5 * np.sum(np.square(np.stack([residuals(p) for p in points])), axis=1, dtype=float)

    return Objective(Problem(2, values, traced=Traced(residuals=residuals)))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("solver", [Dogleg, GaussNewton, LevenbergMarquardt])
def test_any_number_of_residuals_takes_the_same_program_for_a_step(solver, compilations):
    """What is compiled for others is their evaluation alone: as much for as many as before as for more."""
    run_strategy(solver(), lines(9), np.zeros(2))
    compiled = []
    for number in (9, 500):
        compilations.clear()
        run = run_strategy(solver(), lines(number), np.zeros(2))
        compiled.append(len(compilations))
        np.testing.assert_allclose(run.best, [0.3, -0.2], atol=1e-3)
    assert compiled[0] == compiled[1] > 0


@pytest.mark.parametrize("solver", [Dogleg, GaussNewton, LevenbergMarquardt])
def test_residuals_that_leave_an_axis_open_are_solved(solver):
    def residuals(z: jax.Array) -> jax.Array:
        return (z[0] + z[1] - 0.1) * jnp.ones(200)

    def values(points: np.ndarray) -> np.ndarray:
        return -100.0 * (points.sum(axis=1) - 0.1) ** 2

    run = run_strategy(solver(), Objective(Problem(2, values, traced=Traced(residuals=residuals))), np.zeros(2))
    assert run.best.sum() == pytest.approx(0.1, abs=1e-3)
