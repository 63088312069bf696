"""The contract of a strategy: what a plug-in declares, what it is given, what it gives back."""

import abc
import enum
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies._budget import Budget
from stereorecal.strategies._need import Need
from stereorecal.strategies._objective import Objective


class Status(enum.Enum):
    """How a run ended; the value is the message."""

    CONVERGED = "the strategy met its own stopping rule"
    BUDGET = "the budget was used up; the best point seen is returned"
    STALLED = "the strategy stopped without meeting its stopping rule"
    NO_SIGNAL = "the score is the same everywhere it was tried; there is too little to match"
    SKIPPED = "the objective does not offer what the strategy needs"
    FAILED = "the strategy crashed"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What `AbstractStrategy.run` returns.

    Attributes:
        best: (n,) the point that the strategy nominates, in the unit box. The core compares it with the best point
            recorded and with the start, and takes the best of them.
        status: how the run ended.
        message: details in one sentence, if there are any.
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
        min_dim, max_dim: least and greatest number of free parameters it works with; None: no limit.
    """

    needs: ClassVar[Need] = Need.HOST
    min_dim: ClassVar[int] = 1
    max_dim: ClassVar[int | None] = None

    @abc.abstractmethod
    def run(self, objective: Objective, start: Float[np.ndarray, "n"], budget: Budget, seed: int) -> Outcome:
        """Maximise `objective` over the unit box [-1, 1]^n, from `start` inside it.

        Let `BudgetExhausted` pass: the core keeps the best point seen. Draw random numbers from `seed` alone.
        """
