"""The objective: what a strategy maximises, with its two faces and its meter."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._errors import NeedNotMet
from stereorecal.strategies._budget import Budget, Recorder, Trace
from stereorecal.strategies._need import Need

TracedFunction = Callable[[jax.Array], jax.Array]


@dataclass(frozen=True)
class Traced:
    """Pure JAX functions of a point z (n,) of the unit box; None where the objective has no such face.

    A function here may itself be a pytree that carries its data: pass it to a jitted function as an argument
    (`eqx.filter_jit`, or `jax.jit` where it has no static leaves), and objectives of equal shape share one program.

    Attributes:
        count: z -> (), the score that `Objective.value` returns on the host.
        soft_count: z -> (), its differentiable twin; reverse mode only, and a gradient costs `gradient_cost`.
        residuals: z -> (m,), for least squares; then the score is -½ |residuals|².
    """

    count: TracedFunction | None = None
    soft_count: TracedFunction | None = None
    residuals: TracedFunction | None = None


@dataclass(frozen=True)
class Problem:
    """A pure function to maximise over the unit box [-1, 1]^dim.

    Attributes:
        dim: n.
        values: (k, n) float64 -> (k,) float64, on the host.
        cost: units that one evaluation costs.
        traced: the traced face.
        images: what the score is computed from, for strategies that do not ask the score.
    """

    dim: int
    values: Callable[[Float[np.ndarray, "k n"]], Float[np.ndarray, "k"]]
    cost: float = 1.0
    traced: Traced = Traced()
    images: Any = None


class Objective:
    """A Problem with a meter: every evaluation is counted, recorded and refused once the budget is spent.

    Host face: `value`, `batch`. Traced face: `traced`, whose evaluations the strategy declares with `charge`.
    """

    def __init__(self, problem: Problem, budget: Budget | None = None) -> None:
        self.problem = problem
        self.budget = Budget() if budget is None else budget
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
        """Units that one value with its gradient (or one Jacobian of the residuals) costs: n + 1 evaluations, one
        forward derivative for each coordinate."""
        return (self.dim + 1) * self.cost

    @property
    def traced(self) -> Traced:
        """The pure JAX functions."""
        return self.problem.traced

    @property
    def images(self) -> Any:
        """The images and the calibration at the start, for strategies that need IMAGES."""
        return self.problem.images

    @property
    def remaining(self) -> float:
        """Units left in the budget."""
        return self._recorder.remaining

    @property
    def spent(self) -> float:
        """Units spent."""
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
        fits = self._recorder.affordable(len(points), self.cost)
        values = self.problem.values(points[:fits]) if fits else np.zeros(0)
        self._recorder.record(points[:fits], values, self.cost)
        self._recorder.raise_if_exhausted()
        return values

    def charge(self, cost: float, best: Float[np.ndarray, "n"]) -> None:
        """Declare work done through `traced`: its cost in units and the best point so far.

        Call it between steps, and `reserve` each step before it begins.

        Raises:
            BudgetExhausted: if nothing is left after it.
            ValueError: if the cost is negative or not finite.
        """
        if not 0 <= cost < np.inf:
            raise ValueError(f"a cost of {cost} units makes no sense")
        best = self._checked(np.asarray(best, float)[None])
        self._recorder.raise_if_exhausted()
        self._recorder.record(best, np.array([np.nan]), cost)
        if self._recorder.remaining <= 0:
            self._recorder.exhausted = True
            self._recorder.raise_if_exhausted()

    def reserve(self, cost: float) -> None:
        """Ask whether a step of `cost` units still fits, before it begins; it is paid by `charge` afterwards.

        Raises:
            BudgetExhausted: if it does not fit.
        """
        self._recorder.affordable(1, cost)
        self._recorder.raise_if_exhausted()

    def with_budget(self, budget: Budget) -> "Objective":
        """The same problem with a fresh meter."""
        return Objective(self.problem, budget)

    def missing(self, needs: Need) -> str | None:
        """Why this objective does not offer what is needed, or None if it does."""
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
            raise ValueError(f"points have shape {points.shape}, but the objective wants (k, {self.dim})")
        if not np.isfinite(points).all() or np.abs(points).max(initial=0.0) > 1.0 + 1e-9:
            raise ValueError("a point lies outside the unit box [-1, 1]^n")
        return points


def require(objective: Objective, needs: Need, name: str) -> None:
    """Raises NeedNotMet if the objective does not offer what strategy `name` needs."""
    if reason := objective.missing(needs):
        raise NeedNotMet(f"strategy {name} cannot serve here: {reason}.")
