"""Compass search as a stereorecal strategy. This file is all the code that a plug-in needs: copy it for your own."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome, Status


@dataclass(frozen=True)
class Compass(AbstractStrategy):
    """Compass (pattern) search: step along ± each axis, move to the best improvement, else halve the step.

    The optimiser of Muhovič & Perš, section 3.3 (after Kolda, Lewis & Torczon, SIAM Review 45(3), 2003). The 2n points
    of an iteration are one batch, less those evaluated before. It needs neither gradients nor smoothness.

    Attributes:
        step: first step, in half widths of the search box. The default is 0.19 degrees at the default reach, an error
            at which a matcher at full scale still finds matches; choose a longer one at a coarser scale or for a larger
            drift.
        min_step: the search ends when the step falls below this.
    """

    step: float = 1.0 / 16.0
    min_step: float = 1.0 / 128.0

    def __post_init__(self) -> None:
        if not 0.0 < self.min_step <= self.step <= 2.0:
            raise ValueError(f"need 0 < min_step <= step <= 2, got {self.min_step} and {self.step}")

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        stencil = np.concatenate([np.eye(objective.dim), -np.eye(objective.dim)])
        known: dict[bytes, float] = {}  # iterations share points with earlier ones

        def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
            new = {p.tobytes(): p for p in points if p.tobytes() not in known}
            if new:
                known.update(zip(new, _comparable(objective.batch(np.stack([*new.values()]))), strict=True))
            return np.array([known[p.tobytes()] for p in points])

        best, step = start, self.step
        best_value = values(start[None])[0]
        while step >= self.min_step:
            points = np.clip(best + step * stencil, -1.0, 1.0)
            around = values(points)
            winner = int(np.argmax(around))
            if around[winner] > best_value:
                best, best_value = points[winner], around[winner]
            else:
                step /= 2
        return Outcome(best, Status.CONVERGED)


def _comparable(values):
    """The values, with NaN replaced by -inf: worse than any value."""
    return np.where(np.isnan(values), -np.inf, values)
