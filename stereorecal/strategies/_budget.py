"""Budgets, and the record of what an objective was asked."""

import time
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from stereorecal._errors import BudgetExhausted, InputError

# Sums of costs like 0.09 are not exact in binary; relative to the sum.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Budget:
    """How much a strategy may spend; None means no limit.

    Attributes:
        evaluations: in units of one matcher run on one full-size frame. A candidate at image scale s over k frames
            costs k s².
        seconds: wall time. A run that this cuts short is not repeatable.

    Raises:
        InputError: if a limit is not a positive number.
    """

    evaluations: float | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        for name, limit in (("evaluations", self.evaluations), ("seconds", self.seconds)):
            if limit is not None and not limit > 0:
                raise InputError(f"the budget of {limit} {name} makes no sense; give a positive number.")


@dataclass(frozen=True, eq=False)
class Trace:
    """All evaluations of a run, in order.

    Attributes:
        points: (m, n) float64, unit box.
        values: (m,) float64; NaN where a strategy charged for work inside JAX without a value.
        cost: (m,) float64, units spent up to and including each evaluation.
        seconds: (m,) float64, since the start of the run.
        evaluations: (m,) int64, index of the evaluation, from 1; work that was charged counts as one.
    """

    points: Float[np.ndarray, "m n"]
    values: Float[np.ndarray, "m"]
    cost: Float[np.ndarray, "m"]
    seconds: Float[np.ndarray, "m"]
    evaluations: Int[np.ndarray, "m"]

    @property
    def total_cost(self) -> float:
        """Units spent in all."""
        return float(self.cost[-1]) if len(self.cost) else 0.0

    def best_within(self, cost: float) -> float | None:
        """The best value seen by the time that `cost` units were spent, None if there was none."""
        values = self.values[self.cost <= cost * (1.0 + _ROUNDING)]
        return float(np.nanmax(values)) if np.isfinite(values).any() else None

    def charged_within(self, cost: float) -> Float[np.ndarray, "n"] | None:
        """The last best point that was declared without a value by the time that `cost` units were spent, if any."""
        points = self.points[(self.cost <= cost * (1.0 + _ROUNDING)) & np.isnan(self.values)]
        return points[-1] if len(points) else None


@dataclass
class Recorder:
    """Counts cost, watches the deadline and remembers every point. The only state of a run."""

    budget: Budget
    dim: int
    spent: float = 0.0
    exhausted: bool = False
    _began: float = field(default_factory=time.perf_counter)
    _rows: list[tuple[np.ndarray, float, float, float]] = field(default_factory=list)

    def affordable(self, wanted: int, cost: float) -> int:
        """How many of `wanted` evaluations of `cost` units each still fit; marks the budget as used up at the first
        that does not."""
        fits = wanted
        if self.exhausted or self._late():
            fits = 0
        elif self.budget.evaluations is not None and cost > 0:
            left = self.budget.evaluations * (1.0 + _ROUNDING) - self.spent
            fits = int(min(wanted, max(0.0, left) // cost))
        self.exhausted = self.exhausted or fits < wanted
        return fits

    def record(self, points: Float[np.ndarray, "k n"], values: Float[np.ndarray, "k"], cost: float) -> None:
        """Add evaluations of `cost` units each."""
        seconds = time.perf_counter() - self._began
        for point, value in zip(points, values, strict=True):
            self.spent += cost
            self._rows.append((np.array(point, float), float(value), self.spent, seconds))

    def raise_if_exhausted(self) -> None:
        """Raises BudgetExhausted once the budget is used up."""
        if self.exhausted:
            raise BudgetExhausted

    @property
    def remaining(self) -> float:
        """Units left; infinite without a limit."""
        if self.exhausted or self._late():
            return 0.0
        limit = self.budget.evaluations
        return np.inf if limit is None else max(0.0, limit - self.spent)

    def trace(self) -> Trace:
        """What was recorded so far."""
        points, values, cost, seconds = zip(*self._rows, strict=True) if self._rows else ((), (), (), ())
        return Trace(
            np.array(points, float).reshape(-1, self.dim),
            np.array(values, float),
            np.array(cost, float),
            np.array(seconds, float),
            np.arange(1, len(values) + 1),
        )

    def _late(self) -> bool:
        return self.budget.seconds is not None and time.perf_counter() - self._began >= self.budget.seconds
