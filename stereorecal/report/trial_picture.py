"""Disparity maps of a trial, as plain data for the page of a comparison."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

Disparities = tuple[Float[np.ndarray, "h w"], Bool[np.ndarray, "h w"]]  # values, and where there is one


@dataclass(frozen=True, eq=False)
class TrialPicture:
    """The disparity of a trial before and after the repair."""

    scene: str
    title: str
    before: Disparities
    after: Disparities
