"""What these tests share: the strategies, and one problem that all of them can solve."""

from collections.abc import Callable
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import stereorecal_optimistix

from stereorecal.strategies import Need, Problem, Traced

_FIRST = ("BFGS", "Dogleg", "NelderMead", "Adam")  # of each kind of loop one, and the one with momentum
STRATEGIES = sorted(
    (getattr(stereorecal_optimistix, name) for name in sorted(dir(stereorecal_optimistix)) if name[0].isupper()),
    key=lambda cls: cls.__name__ not in _FIRST,
)
CLIMBS = [cls for cls in STRATEGIES if cls.needs is not Need.HOST]


def matrix(dim: int) -> np.ndarray:
    """(8, n), with columns that are no two at a right angle."""
    return np.sin(1.0 + np.arange(8.0)[:, None] * np.arange(1.0, dim + 1.0)) + np.eye(8, dim)


class Residuals(eqx.Module):
    """Eight residuals, linear in z and zero at the summit; counts how often it is traced."""

    summit: jax.Array
    factor: jax.Array
    traced: ClassVar[list[None]] = []

    def __call__(self, z: jax.Array) -> jax.Array:
        self.traced.append(None)
        return self.factor * matrix(z.size).astype(np.float32) @ (z - self.summit)


class Score(eqx.Module):
    """-½ |residuals|²."""

    residuals: Residuals

    def __call__(self, z: jax.Array) -> jax.Array:
        return -0.5 * (self.residuals(z) ** 2).sum()


class Broken(eqx.Module):
    """A traced function that is `instead` for z_0 > 0.1."""

    function: Callable
    instead: jax.Array

    def __call__(self, z: jax.Array) -> jax.Array:
        return jnp.where(z[0] > 0.1, self.instead, 1.0) * self.function(z)


def make_problem(summit=(0.4, -0.3, 0.2), factor: float = 1.0, instead: float | None = None) -> Problem:
    """A bowl upside down with its maximum of 0 at the summit, on all faces; `instead` times as high for z_0 > 0.1."""
    residuals = Residuals(jnp.array(summit, jnp.float32), jnp.asarray(factor, jnp.float32))
    functions = [Score(residuals), residuals]
    if instead is not None:
        functions = [Broken(function, jnp.asarray(instead, jnp.float32)) for function in functions]
    score, residuals = functions

    def values(points: np.ndarray) -> np.ndarray:
        rows = factor * (points - np.asarray(summit)) @ matrix(len(summit)).T
        beyond = 1.0 if instead is None else instead
        return -0.5 * (rows**2).sum(-1) * np.where(points[:, 0] > 0.1, beyond, 1.0)

    return Problem(len(summit), values, traced=Traced(soft_count=score, residuals=residuals))


@pytest.fixture(scope="session", params=STRATEGIES, ids=lambda cls: cls.__name__)
def strategy_class(request):
    """Every strategy of the distribution."""
    return request.param


@pytest.fixture(scope="session", params=CLIMBS, ids=lambda cls: cls.__name__)
def climb_class(request):
    """Every strategy that follows a derivative."""
    return request.param


@pytest.fixture(scope="session")
def problem():
    """The maker of problems."""
    return make_problem


@pytest.fixture
def traces():
    """One entry for each time that a traced function was traced."""
    Residuals.traced.clear()
    return Residuals.traced


@pytest.fixture
def compilations():
    """One entry for each program that is compiled."""
    if not hasattr(jax.monitoring, "unregister_event_duration_listener"):
        pytest.skip("this JAX never lets a listener go")
    names: list[str] = []

    def note(event: str, seconds: float, **details) -> None:
        if "backend_compile" in event:
            names.append(event)

    jax.monitoring.register_event_duration_secs_listener(note)
    yield names
    jax.monitoring.unregister_event_duration_listener(note)
