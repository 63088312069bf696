"""Disparities in a figure: all on one scale, dark where there is none."""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.image import AxesImage

Values = Float[np.ndarray, "h w"]
Valid = Bool[np.ndarray, "h w"]
_INVALID = "#202020"


def largest_disparity(shown: Iterable[tuple[Values, Valid]]) -> float:
    """The end of the scale: the 99th percentile of the fullest of all, since the false matches of a bad calibration
    spread over the whole range."""
    fullest, valid = max(shown, key=lambda one: int(one[1].sum()))
    return float(np.quantile(fullest[valid], 0.99)) if valid.any() else 1.0


def draw_disparity(axis: Axes, values: Values, valid: Valid, largest: float) -> AxesImage:
    """Draw disparities between 0 and `largest`; the image is what a colour bar needs."""
    axis.set_facecolor(_INVALID)
    return axis.imshow(np.ma.masked_where(~valid, values), cmap="viridis", vmin=0.0, vmax=largest)
