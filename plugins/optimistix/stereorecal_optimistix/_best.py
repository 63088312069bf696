"""The best point of a run so far; optimistix's own wrappers for this lose points."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass
class Best:
    """The best point so far and its score."""

    z: Float[np.ndarray, "n"]
    score: float = -np.inf

    def see(self, z: Float[np.ndarray, "n"], score: float) -> None:
        """Keep z if its score is higher; NaN never is."""
        if score > self.score:
            self.z, self.score = z, score
