"""The simplex method of Nelder and Mead, on values alone."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Objective, Outcome
from stereorecal_optimistix._importing import importing
from stereorecal_optimistix._options import check_options


@dataclass(frozen=True)
class NelderMead(AbstractStrategy):
    """Nelder-Mead on the count: the downhill simplex method, without gradients.

    Optimistix traces the function that it minimises, but a count may be computed on the host. So a step is a pure
    function of the values known so far, NaN elsewhere; it is repeated until it needs no further value, and only values
    cost units.

    Attributes:
        rtol, atol: the search ends when the corners of the simplex differ by less than atol + rtol times their size,
            both in v (distance from the start, in first steps) and in the score.
        steps: the most steps, of one or two evaluations each (n more where the simplex shrinks).
        step: length of the first simplex's edges, in half widths of the search box.
    """

    rtol: float = 1e-2
    atol: float = 1e-2
    steps: int = 300
    step: float = 1.0 / 8.0

    def __post_init__(self) -> None:
        check_options(self)

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. Deterministic: `seed` is not used."""
        with importing(self):
            from stereorecal_optimistix._simplex import descend
        return descend(self, objective, start)
