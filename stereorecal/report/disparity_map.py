"""Disparity maps in figures: one colour scale for all, invalid pixels dark."""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.image import AxesImage

Values = Float[np.ndarray, "h w"]
Valid = Bool[np.ndarray, "h w"]
_INVALID = "#202020"


def largest_disparity(maps: Iterable[tuple[Values, Valid]]) -> float:
    """Upper end of the colour scale: the 99th percentile of the map with the most valid pixels.

    False matches under a wrong calibration spread over the whole range, so the maximum over all maps would not do.
    """
    fullest, valid = max(maps, key=lambda one: int(one[1].sum()))
    return float(np.quantile(fullest[valid], 0.99)) if valid.any() else 1.0


def colour_range(maps: Iterable[tuple[Values, Valid]]) -> tuple[float, float]:
    """Both ends of a colour scale: the 1st and the 99th percentile of the map with the most valid pixels."""
    fullest, valid = max(maps, key=lambda one: int(one[1].sum()))
    if not valid.any():
        return 0.0, 1.0
    least, largest = np.quantile(fullest[valid], (0.01, 0.99)).tolist()
    return least, max(largest, least + 1.0)


def draw_disparity(axis: Axes, values: Values, valid: Valid, largest: float) -> AxesImage:
    """Draw a disparity map with colours from 0 to `largest`; returns the image, from which to make a colour bar."""
    axis.set_facecolor(_INVALID)
    return axis.imshow(np.ma.masked_where(~valid, values), cmap="viridis", vmin=0.0, vmax=largest)
