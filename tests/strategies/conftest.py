"""An objective that counts what it is asked."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from stereorecal.strategies import Budget, Objective, Problem, Traced


@dataclass
class Counter:
    """A bowl with its top at 0.3 in every coordinate; remembers the sizes of the batches that reached it."""

    dim: int = 2
    batches: list[int] = field(default_factory=list)

    def values(self, points):
        self.batches.append(len(points))
        return 1.0 - np.sum((points - 0.3) ** 2, axis=1)

    @property
    def evaluated(self) -> int:
        return sum(self.batches)

    def objective(self, cost: float = 1.0, traced: Traced | None = None, **budget) -> Objective:
        problem = Problem(self.dim, self.values, cost, traced or Traced())
        return Objective(problem, Budget(**budget) if budget else None)


@pytest.fixture
def counter() -> Counter:
    return Counter()
