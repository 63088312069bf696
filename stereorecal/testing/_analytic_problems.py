"""Analytic problems on the unit box, each with one difficulty of real scores.

A problem has a host face and a traced face. The traced functions are pytrees that carry their data, which of a few
scores they are among it, so that one compiled program serves all problems of one dimension; and they count how often
and where they run: a strategy cannot hide evaluations inside JAX.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

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

    _all: ClassVar[list["Meter"]] = []  # by their keys: the callbacks of compiled programs look them up

    def __init__(self) -> None:
        self.on_host, self._traced, self._farthest = 0, 0, 0.0
        self.key = len(Meter._all)
        Meter._all.append(self)

    @property
    def total(self) -> int:
        """Evaluations so far; a value with its gradient, or residuals with their Jacobian, count n + 1."""
        jax.effects_barrier()
        return self.on_host + self._traced

    @property
    def farthest(self) -> float:
        """The largest absolute coordinate at which a traced function was evaluated."""
        jax.effects_barrier()
        return self._farthest

    @staticmethod
    def tick(key: AnyArray, coordinate: AnyArray, count: int) -> None:
        """Called from inside compiled programs."""
        meter = Meter._all[int(key)]
        meter._traced += count
        meter._farthest = max(meter._farthest, float(coordinate))


@register_pytree
@dataclass(frozen=True, eq=False)
class _Counted:
    """A traced function, the one of `scores` that `chosen` says, with a `rule` that counts its runs and derivatives."""

    key: AnyArray
    chosen: AnyArray
    scores: tuple[Score, ...] = field(metadata={"static": True})
    rule: Callable[["_Counted", Any], Any] = field(metadata={"static": True})

    def __call__(self, z: Any) -> Any:
        return self.rule(self, z)

    def function(self, z: Any) -> Any:
        """The value, without counting."""
        return jax.lax.switch(self.chosen, [lambda z, f=score: f(z).astype(z.dtype) for score in self.scores], z)

    def tick(self, z: Any, runs: int) -> None:
        """Count this many runs at z."""
        jax.debug.callback(partial(Meter.tick, count=runs), self.key, jnp.abs(z).max())


def _evaluated(counted: _Counted, z: Any) -> Any:
    counted.tick(z, 1)
    return counted.function(z)


def _with_gradient(counted: _Counted, z: Any) -> Any:
    counted.tick(z, z.shape[0] + 1)
    return counted.function(z)


# As the real soft count: any derivative takes n forward derivatives. Of residuals, any derivative counts as a Jacobian.
_soft_count = forward_gradient(_evaluated, _with_gradient)
_residuals = jax.custom_jvp(_evaluated)


@_residuals.defjvp
def _jacobian(primals: tuple, tangents: tuple) -> tuple[jax.Array, jax.Array]:
    (counted, z), (_, direction) = primals, tangents
    counted.tick(z, z.shape[0] + 1)  # once for all directions: z has no batch axis
    return jax.jvp(counted.function, (z,), (direction,))


def problem(score: Score, dim: int, meter: Meter | None = None) -> Problem:
    """Maximise a score of this module; of residuals, -½ |residuals|²."""
    meter = meter or Meter()
    smooth = _SMOOTH.get(score, score)
    group = next(scores for scores in (_SCORES, _RESIDUALS, (curved,)) if smooth in scores)

    def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        meter.on_host += len(points)
        found = np.asarray(score(points), float)
        return found if group is _SCORES else -0.5 * (found**2).sum(-1)

    key, chosen = (jnp.asarray(number, jnp.int32) for number in (meter.key, group.index(smooth)))
    if group is _SCORES:
        return Problem(dim, values, traced=Traced(soft_count=_Counted(key, chosen, group, _soft_count)))
    return Problem(dim, values, traced=Traced(residuals=_Counted(key, chosen, group, _residuals)))


def _summit(dim: int) -> Float[np.ndarray, "n"]:
    return np.linspace(-0.4, 0.3, dim) if dim > 1 else np.array([0.3])


def bowl(z: AnyArray) -> AnyArray:
    """A concave paraboloid; its maximum is 1."""
    return 1.0 - ((z - _summit(z.shape[-1])) ** 2).sum(-1)


def staircase(z: np.ndarray) -> np.ndarray:
    """The bowl in steps of 1/64: piecewise constant, as a count is."""
    return np.floor(64.0 * bowl(z)) / 64.0


def tilted_ridge(z: AnyArray) -> AnyArray:
    """A ridge along the diagonal, ten times as steep across, as of parameters that compensate each other."""
    offset = z - _summit(z.shape[-1])
    along = offset.mean(-1)
    across = ((offset - along[..., None]) ** 2).sum(-1)
    return 1.0 - 0.2 * along**2 - 2.0 * across


def cliff(z: AnyArray) -> AnyArray:
    """A bowl that drops to a plateau not far from the start, as the count does where a matcher finds nothing."""
    return namespace(z).where(z[..., 0] < -0.2, -4.0, 1.0 - ((z - 0.25) ** 2).sum(-1))


def noisy_bowl(z: np.ndarray) -> np.ndarray:
    """The bowl with a fixed ripple of ±0.01, which makes many local maxima."""
    return bowl(z) + 0.01 * np.sin(997.0 * z).mean(-1)


def nan_pocket(z: AnyArray) -> AnyArray:
    """The bowl with NaN on one side, close to the start."""
    xp = namespace(z)
    return xp.where(z[..., 0] > 0.1, xp.nan, bowl(z))


def flat(z: AnyArray) -> AnyArray:
    """The same value everywhere."""
    return 1.0 + 0.0 * z.sum(-1)


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


AS_RESIDUALS: dict[Score, Score] = {bowl: linear, nan_pocket: broken, flat: constant}
"""The residuals with the same difficulty as a score."""

_SMOOTH: dict[Score, Score] = {staircase: bowl, noisy_bowl: bowl}  # whose soft count a rough score has
_SCORES: tuple[Score, ...] = (bowl, tilted_ridge, cliff, nan_pocket, flat)
_RESIDUALS: tuple[Score, ...] = (linear, constant, broken)  # as many as parameters
