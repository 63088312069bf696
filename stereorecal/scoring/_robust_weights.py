"""Weights of correspondences: the noise of their windows, and robust losses of their row differences."""

import enum

import numpy as np
from jaxtyping import Float

from stereorecal.scoring._correspondences import Correspondences

SMALLEST_SPREAD = 0.05  # pixels; matching is never better than that
_WELSCH = 0.25  # pixels: beyond about twice that the weight is 0
_WIDEST_WELSCH = 2.5  # robust standard deviations


class Loss(enum.Enum):
    """The weight of a correspondence as a function of its residual r and a scale s."""

    SOFT_L1 = "1 / sqrt(1 + (r / s)²): far from the solution, where all residuals are large"
    WELSCH = "exp(-(r / s)² / 2): at the end; outliers have no weight"


def robust_spread(found: Correspondences, differences: Float[np.ndarray, "k m"]) -> float:
    """Robust standard deviation of the row differences about zero, in pixels (1.4826 times the median)."""
    valid = np.asarray(found.weight) > 0
    median = float(np.median(np.abs(differences[valid]))) if valid.any() else 0.0
    return max(SMALLEST_SPREAD, 1.4826 * median)


def precisions(found: Correspondences, differences: Float[np.ndarray, "k m"], loss: Loss) -> Float[np.ndarray, "k m"]:
    """Weight of each squared row difference, 1 / pixels²: noise of its window, robust weight, spread, overlap."""
    spread = robust_spread(found, differences)
    if loss is Loss.SOFT_L1:
        robust = 1.0 / np.sqrt(1.0 + (differences / spread) ** 2)
    else:
        robust = np.exp(-0.5 * (differences / _welsch_scale(spread)) ** 2)
    return np.asarray(found.weight) * robust * float(found.independent) / spread**2


def curvatures(found: Correspondences, differences: Float[np.ndarray, "k m"]) -> Float[np.ndarray, "k m"]:
    """Second derivative of each one's Welsch loss, 1 / pixels²: less than its precision, since a correspondence that
    moves away loses weight; 0 beyond the scale, where it would be negative."""
    moved = differences / _welsch_scale(robust_spread(found, differences))
    return precisions(found, differences, Loss.WELSCH) * np.maximum(1.0 - moved**2, 0.0)


def _welsch_scale(spread: float) -> float:
    return max(_WELSCH, _WIDEST_WELSCH * spread)
