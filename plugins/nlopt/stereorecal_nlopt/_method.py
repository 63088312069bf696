"""What all methods of NLopt share: the optimiser is set up, told what to ask, and run."""

import abc
from dataclasses import dataclass
from typing import ClassVar

import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Budget, Objective, Outcome
from stereorecal_nlopt._search import Ask, Memory, over_the_box, search, values_of


@dataclass(frozen=True)
class AbstractMethod(AbstractStrategy):
    """A method of NLopt over the unit box."""

    algorithm: ClassVar[int]

    @abc.abstractmethod
    def configure(self, opt: nlopt.opt, budget: Budget) -> None:
        """Hand NLopt the options of this method."""

    def asks(self, objective: Objective, memory: Memory) -> Ask:
        """What the method asks: scores on the host, unless it says otherwise."""
        return values_of(objective, memory)

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], budget: Budget, seed: int) -> Outcome:
        """See `AbstractStrategy.run`."""
        opt = over_the_box(self.algorithm, objective.dim)
        self.configure(opt, budget)
        memory = Memory(start)
        return search(opt, self.asks(objective, memory), memory, seed)
