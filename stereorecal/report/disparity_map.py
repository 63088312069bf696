"""Disparity maps in figures: one colour scale for all, and those of a trial."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

Disparities = tuple[Float[np.ndarray, "h w"], Bool[np.ndarray, "h w"]]  # values, and where there is one


def colour_range(maps: Iterable[Disparities]) -> tuple[float, float]:
    """Both ends of a colour scale: the 1st and the 99th percentile of the map with the most valid pixels.

    False matches under a wrong calibration spread over the whole range, so the extremes over all maps would not do.
    """
    fullest, valid = max(maps, key=lambda one: int(one[1].sum()))
    if not valid.any():
        return 0.0, 1.0
    least, largest = np.quantile(fullest[valid], (0.01, 0.99)).tolist()
    return least, max(largest, least + 1.0)


@dataclass(frozen=True, eq=False)
class TrialPicture:
    """The disparity of a trial before and after the repair."""

    scene: str
    title: str
    before: Disparities
    after: Disparities
