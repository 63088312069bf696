"""Gradient descent and a secant method on finite differences, which Muhovič & Perš tried first (section 3.3).

The count is piecewise constant, so over a short distance it does not change at all: finite differences have to be long.
The step length comes from a line search, so the scale of the score does not matter. An iteration is two batches: the
points of the finite differences, and those of the line search.
"""

import abc
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome, Status

Point = Float[np.ndarray, "n"]
Curvature = Float[np.ndarray, "n n"]

# Curvature condition of the BFGS update: least cosine of the angle between a move and the fall of the gradient over it.
# Our choice; it keeps the update well conditioned and rejects moves along which the score is not concave.
_LEAST_COSINE = 1e-3


@dataclass(frozen=True)
class AbstractAscent(AbstractStrategy):
    """Ascent along a central-difference gradient, preconditioned by an estimate of the inverse Hessian if there is one.

    Attributes:
        difference: half the distance between the two points of a difference, in half widths of the search box. The
            default is 0.09 degrees at the default reach; over less, a count hardly changes.
        step: longest step, in half widths.
        min_step: the search ends when no step of at least this length improves the score.
    """

    difference: float = 1.0 / 32.0
    step: float = 1.0 / 8.0
    min_step: float = 1.0 / 128.0

    def __post_init__(self) -> None:
        if not 0.0 < self.difference <= 1.0:
            raise ValueError(f"need 0 < difference <= 1, got {self.difference}")
        if not 0.0 < self.min_step <= self.step <= 2.0:
            raise ValueError(f"need 0 < min_step <= step <= 2, got {self.min_step} and {self.step}")

    @abc.abstractmethod
    def learned(self, inverse: Curvature | None, move: Point, fall: Point) -> Curvature | None:
        """The new estimate of the inverse of minus the Hessian, after `move`, along which the gradient fell by `fall`.

        None stands for no estimate, both as `inverse` and as the result.
        """

    def run(self, objective: Objective, start: Point, seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        point, value = start, _comparable(objective.value(start))
        gradient, inverse = _gradient(objective, start, self.difference), None
        while True:
            there, value_there = self._best_along(_uphill(point, gradient, inverse), objective, point, inverse is None)
            if value_there > value:
                move, before = there - point, gradient
                point, value, gradient = there, value_there, _gradient(objective, there, self.difference)
                inverse = self.learned(inverse, move, before - gradient)
            elif inverse is None:
                return Outcome(_best_seen(objective, start), Status.CONVERGED)
            else:
                inverse = None  # perhaps the estimate is wrong: try again along the plain gradient

    def _best_along(self, direction: Point, objective: Objective, point: Point, unscaled: bool) -> tuple[Point, float]:
        """The best point of a line search along `direction` and its value; steps are halved from the longest on."""
        length = np.linalg.norm(direction)
        longest = self.step if unscaled else min(self.step, length)
        if length == 0.0 or longest < self.min_step:
            return point, -np.inf
        halvings = np.arange(int(np.log2(longest / self.min_step) + 1e-9) + 1)
        points = np.clip(point + longest * 0.5 ** halvings[:, None] * direction / length, -1.0, 1.0)
        values = _comparable(objective.batch(points))
        return points[np.argmax(values)], float(np.max(values))


@dataclass(frozen=True)
class GradientDescent(AbstractAscent):
    """Gradient descent (paper): steepest ascent of the score on central differences, with a line search.

    Attributes: those of `AbstractAscent`.
    """

    def learned(self, inverse: Curvature | None, move: Point, fall: Point) -> Curvature | None:
        """None: it uses no curvature."""
        return None


@dataclass(frozen=True)
class Secant(AbstractAscent):
    """Secant method (paper): BFGS quasi-Newton directions on central differences, with a line search.

    Where such a direction brings no improvement, the estimate is discarded and the search goes on along the gradient.

    Attributes: those of `AbstractAscent`.
    """

    def learned(self, inverse: Curvature | None, move: Point, fall: Point) -> Curvature | None:
        """The BFGS update, where the curvature condition holds."""
        curvature = move @ fall
        if not curvature > _LEAST_COSINE * np.linalg.norm(move) * np.linalg.norm(fall):
            return inverse
        identity = np.eye(len(move))
        if inverse is None:
            inverse = identity * curvature / (fall @ fall)
        left = identity - np.outer(move, fall) / curvature
        return left @ inverse @ left.T + np.outer(move, move) / curvature


def _gradient(objective: Objective, point: Point, difference: float) -> Point:
    """The gradient by central differences, one-sided at the border of the box; all 2n points are one batch."""
    shifts = difference * np.eye(objective.dim)
    ahead, behind = np.clip(point + shifts, -1.0, 1.0), np.clip(point - shifts, -1.0, 1.0)
    values = objective.batch(np.concatenate([ahead, behind]))
    values = np.where(np.isnan(values), np.min(values, initial=np.inf, where=~np.isnan(values)), values)
    if not np.isfinite(values).all():  # no value at any of the points
        return np.zeros(objective.dim)
    rise = values[: objective.dim] - values[objective.dim :]
    return rise / np.diagonal(ahead - behind)


def _uphill(point: Point, gradient: Point, inverse: Curvature | None) -> Point:
    """The direction of ascent: the gradient, preconditioned by `inverse`, without components that leave the box."""
    inside = (np.abs(point) < 1.0) | (gradient * point < 0.0)
    straight = np.where(inside, gradient, 0.0)
    return straight if inverse is None else np.where(inside, inverse @ straight, 0.0)


def _best_seen(objective: Objective, start: Point) -> Point:
    trace = objective.trace
    return trace.points[np.nanargmax(trace.values)] if np.isfinite(trace.values).any() else start


def _comparable(values):
    """The values, with NaN replaced by -inf: worse than any value."""
    return np.where(np.isnan(values), -np.inf, values)
