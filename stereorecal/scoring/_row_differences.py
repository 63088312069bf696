"""Epipolar residuals, the row differences of the two rays of each correspondence under given extrinsics; and their
weights: the noise of windows, and robust losses.
"""

import enum

import jax
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, Extrinsics, is_host, namespace
from stereorecal.geometry import projection, rectifying_rotations, rotation_from_euler
from stereorecal.scoring._correspondences import Correspondences
from stereorecal.scoring._pure_arguments import checked_extrinsics

SMALLEST_SPREAD = 0.05  # pixels; matching is never better than that
_WELSCH = 0.25  # pixels: beyond about twice that the weight is 0
_WIDEST_WELSCH = 2.5  # robust standard deviations


def row_differences(found: Correspondences, extrinsics: Float[AnyArray, "6"]) -> Float[AnyArray, "k m"]:
    """Row in the rectified left image less the row in the rectified right one, in pixels of the scale of `found`.

    Pure; composes under `jit`, `vmap` over the extrinsics, `grad` and `jacfwd`. Where nothing was found
    (`found.weight` is 0) the value is meaningless.

    Args:
        found: what `correspondences` returned.
        extrinsics: (6,): pitch, yaw, roll [rad] and the translation in any unit: only its direction counts.

    Returns:
        (k, m); NumPy in float64 if both arguments are NumPy's, else JAX in float32.
    """
    extrinsics = checked_extrinsics(extrinsics)
    if is_host(*jax.tree.leaves(found), extrinsics):
        return differences_of(found, extrinsics)
    return _compiled(found, extrinsics)


def differences_of(found: Correspondences, extrinsics: Extrinsics) -> Float[AnyArray, "k m"]:
    """`row_differences` (k, m), for callers that compile it as a part of their own program."""
    xp = namespace(found.left, extrinsics)
    first, second = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])

    def rows(rays, rotation):
        x, y, z = rays[..., 0], rays[..., 1], rays[..., 2]  # written out: a GPU would multiply matrices with ten bits
        (a, b, c), (d, e, f) = rotation[1], rotation[2]
        return row(a * x + b * y + c * z, d * x + e * y + f * z)

    row = projection(found.projection).row
    return xp.asarray(found.focal) * (rows(found.left, first) - rows(found.right, second))


# `checkpoint`: in reverse mode, to keep some seventy small factors of the derivative takes longer than to compute them.
_compiled = jax.jit(jax.checkpoint(differences_of))


def median_row_error(found: Correspondences, extrinsics: Extrinsics) -> float:
    """Median |row difference| in pixels at full size; NaN if nothing was found."""
    valid = np.asarray(found.weight) > 0
    differences = row_differences(found, extrinsics)
    return float(np.median(np.abs(differences[valid])) / float(found.scale)) if valid.any() else float("nan")


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
