"""A repair under way."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.recordings import Pair


@dataclass(frozen=True, eq=False)
class Job:
    """A repair of what the looks cannot follow, cut into slices, so that no step takes long.

    Attributes:
        pairs: that it rests on.
        at: (6,) extrinsics [rad, m] where the next slice begins.
        done: slices so far.
    """

    pairs: tuple[Pair, ...]
    at: Float[np.ndarray, "6"]
    done: int = 0
