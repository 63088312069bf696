"""Levenberg-Marquardt on the host, for problems of a few residuals: it compiles nothing and imports NumPy alone."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome, Status

_DIFFERENCE = 1e-3  # half widths of the box: long enough for residuals in float32, exact for linear ones
_LESS, _MORE = 1.0 / 10.0, 10.0  # damping after a better, and after a worse point
_MOST = 1e10  # damping: steps are then nothing


class _Look(NamedTuple):
    """The residuals and their Jacobian at a point."""

    point: Float[np.ndarray, "n"]
    residuals: Float[np.ndarray, "m"]
    jacobian: Float[np.ndarray, "m n"]

    @property
    def value(self) -> float:
        """-½ |residuals|², -inf where they are not finite."""
        value = -0.5 * float(self.residuals @ self.residuals)
        return value if np.isfinite(value) and np.isfinite(self.jacobian).all() else -np.inf


@dataclass(frozen=True)
class LevenbergMarquardt(AbstractStrategy):
    """Levenberg-Marquardt on the residuals, in NumPy: Gauss-Newton with adaptive damping, inside the box.

    Marquardt (1963), damped along the diagonal of JᵀJ. A coordinate at a wall of the box stays there while the step
    would leave. The Jacobian is of finite differences, n + 1 evaluations with the residuals.

    Attributes:
        damping: the first, relative to the diagonal of JᵀJ; choose 1 or more where the start is poor.
        tolerance: the search ends when a step would change the residuals, as a vector, by less than this. Where they
            are in standard deviations, so is it.
        steps: the most Jacobians after the first.
    """

    damping: float = 1e-6
    tolerance: float = 1e-3
    steps: int = 50

    needs: ClassVar[Need] = Need.RESIDUALS

    def __post_init__(self) -> None:
        if not (self.damping > 0 and self.tolerance > 0 and self.steps > 0):
            raise ValueError(f"need damping, tolerance and steps above 0, got {self}")

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        here, damping = _look(objective, start), self.damping
        objective.charge(objective.gradient_cost, here.point)
        if not np.isfinite(here.value):
            return Outcome(start, Status.STALLED, "the residuals at the start are not finite")
        for _ in range(self.steps):
            step = _step(here, damping)
            if damping > _MOST or np.linalg.norm(here.jacobian @ step) < self.tolerance:
                return Outcome(here.point, Status.CONVERGED)
            there = _look(objective, np.clip(here.point + step, -1.0, 1.0))
            if there.value > here.value:
                here, damping = there, max(damping * _LESS, np.finfo(float).tiny)
            else:
                damping *= _MORE
            objective.charge(objective.gradient_cost, here.point)
        return Outcome(here.point, Status.STALLED)


def _look(objective: Objective, point: Float[np.ndarray, "n"]) -> _Look:
    """Residuals and Jacobian at a point."""
    residuals = objective.traced.residuals
    assert residuals is not None  # the core has checked it
    objective.reserve(objective.gradient_cost)
    steps = np.where(point > 0, -_DIFFERENCE, _DIFFERENCE)  # towards the middle: never out of the box
    here, *there = (np.asarray(residuals(p), float) for p in (point, *(point + np.diag(steps))))
    return _Look(point, here, np.stack([(t - here) / s for t, s in zip(there, steps, strict=True)], axis=-1))


def _step(here: _Look, damping: float) -> Float[np.ndarray, "n"]:
    """The damped Gauss-Newton step along the coordinates that no wall holds."""
    gradient, normal = here.jacobian.T @ here.residuals, here.jacobian.T @ here.jacobian
    free = (np.abs(here.point) < 1.0) | (gradient * here.point > 0.0)
    free &= np.diag(normal) > 0.0
    step = np.zeros_like(here.point)
    damped = normal[np.ix_(free, free)] + damping * np.diag(np.diag(normal)[free])
    step[free] = -np.linalg.lstsq(damped, gradient[free], rcond=None)[0]
    return step
