"""What all derivative-based strategies share."""

import abc
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome
from stereorecal_optimistix._importing import importing
from stereorecal_optimistix._options import check_options

if TYPE_CHECKING:
    from stereorecal_optimistix._step import Solver


@dataclass(frozen=True)
class AbstractClimb(AbstractStrategy):
    """A solver that evaluates one value with its derivative per step.

    Attributes:
        rtol, atol: the search ends when a step changes both v and the value by less than atol + rtol times their size.
        steps: the most steps, rejected ones included.
    """

    rtol: float = 1e-3
    atol: float = 1e-3
    steps: int = 100

    def __post_init__(self) -> None:
        check_options(self)

    @abc.abstractmethod
    def solver(self) -> "Solver":
        """The solver of optimistix."""

    @property
    def unit(self) -> float:
        """The solver's unit of length, in half widths of the box."""
        return 1.0

    def scale(self, slope: Float[np.ndarray, "*m n"]) -> float:
        """What the solver's function is divided by, so that the options do not depend on the score's unit.

        Args:
            slope: the derivative at the start.
        """
        return float(np.linalg.norm(slope))

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        with importing(self):
            from stereorecal_optimistix._loop import climb
        return climb(self, objective, start)
