"""The kit counts what runs inside JAX: n + 1 evaluations for a value with its derivative, in every mode."""

import jax
import jax.numpy as jnp
import pytest
from parts_of_estimates import _analytic_problems as problems

POINT = jnp.array([0.1, -0.2, 0.3], jnp.float32)
ALONG = jnp.array([1.0, 2.0, -1.0], jnp.float32)


DERIVATIVES = {
    "value and gradient": lambda f, z: jax.value_and_grad(lambda q: f(q))(z),
    "gradient": lambda f, z: jax.grad(lambda q: f(q))(z),
    "forward Jacobian": lambda f, z: jax.jacfwd(lambda q: f(q))(z),
    "reverse Jacobian": lambda f, z: jax.jacrev(lambda q: f(q))(z),
    "one direction": lambda f, z: jax.jvp(lambda q: f(q), (z,), (ALONG,)),
    "linearised": lambda f, z: jax.linearize(lambda q: f(q), z)[0],
    "directions side by side": lambda f, z: jax.vmap(lambda d: jax.jvp(lambda q: f(q), (z,), (d,)), out_axes=(None, 0))(
        jnp.eye(3)
    ),
}
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
@pytest.mark.parametrize("task", DERIVATIVES)
def test_a_derivative_of_the_soft_count(task, jitted):
    assert count_of(DERIVATIVES[task], jitted, "soft count") == 4


@pytest.mark.slow(after=2)
@jits
@pytest.mark.parametrize("task", ["forward Jacobian", "one direction", "directions side by side"])
def test_a_derivative_of_residuals(task, jitted):
    assert count_of(DERIVATIVES[task], jitted, "residuals") == 4


@jits
@pytest.mark.parametrize("kind", ["soft count", "residuals"])
def test_a_value_is_one_evaluation(jitted, kind):
    assert count_of(lambda f, z: f(z), jitted, kind) == 1


@jits
def test_calls_add_up_and_points_are_seen_where_they_are_evaluated(jitted):
    meter = problems.Meter()
    f = problems.problem(problems.bowl, 3, meter).traced.soft_count
    both = DERIVATIVES["value and gradient"]
    both = jax.jit(both) if jitted else both
    for number in range(1, 4):
        both(f, 0.5 * number * jnp.ones(3))
        assert (meter.total, meter.farthest) == (4 * number, 0.5 * number)
