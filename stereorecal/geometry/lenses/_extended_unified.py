"""The extended unified lens (Khomutenko, Garcia, Martinet: An enhanced unified camera model, RA-L 2016): Kalibr's and
Basalt's `eucm`; with beta 1, the unified model of Geyer and Mei in another dress."""

from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, namespace
from stereorecal._errors import InputError
from stereorecal.geometry.lenses._directions import flat, in_kind, steepest, unit

NAME = "eucm"
ABOUT = "extended unified, two coefficients alpha beta"
TERMS = CALIBRATED = ("alpha", "beta")
COUNTS = (2,)
WIDE = True


def check(coefficients: Float[np.ndarray, "2"]) -> None:
    """Refuse a surface that is no ellipsoid.

    Raises:
        InputError: if alpha is not from 0 to 1, or beta not positive.
    """
    alpha, beta = coefficients
    if not (0.0 <= alpha <= 1.0 and beta > 0.0):
        raise InputError(
            f"alpha {alpha:.4g} and beta {beta:.4g} are outside the extended unified model (0 <= alpha <= 1, beta "
            "> 0); correct the calibration."
        )


def project(x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
    """Image points of directions."""
    xp = namespace(x, y, z, coefficients)
    alpha, beta = coefficients
    below = alpha * xp.sqrt(beta * (x * x + y * y) + z * z) + (1.0 - alpha) * z
    return x / below, y / below


def unproject(
    points: Float[AnyArray, "*n 2"], coefficients: Float[AnyArray, "2"], start: Float[np.ndarray, "*n 2"] | None = None
) -> Float[AnyArray, "*n 3"]:
    """Unit vectors; NaN beyond the field."""
    xp, points = in_kind(points, coefficients)
    alpha, beta = coefficients
    x, y = points[..., 0], points[..., 1]
    squared = beta * (x * x + y * y)
    inside = 1.0 - (2.0 * alpha - 1.0) * squared
    seen = inside >= 0.0
    z = (1.0 - alpha * alpha * squared) / (alpha * xp.sqrt(xp.where(seen, inside, 1.0)) + 1.0 - alpha)
    return unit(x, y, z, seen)


def magnification(coefficients: Float[np.ndarray, "2"]) -> float:
    """1."""
    return 1.0


def field(coefficients: Float[np.ndarray, "2"]) -> float:
    """Where z is -w of sqrt(beta (x² + y²) + z²)."""
    alpha, beta = (float(number) for number in coefficients)
    w = steepest(alpha)
    if w >= 1.0:  # nothing ends before straight behind
        return float(np.pi)
    return float(np.arctan2(np.sqrt((1.0 - w * w) / beta), -w))


def flat_radius(coefficients: Float[np.ndarray, "2"]) -> float:
    """The tangent of the same, as far as rays (x/z, y/z, 1) go."""
    return flat(field(coefficients))
