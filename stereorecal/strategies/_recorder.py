"""The recorder: the evaluations of an objective, and their cost."""

import time
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from stereorecal._errors import BudgetExhausted
from stereorecal.strategies._budget import Budget
from stereorecal.strategies._evaluation_trace import ROUNDING, Trace


@dataclass
class Recorder:
    """Counts cost, watches the deadline and remembers every point: the only mutable state of a run.

    Attributes:
        budget: the limits.
        dim: number of coordinates of a point.
        spent: units spent so far.
        exhausted: whether the budget is used up. It never becomes False again.
    """

    budget: Budget
    dim: int
    spent: float = 0.0
    exhausted: bool = False
    _began: float = field(default_factory=time.perf_counter)
    _rows: list[tuple[np.ndarray, float, float, float]] = field(default_factory=list)

    def affordable(self, wanted: int, cost: float) -> int:
        """How many of `wanted` evaluations at `cost` units each still fit into the budget.

        If not all of them fit, the budget counts as exhausted from here on.
        """
        fits = wanted
        if self.exhausted or self._late():
            fits = 0
        elif self.budget.evaluations is not None and cost > 0:
            left = self.budget.evaluations * (1.0 + ROUNDING) - self.spent
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
        """Units left; infinite if the budget sets no limit on them."""
        if self.exhausted or self._late():
            return 0.0
        limit = self.budget.evaluations
        return np.inf if limit is None else max(0.0, limit - self.spent)

    def trace(self) -> Trace:
        """All evaluations recorded so far."""
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
