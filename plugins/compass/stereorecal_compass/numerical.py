"""What the paper tried before compass search (section 3.3): gradient descent and a secant method, on differences.

The count is piecewise constant: over a short distance it does not change at all. So differences are long, and a step is
as long as pays off along the line, whatever the scale of the score. An iteration is two batches: all points of the
derivative, and all steps along the line.
"""

import abc
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Budget, Objective, Outcome, Status

Point = Float[np.ndarray, "n"]
Curvature = Float[np.ndarray, "n n"]

# The gradient has to fall along a move, or it says nothing about a summit: least cosine of the two.
_LEAST_BEND = 1e-3


@dataclass(frozen=True)
class AbstractAscent(AbstractStrategy):
    """Climbing along a gradient of central differences, bent by what is known of the curvature.

    Attributes:
        difference: half the length of a difference, in half widths of the search box (1/32 is 0.09 degrees at the
            default reach; a count shows little below that).
        step: longest step, in half widths.
        min_step: the search ends when no step down to this one climbs.
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
        """The inverse of minus the Hessian after a move, over which the gradient fell by `fall`; None: not known."""

    def run(self, objective: Objective, start: Point, budget: Budget, seed: int) -> Outcome:
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
                inverse = None  # the estimate may be at fault: once more, straight along the gradient

    def _best_along(self, direction: Point, objective: Objective, point: Point, unscaled: bool) -> tuple[Point, float]:
        """The best of the steps along `direction` that are halved from the longest down to the shortest."""
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
    """Gradient descent on central differences: the best of halved steps along the steepest way, until none climbs.

    Attributes: those of `AbstractAscent`.
    """

    def learned(self, inverse: Curvature | None, move: Point, fall: Point) -> Curvature | None:
        """Nothing."""
        return None


@dataclass(frozen=True)
class Secant(AbstractAscent):
    """A secant (quasi-Newton) method on central differences: as gradient descent, but along the way that BFGS points.

    Where that way does not climb, it forgets what it has learned and goes on along the gradient.

    Attributes: those of `AbstractAscent`.
    """

    def learned(self, inverse: Curvature | None, move: Point, fall: Point) -> Curvature | None:
        """The BFGS update, where the gradient falls along the move."""
        bend = move @ fall
        if not bend > _LEAST_BEND * np.linalg.norm(move) * np.linalg.norm(fall):
            return inverse
        identity = np.eye(len(move))
        if inverse is None:
            inverse = identity * bend / (fall @ fall)
        turned = identity - np.outer(move, fall) / bend
        return turned @ inverse @ turned.T + np.outer(move, move) / bend


def _gradient(objective: Objective, point: Point, difference: float) -> Point:
    """Central differences, one-sided where the box ends; all 2n points are one batch."""
    shifts = difference * np.eye(objective.dim)
    ahead, behind = np.clip(point + shifts, -1.0, 1.0), np.clip(point - shifts, -1.0, 1.0)
    values = objective.batch(np.concatenate([ahead, behind]))
    values = np.where(np.isnan(values), np.min(values, initial=np.inf, where=~np.isnan(values)), values)
    if not np.isfinite(values).all():  # no value anywhere
        return np.zeros(objective.dim)
    rise = values[: objective.dim] - values[objective.dim :]
    return rise / np.diagonal(ahead - behind)


def _uphill(point: Point, gradient: Point, inverse: Curvature | None) -> Point:
    """Gradient, bent by the inverse curvature, without the components that lead out of the box."""
    inside = (np.abs(point) < 1.0) | (gradient * point < 0.0)
    straight = np.where(inside, gradient, 0.0)
    return straight if inverse is None else np.where(inside, inverse @ straight, 0.0)


def _best_seen(objective: Objective, start: Point) -> Point:
    trace = objective.trace
    return trace.points[np.nanargmax(trace.values)] if np.isfinite(trace.values).any() else start


def _comparable(values):
    """NaN counts as worse than anything."""
    return np.where(np.isnan(values), -np.inf, values)
