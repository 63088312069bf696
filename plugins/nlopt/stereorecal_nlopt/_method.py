"""What all methods of NLopt have in common: setting up the optimiser and running it."""

import abc
from dataclasses import dataclass
from typing import ClassVar

import nlopt
import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome
from stereorecal_nlopt._search import Ask, Memory, over_the_box, search, values_of


@dataclass(frozen=True)
class AbstractMethod(AbstractStrategy):
    """A method of NLopt, on the unit box."""

    algorithm: ClassVar[int]

    @abc.abstractmethod
    def configure(self, opt: nlopt.opt, objective: Objective) -> None:
        """Set this method's options and stopping rules on NLopt's optimiser."""

    def asks(self, objective: Objective, memory: Memory) -> Ask:
        """The function that NLopt maximises: by default, scores on the host."""
        return values_of(objective, memory)

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`."""
        opt = over_the_box(self.algorithm, objective.dim)
        self.configure(opt, objective)
        memory = Memory(start)
        return search(opt, self.asks(objective, memory), memory, seed)
