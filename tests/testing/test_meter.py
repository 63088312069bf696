"""The kit counts what runs inside JAX: n + 1 evaluations for a value with its derivative, in every mode."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal.testing import _analytic_problems as problems

POINT = jnp.array([0.1, -0.2, 0.3], jnp.float32)
ALONG = jnp.array([1.0, 2.0, -1.0], jnp.float32)


def value_and_gradient(f, z):
    return jax.value_and_grad(lambda q: f(q))(z)


def gradient(f, z):
    return jax.grad(lambda q: f(q))(z)


def forward_jacobian(f, z):
    return jax.jacfwd(lambda q: f(q))(z)


def reverse_jacobian(f, z):
    return jax.jacrev(lambda q: f(q))(z)


def one_direction(f, z):
    return jax.jvp(lambda q: f(q), (z,), (ALONG,))


def linearised(f, z):
    return jax.linearize(lambda q: f(q), z)[0]


def with_directions_side_by_side(f, z):
    return jax.vmap(lambda d: jax.jvp(lambda q: f(q), (z,), (d,)), out_axes=(None, 0))(jnp.eye(3))


DERIVATIVES = [
    value_and_gradient,
    gradient,
    forward_jacobian,
    reverse_jacobian,
    one_direction,
    linearised,
    with_directions_side_by_side,
]
jits = pytest.mark.parametrize("jitted", [False, True], ids=["eager", "jit"])


def count_of(task, jitted, kind):
    meter = problems.Meter()
    if kind == "soft count":
        f = problems.problem(problems.bowl, 3, meter).traced.soft_count
    else:
        f = problems.problem(problems.linear, 3, meter).traced.residuals
    (jax.jit(task) if jitted else task)(f, POINT)
    return meter.total


@pytest.mark.slow(after=3)
@jits
@pytest.mark.parametrize("task", DERIVATIVES, ids=lambda task: task.__name__)
def test_a_derivative_of_the_soft_count(task, jitted):
    assert count_of(task, jitted, "soft count") == 4


@pytest.mark.slow(after=2)
@jits
@pytest.mark.parametrize("task", [forward_jacobian, one_direction, with_directions_side_by_side])
def test_a_derivative_of_residuals(task, jitted):
    assert count_of(task, jitted, "residuals") == 4


@jits
@pytest.mark.parametrize("kind", ["soft count", "residuals"])
def test_a_value_is_one_evaluation(jitted, kind):
    assert count_of(lambda f, z: f(z), jitted, kind) == 1


@jits
def test_calls_add_up_and_points_are_seen_where_they_are_evaluated(jitted):
    meter = problems.Meter()
    f = problems.problem(problems.bowl, 3, meter).traced.soft_count
    both = jax.jit(value_and_gradient) if jitted else value_and_gradient
    for number in range(1, 4):
        both(f, 0.5 * number * jnp.ones(3))
        assert (meter.total, meter.farthest) == (4 * number, 0.5 * number)


def test_every_mode_gives_the_same_gradient():
    f = problems.problem(problems.bowl, 3).traced.soft_count
    expected = -2.0 * (np.asarray(POINT) - np.linspace(-0.4, 0.3, 3))
    for task in (gradient, forward_jacobian, reverse_jacobian):
        np.testing.assert_allclose(task(f, POINT), expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(one_direction(f, POINT)[1], expected @ np.asarray(ALONG), rtol=1e-5)
