"""The contract of a strategy: what a plug-in declares, what it is given and what it returns."""

import abc
import enum
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies._objective import Need, Objective


class Status(enum.Enum):
    """How a run ended; the value is the message."""

    CONVERGED = "the strategy met its own stopping rule"
    BUDGET = "the budget was used up; the best point seen is returned"
    STALLED = "the strategy stopped without meeting its stopping rule"
    NO_SIGNAL = "the score is the same everywhere it was tried; there is too little to match"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What `AbstractStrategy.run` returns.

    Attributes:
        best: (n,) the point that the strategy nominates, in the unit box. The core takes the best of this point, the
            best point recorded, and the start, by the objective's own values.
        status: how the run ended.
        message: details in one sentence; empty if there are none.
    """

    best: Float[np.ndarray, "n"]
    status: Status
    message: str = ""


@dataclass(frozen=True)
class AbstractStrategy(abc.ABC):
    """An optimiser as a plug-in: a frozen dataclass whose fields are its options.

    The first line of the class's docstring is its entry in `python -m stereorecal strategies`.

    Class attributes:
        needs: what the objective must offer. The core checks it before anything runs.
        min_dim, max_dim: the fewest and the most free parameters it works with; None for no limit.
    """

    needs: ClassVar[Need] = Need.HOST
    min_dim: ClassVar[int] = 1
    max_dim: ClassVar[int | None] = None

    @abc.abstractmethod
    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """Maximise `objective` over the unit box [-1, 1]^n, starting from `start` inside it.

        The budget is the objective's (`objective.budget`, `objective.remaining`). Let `BudgetExhausted` propagate: the
        core keeps the best point seen. Derive all randomness from `seed`.
        """
