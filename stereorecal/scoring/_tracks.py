"""Tracks: points seen by both cameras in two consecutive pairs, from which the rig's motion is estimated."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class Tracks:
    """m points in two consecutive pairs.

    Attributes:
        left, right: (2, m, 2) pixels (column, row) as the cameras took them, at full size, of the first pair and of the
            second; float64.
        readout: time from the first row of an image to the last, of a rolling shutter, as a share of the time from one
            pair to the other; 0: all rows at once.
    """

    left: Float[np.ndarray, "2 m 2"]
    right: Float[np.ndarray, "2 m 2"]
    readout: float = 0.0

    def __len__(self) -> int:
        return self.left.shape[1]

    def of(self, which: Any) -> "Tracks":
        """The tracks of an index or mask."""
        return replace(self, left=self.left[:, which], right=self.right[:, which])
