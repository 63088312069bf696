"""Tracks: points seen by both cameras in two consecutive pairs, from which the rig's motion is estimated."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class Tracks:
    """m points in two consecutive pairs.

    Attributes:
        left, right: (2, m, 2) pixels (column, row) as the cameras took them, at full size, of the first pair and of the
            second; float64.
    """

    left: Float[np.ndarray, "2 m 2"]
    right: Float[np.ndarray, "2 m 2"]

    def __len__(self) -> int:
        return self.left.shape[1]

    def of(self, which: Any) -> "Tracks":
        """The tracks of an index or mask."""
        return Tracks(*(getattr(self, part.name)[:, which] for part in fields(self)))
