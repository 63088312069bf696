"""The objective: the function that a strategy maximises, on the host and in JAX, with a budget and a record of every
evaluation; and what strategies need of it."""

import enum
import reprlib
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._errors import BudgetExhausted, InputError

if TYPE_CHECKING:
    import jax  # which takes time to import, and names of strategies do not need

_ROUNDING = 1e-9  # of a sum of costs: those such as 0.09 are not exact in binary
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


@dataclass(frozen=True)
class Budget:
    """How much a strategy may spend; None means no limit.

    Attributes:
        evaluations: in units of one matcher run on one full-size frame. A candidate at image scale s over k frames
            costs k s² units.
        seconds: wall-clock time. A run that this limit cuts short is not repeatable.

    Raises:
        InputError: if a limit is not a finite positive number.
    """

    evaluations: float | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        for name, limit in (("evaluations", self.evaluations), ("seconds", self.seconds)):
            if limit is not None and not (_is_number(limit) and 0 < limit <= sys.float_info.max):
                raise InputError(
                    f"the budget of {reprlib.repr(limit)} {name} makes no sense; "
                    "give a positive number, or None for no limit."
                )


def as_budget(value: Any) -> Budget:
    """`value` as a Budget: None is no limit, a number is a limit on `evaluations`, a Budget is returned as it is.

    Raises:
        InputError: if it is anything else, or a number that is not positive.
    """
    if value is None:
        return Budget()
    if isinstance(value, Budget):
        return value
    if isinstance(value, np.generic):
        value = value.item()
    if _is_number(value):
        return Budget(evaluations=None if value == np.inf else value)
    raise InputError(
        f"budget is {reprlib.repr(value)}; give a number of units, such as budget=500, "
        "or sr.Budget(evaluations=500, seconds=20)."
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


@dataclass(frozen=True, eq=False)
class Trace:
    """All evaluations of a run, in order.

    Attributes:
        points: (m, n) float64, in the unit box.
        values: (m,) float64; NaN where a strategy charged for work inside JAX, which reports no value.
        cost: (m,) float64, units spent up to and including each evaluation.
        seconds: (m,) float64, since the start of the run.
        evaluations: (m,) int64, index of each evaluation, from 1; a charge counts as one evaluation.
    """

    points: Float[np.ndarray, "m n"]
    values: Float[np.ndarray, "m"]
    cost: Float[np.ndarray, "m"]
    seconds: Float[np.ndarray, "m"]
    evaluations: Int[np.ndarray, "m"]

    @property
    def total_cost(self) -> float:
        """Units spent in total."""
        return float(self.cost[-1]) if len(self.cost) else 0.0

    def best_within(self, cost: float) -> float | None:
        """The highest value among the first `cost` units, or None if there was none."""
        values = self.values[self.cost <= cost * (1.0 + _ROUNDING)]
        return float(np.nanmax(values)) if np.isfinite(values).any() else None

    def charged_within(self, cost: float) -> Float[np.ndarray, "n"] | None:
        """The last point that was charged for without a value among the first `cost` units, or None."""
        points = self.points[(self.cost <= cost * (1.0 + _ROUNDING)) & np.isnan(self.values)]
        return points[-1] if len(points) else None


class Objective:
    """A Problem with a budget: every evaluation is counted, recorded, and refused once the budget is spent.

    Host face: `value`, `batch`. Traced face: `traced`, whose evaluations the strategy declares with `charge`.

    Args:
        budget: what may be spent: a Budget, a number of units, or None for no limit.
    """

    def __init__(self, problem: Problem, budget: Budget | float | None = None) -> None:
        self.problem = problem
        self.budget = as_budget(budget)
        self._began = time.perf_counter()
        self._exhausted = False  # once it is, it stays so
        self._rows: list[tuple[np.ndarray, float, float, float]] = []  # of the trace, without the index

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
        if self._exhausted or self._is_late():
            return 0.0
        limit = self.budget.evaluations
        return np.inf if limit is None else max(0.0, limit - self.spent)

    @property
    def spent(self) -> float:
        """Units spent so far."""
        return self._rows[-1][2] if self._rows else 0.0

    @property
    def trace(self) -> Trace:
        """All evaluations so far."""
        points, values, cost, seconds = zip(*self._rows, strict=True) if self._rows else ((), (), (), ())
        return Trace(
            np.array(points, float).reshape(-1, self.dim),
            np.array(values, float),
            np.array(cost, float),
            np.array(seconds, float),
            np.arange(1, len(values) + 1),
        )

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
            fits = self._affordable(len(part), self.cost)
            values.append(self.problem.values(part[:fits]) if fits else np.zeros(0))
            self._record(part[:fits], values[-1], self.cost)
            self._raise_if_exhausted()
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
        self._raise_if_exhausted()
        self._record(best, np.array([np.nan]), cost)
        self._exhausted = self.remaining <= 0
        self._raise_if_exhausted()

    def reserve(self, cost: float) -> None:
        """Make sure that a step of `cost` units still fits into the budget. Spends nothing: `charge` does, afterwards.

        Raises:
            BudgetExhausted: if it does not fit.
        """
        self._affordable(1, cost)
        self._raise_if_exhausted()

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

    def _affordable(self, wanted: int, cost: float) -> int:
        """How many of `wanted` evaluations at `cost` units each still fit; if not all do, the budget is exhausted."""
        fits = wanted
        if self._exhausted or self._is_late():
            fits = 0
        elif self.budget.evaluations is not None and cost > 0:
            left = self.budget.evaluations * (1.0 + _ROUNDING) - self.spent
            fits = int(min(wanted, max(0.0, left) // cost))
        self._exhausted = self._exhausted or fits < wanted
        return fits

    def _record(self, points: Float[np.ndarray, "k n"], values: Float[np.ndarray, "k"], cost: float) -> None:
        seconds = time.perf_counter() - self._began
        for point, value in zip(points, values, strict=True):
            self._rows.append((np.array(point, float), float(value), self.spent + cost, seconds))

    def _raise_if_exhausted(self) -> None:
        if self._exhausted:
            raise BudgetExhausted

    def _is_late(self) -> bool:
        return self.budget.seconds is not None and time.perf_counter() - self._began >= self.budget.seconds
