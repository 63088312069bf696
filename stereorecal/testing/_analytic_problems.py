"""Analytic problems on the unit box, each with one difficulty of real scores.

Every problem has a host face and a traced face. The traced functions are pytrees that carry their data, which of a few
scores they are among it, so that one compiled program serves all problems of one dimension; and they count how often
and where they run: a strategy cannot hide evaluations inside JAX.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, namespace, register_pytree
from stereorecal.scoring import forward_gradient
from stereorecal.strategies import Problem, Traced

Score = Callable[[Any], Any]  # (..., n) -> (...), NumPy or traced


class Meter:
    """Counts the evaluations of a problem on both faces, whether a strategy declares them or not."""

    _traced: dict[int, float] = {}  # noqa: RUF012  shared: the callbacks of compiled programs look them up
    _farthest: dict[int, float] = {}  # noqa: RUF012
    _created = 0

    def __init__(self) -> None:
        self.on_host = 0
        Meter._created += 1
        self.key = Meter._created
        Meter._traced[self.key] = Meter._farthest[self.key] = 0.0

    @property
    def total(self) -> float:
        """Evaluations so far; a value with its gradient, or residuals with their Jacobian, count n + 1."""
        jax.effects_barrier()
        return self.on_host + Meter._traced[self.key]

    @property
    def farthest(self) -> float:
        """The largest absolute coordinate at which a traced function was evaluated."""
        jax.effects_barrier()
        return Meter._farthest[self.key]

    @staticmethod
    def tick(key: AnyArray, coordinate: AnyArray, count: int) -> None:
        """Called from inside compiled programs."""
        Meter._traced[int(key)] += count
        Meter._farthest[int(key)] = max(Meter._farthest[int(key)], float(coordinate))


@register_pytree
@dataclass(frozen=True, eq=False)
class _Counted:
    """A traced function that counts each of its runs: the one of `scores` that `chosen` says."""

    key: AnyArray
    chosen: AnyArray
    scores: tuple[Score, ...] = field(metadata={"static": True})
    runs: int = field(metadata={"static": True})

    def __call__(self, z: Any) -> Any:
        self.tick(z, self.runs)
        return self.function(z)

    def function(self, z: Any) -> Any:
        """Without counting."""
        return jax.lax.switch(self.chosen, [lambda z, f=score: f(z).astype(z.dtype) for score in self.scores], z)

    def tick(self, z: Any, runs: int) -> None:
        """Count this many runs at z."""
        jax.debug.callback(partial(Meter.tick, count=runs), self.key, jnp.abs(z).max())


@register_pytree
@dataclass(frozen=True, eq=False)
class _Differentiable:
    """A counted function with a rule for its derivatives that counts them as well."""

    counted: _Counted
    rule: Callable[[_Counted, Any], Any] = field(metadata={"static": True})

    def __call__(self, z: Any) -> Any:
        return self.rule(self.counted, z)


def _evaluated(counted: _Counted, z: Any) -> Any:
    return counted(z)


def _with_gradient(counted: _Counted, z: Any) -> Any:
    return replace(counted, runs=z.shape[0] + 1)(z)


# As the real soft count: any derivative takes n forward derivatives. Of residuals, any derivative counts as a Jacobian.
_soft_count = forward_gradient(_evaluated, _with_gradient)
_residuals = jax.custom_jvp(_evaluated)


@_residuals.defjvp
def _jacobian(primals: tuple, tangents: tuple) -> tuple[jax.Array, jax.Array]:
    (counted, z), (_, direction) = primals, tangents
    counted.tick(z, z.shape[0] + 1)  # once for all directions: z has no batch axis
    return jax.jvp(counted.function, (z,), (direction,))


def _problem(
    dim: int,
    values: Score,
    soft: Score | None = None,
    residuals: Score | None = None,
    meter: Meter | None = None,
) -> Problem:
    meter = meter or Meter()

    def metered(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        meter.on_host += len(points)
        return np.asarray(values(points), float)

    def counted(score: Score) -> _Counted:
        group = next(scores for scores in (_SOFT, _SQUARE, (curved,)) if score in scores)
        return _Counted(jnp.asarray(meter.key, jnp.int32), jnp.asarray(group.index(score), jnp.int32), group, 1)

    traced = Traced(
        soft_count=_Differentiable(counted(soft), _soft_count) if soft else None,
        residuals=_Differentiable(counted(residuals), _residuals) if residuals else None,
    )
    return Problem(dim, metered, traced=traced)


def _summit(dim: int) -> Float[np.ndarray, "n"]:
    return np.linspace(-0.4, 0.3, dim) if dim > 1 else np.array([0.3])


def _bowl(z: AnyArray) -> AnyArray:
    return 1.0 - ((z - _summit(z.shape[-1])) ** 2).sum(-1)


def bowl(dim: int, meter: Meter | None = None) -> Problem:
    """A concave paraboloid; its maximum is 1."""
    return _problem(dim, _bowl, _bowl, meter=meter)


def staircase(dim: int) -> Problem:
    """The bowl in steps of 1/64: piecewise constant, as a count is. Its smooth score is the bowl itself."""
    return _problem(dim, lambda points: np.floor(64.0 * _bowl(points)) / 64.0, _bowl)


def _ridge(z: AnyArray) -> AnyArray:
    # Nearly flat along the diagonal, steep across it: parameters that compensate each other make such a ridge.
    offset = z - _summit(z.shape[-1])
    along = offset.mean(-1)
    across = ((offset - along[..., None]) ** 2).sum(-1)
    return 1.0 - 0.2 * along**2 - 2.0 * across


def tilted_ridge(dim: int) -> Problem:
    """A ridge along the diagonal, ten times as steep across as along."""
    return _problem(dim, _ridge, _ridge)


def _cliff(z: AnyArray) -> AnyArray:
    # Where a matcher finds nothing any more, the count drops to a plateau far below.
    xp = namespace(z)
    return xp.where(z[..., 0] < -0.2, -4.0, 1.0 - ((z - 0.25) ** 2).sum(-1))


def cliff(dim: int) -> Problem:
    """A bowl that drops to a plateau not far from the start."""
    return _problem(dim, _cliff, _cliff)


def noisy_bowl(dim: int) -> Problem:
    """The bowl with a fixed ripple of ±0.01, which makes many local maxima. Its soft count has no ripple."""

    def values(points: AnyArray) -> AnyArray:
        return _bowl(points) + 0.01 * np.sin(997.0 * points).mean(-1)

    return _problem(dim, values, _bowl)


def _pocket(z: AnyArray) -> AnyArray:
    xp = namespace(z)
    return xp.where(z[..., 0] > 0.1, xp.nan, _bowl(z))


def nan_pocket(dim: int) -> Problem:
    """The bowl with NaN on one side, close to the start."""
    return _problem(dim, _pocket, _pocket)


def _constant(z: AnyArray) -> AnyArray:
    return 1.0 + 0.0 * z.sum(-1)


def flat(dim: int) -> Problem:
    """The same value everywhere."""
    return _problem(dim, _constant, _constant)


def least_squares(residuals: Score, dim: int, meter: Meter | None = None) -> Problem:
    """Maximise -½ |residuals|²."""

    def values(points: AnyArray) -> AnyArray:
        return -0.5 * (np.asarray(residuals(points), float) ** 2).sum(-1)

    return _problem(dim, values, residuals=residuals, meter=meter)


def linear(z: AnyArray) -> AnyArray:
    """Linear residuals; zero at the maximum of `bowl`."""
    return z - _summit(z.shape[-1])


def curved(z: AnyArray) -> AnyArray:
    """The residuals of Rosenbrock's valley, extended over each pair of neighbours; zero at z = 0.5."""
    x = 2.0 * z
    xp = namespace(z)
    return xp.concatenate([1.0 - x, 3.0 * (x[..., 1:] - x[..., :-1] ** 2)], axis=-1)


def constant(z: AnyArray) -> AnyArray:
    """Residuals that do not depend on z."""
    return 0.0 * z + 1.0


def broken(z: AnyArray) -> AnyArray:
    """Linear residuals, with NaN on one side, close to the start."""
    xp = namespace(z)
    return xp.where(z[..., :1] > 0.1, xp.nan, linear(z))


_SOFT = (_bowl, _ridge, _cliff, _pocket, _constant)
_SQUARE = (linear, constant, broken)  # as many residuals as parameters
