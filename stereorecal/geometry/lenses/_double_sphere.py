"""The double sphere (Usenko, Demmel, Cremers: The double sphere camera model, 3DV 2018): Basalt's and Kalibr's `ds`."""

from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, namespace
from stereorecal._errors import InputError
from stereorecal.geometry.lenses._directions import flat, in_kind, steepest, unit

NAME = "ds"
ABOUT = "double sphere, two coefficients xi alpha"
TERMS = CALIBRATED = ("xi", "alpha")
COUNTS = (2,)
WIDE = True


def check(coefficients: Float[np.ndarray, "2"]) -> None:
    """Refuse spheres that do not meet.

    Raises:
        InputError: if xi is not above -1 and at most 1, or alpha not from 0 to 1.
    """
    xi, alpha = coefficients
    if not (-1.0 < xi <= 1.0 and 0.0 <= alpha <= 1.0):
        raise InputError(
            f"xi {xi:.4g} and alpha {alpha:.4g} are outside the double sphere model (-1 < xi <= 1, 0 <= alpha <= 1); "
            "correct the calibration."
        )


def project(x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
    """Image points of directions (eq. 40 to 42)."""
    xp = namespace(x, y, z, coefficients)
    xi, alpha = coefficients
    squared = x * x + y * y
    ahead = xi * xp.sqrt(squared + z * z) + z
    below = alpha * xp.sqrt(squared + ahead * ahead) + (1.0 - alpha) * ahead
    return x / below, y / below


def unproject(
    points: Float[AnyArray, "*n 2"], coefficients: Float[AnyArray, "2"], start: Float[np.ndarray, "*n 2"] | None = None
) -> Float[AnyArray, "*n 3"]:
    """Unit vectors (eq. 46 to 50); NaN beyond the field."""
    xp, points = in_kind(points, coefficients)
    xi, alpha = coefficients
    x, y = points[..., 0], points[..., 1]
    squared = x * x + y * y
    inside = 1.0 - (2.0 * alpha - 1.0) * squared
    seen = inside >= 0.0
    z = (1.0 - alpha * alpha * squared) / (alpha * xp.sqrt(xp.where(seen, inside, 1.0)) + 1.0 - alpha)
    root = z * z + (1.0 - xi * xi) * squared
    seen = seen & (root >= 0.0)
    scale = (z * xi + xp.sqrt(xp.where(seen, root, 1.0))) / (z * z + squared)
    return unit(scale * x, scale * y, scale * z - xi, seen)


def magnification(coefficients: Float[np.ndarray, "2"]) -> float:
    """1 / (1 + ξ)."""
    return 1.0 / (1.0 + float(coefficients[0]))


def field(coefficients: Float[np.ndarray, "2"]) -> float:
    """Where the image turns back or comes from infinity. Of the angle φ at the second centre the cosine is -w1 there
    (eq. 44), and sin(θ - φ) = ξ sin φ; for ξ < 0 this is less than what eq. 43 says, which lets points through twice.
    """
    xi, alpha = (float(number) for number in coefficients)
    second = np.arccos(-steepest(alpha))
    return float(second + np.arcsin(np.clip(xi * np.sin(second), -1.0, 1.0)))


def flat_radius(coefficients: Float[np.ndarray, "2"]) -> float:
    """The tangent of the same, as far as rays (x/z, y/z, 1) go."""
    return flat(field(coefficients))
