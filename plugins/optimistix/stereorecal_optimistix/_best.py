"""The best point that a run has seen; optimistix's own wrappers for it lose points."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass
class Best:
    """The best point so far and its score."""

    z: Float[np.ndarray, "n"]
    score: float = -np.inf

    def see(self, z: Float[np.ndarray, "n"], score: float) -> None:
        """Take z if it is better; NaN never is."""
        if score > self.score:
            self.z, self.score = z, score
