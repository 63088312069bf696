"""The objective: the function that a strategy maximises, on the host and in JAX, with a budget; and what strategies
need of it."""

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from stereorecal.strategies._budget import Budget, as_budget
from stereorecal.strategies._evaluation_trace import Trace
from stereorecal.strategies._recorder import Recorder

if TYPE_CHECKING:
    import jax  # which takes time to import, and names of strategies do not need

_CLOCK_INTERVAL = 16  # points between two checks of the clock, where a limit in seconds holds

TracedFunction = Callable[["jax.Array"], "jax.Array"]


class Need(enum.Enum):
    """What a strategy needs of an objective; the value says where it is."""

    HOST = "values on the host: `objective.value` and `objective.batch` (every objective has them)"
    SMOOTH = "a differentiable score: `objective.traced.soft_count`"
    RESIDUALS = "least-squares residuals: `objective.traced.residuals`"
    IMAGES = "the images themselves: `objective.images`"


@dataclass(frozen=True)
class Traced:
    """Pure JAX functions of a point z (n,) of the unit box; None where the objective has no such face.

    A function here may itself be a pytree that carries its data: pass it to a jitted function as an argument
    (`eqx.filter_jit`, or `jax.jit` where it has no static leaves), and objectives of equal shape share one program.

    Attributes:
        count: z -> (), the score that `Objective.value` returns on the host.
        soft_count: z -> (), its differentiable approximation, in forward and in reverse mode; a value with its gradient
            costs `Objective.gradient_cost`.
        residuals: z -> (m,), for least squares; the score is then -½ |residuals|². Takes NumPy points as well.
    """

    count: TracedFunction | None = None
    soft_count: TracedFunction | None = None
    residuals: Callable[[Any], Any] | None = None


@dataclass(frozen=True)
class Problem:
    """A pure function to maximise over the unit box [-1, 1]^dim.

    Attributes:
        dim: number of coordinates of a point, n.
        values: (k, n) float64 -> (k,) float64, on the host.
        cost: units that one evaluation costs.
        traced: the same function in JAX, as far as it exists.
        images: the data behind the score, for strategies that work on the data directly (Need.IMAGES).
    """

    dim: int
    values: Callable[[Float[np.ndarray, "k n"]], Float[np.ndarray, "k"]]
    cost: float = 1.0
    traced: Traced = Traced()
    images: Any = None


class Objective:
    """A Problem with a budget: every evaluation is counted, recorded, and refused once the budget is spent.

    Host face: `value`, `batch`. Traced face: `traced`, whose evaluations the strategy declares with `charge`.

    Args:
        budget: what may be spent: a Budget, a number of units, or None for no limit.
    """

    def __init__(self, problem: Problem, budget: Budget | float | None = None) -> None:
        self.problem = problem
        self.budget = as_budget(budget)
        self._recorder = Recorder(self.budget, problem.dim)

    @property
    def dim(self) -> int:
        """n, the number of coordinates of a point."""
        return self.problem.dim

    @property
    def cost(self) -> float:
        """Units that one evaluation costs."""
        return self.problem.cost

    @property
    def gradient_cost(self) -> float:
        """Units that a value with its gradient, or residuals with their Jacobian, cost: n + 1 evaluations, since there
        is one forward derivative for each coordinate."""
        return (self.dim + 1) * self.cost

    @property
    def traced(self) -> Traced:
        """The pure JAX functions."""
        return self.problem.traced

    @property
    def images(self) -> Any:
        """The data behind the score, for strategies that need IMAGES; None where there is none."""
        return self.problem.images

    @property
    def remaining(self) -> float:
        """Units left in the budget; infinite without a limit, 0 once the time is up."""
        return self._recorder.remaining

    @property
    def spent(self) -> float:
        """Units spent so far."""
        return self._recorder.spent

    @property
    def trace(self) -> Trace:
        """All evaluations so far."""
        return self._recorder.trace()

    def value(self, z: Float[np.ndarray, "n"]) -> float:
        """The score at one point, a Python float. Raises BudgetExhausted once the budget is spent."""
        return float(self.batch(np.asarray(z, float)[None])[0])

    def batch(self, points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        """The scores of k points.

        A batch that does not fit into the budget is evaluated as far as it fits, recorded, and then raises
        BudgetExhausted; so does every later call, without evaluating anything.

        Raises:
            ValueError: if a point lies outside the unit box or is not finite.
        """
        points = self._checked(points)
        values = [np.zeros(0)]
        size = max(1, len(points) if self.budget.seconds is None else _CLOCK_INTERVAL)
        for part in (points[first : first + size] for first in range(0, max(1, len(points)), size)):
            fits = self._recorder.affordable(len(part), self.cost)
            values.append(self.problem.values(part[:fits]) if fits else np.zeros(0))
            self._recorder.record(part[:fits], values[-1], self.cost)
            self._recorder.raise_if_exhausted()
        return np.concatenate(values)

    def charge(self, cost: float, best: Float[np.ndarray, "n"]) -> None:
        """Declare work done through `traced`: its cost in units and the best point so far.

        Call it after each step; call `reserve` before the step begins.

        Raises:
            BudgetExhausted: if nothing is left after it.
            ValueError: if the cost is negative or not finite.
        """
        if not 0 <= cost < np.inf:
            raise ValueError(f"a cost of {cost} units makes no sense; it is a finite number, 0 or more")
        best = self._checked(np.asarray(best, float)[None])
        self._recorder.raise_if_exhausted()
        self._recorder.record(best, np.array([np.nan]), cost)
        if self._recorder.remaining <= 0:
            self._recorder.exhausted = True
            self._recorder.raise_if_exhausted()

    def reserve(self, cost: float) -> None:
        """Make sure that a step of `cost` units still fits into the budget. Spends nothing: `charge` does, afterwards.

        Raises:
            BudgetExhausted: if it does not fit.
        """
        self._recorder.affordable(1, cost)
        self._recorder.raise_if_exhausted()

    def with_budget(self, budget: Budget | float | None) -> "Objective":
        """The same problem with another budget, of which nothing is spent yet, and an empty trace."""
        return Objective(self.problem, budget)

    def missing(self, needs: Need) -> str | None:
        """Why this objective does not meet `needs`, or None if it does."""
        if needs is Need.SMOOTH and self.traced.soft_count is None:
            return "it needs a differentiable score, which this objective does not offer (JAX matchers only)"
        if needs is Need.RESIDUALS and self.traced.residuals is None:
            return "it needs least-squares residuals, which this objective does not offer"
        if needs is Need.IMAGES and self.images is None:
            return "it needs the images, which this objective does not offer"
        return None

    def _checked(self, points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k n"]:
        points = np.array(points, float)
        if points.ndim != 2 or points.shape[1] != self.dim:
            raise ValueError(f"points have shape {points.shape}, but this objective takes (k, {self.dim})")
        if not np.isfinite(points).all() or np.abs(points).max(initial=0.0) > 1.0 + 1e-9:
            raise ValueError("a point lies outside the unit box [-1, 1]^n")
        return points
