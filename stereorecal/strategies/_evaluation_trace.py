"""The trace: every evaluation of a run."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

# Sums of costs such as 0.09 are not exact in binary; relative to the sum.
ROUNDING = 1e-9


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
        values = self.values[self.cost <= cost * (1.0 + ROUNDING)]
        return float(np.nanmax(values)) if np.isfinite(values).any() else None

    def charged_within(self, cost: float) -> Float[np.ndarray, "n"] | None:
        """The last point that was charged for without a value among the first `cost` units, or None."""
        points = self.points[(self.cost <= cost * (1.0 + ROUNDING)) & np.isnan(self.values)]
        return points[-1] if len(points) else None
