"""Models of one or two quadrics and a pinhole behind them: the double sphere, and the extended unified lens."""

from typing import Any

import numpy as np

from stereorecal._arrays import AnyArray, namespace
from stereorecal._errors import InputError
from stereorecal.geometry.lenses._model import Coefficients, LensModel, in_kind, unit


class DoubleSphere(LensModel):
    """Usenko, Demmel, Cremers: The double sphere camera model, 3DV 2018. Basalt's and Kalibr's `ds`."""

    NAME = "ds"
    ABOUT = "double sphere, two coefficients xi alpha"
    TERMS = CALIBRATED = ("xi", "alpha")
    COUNTS = (2,)

    def check(self, coefficients: Coefficients) -> None:
        """Refuse spheres that do not meet: xi is above -1 and at most 1, alpha from 0 to 1."""
        xi, alpha = coefficients
        if not (-1.0 < xi <= 1.0 and 0.0 <= alpha <= 1.0):
            raise InputError(
                f"xi {xi:.4g} and alpha {alpha:.4g} are outside the double sphere model (-1 < xi <= 1, 0 <= alpha <= "
                "1); correct the calibration."
            )

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """Eq. 40 to 42."""
        xp = namespace(x, y, z, coefficients)
        xi, alpha = coefficients
        squared = x * x + y * y
        ahead = xi * xp.sqrt(squared + z * z) + z
        below = alpha * xp.sqrt(squared + ahead * ahead) + (1.0 - alpha) * ahead
        return x / below, y / below

    def unproject(self, points: AnyArray, coefficients: AnyArray, start: np.ndarray | None = None) -> AnyArray:
        """Eq. 46 to 50."""
        xp, points = in_kind(points, coefficients)
        xi, alpha = coefficients
        x, y = points[..., 0], points[..., 1]
        squared = x * x + y * y
        z, seen = _ahead(squared, alpha)
        root = z * z + (1.0 - xi * xi) * squared
        seen = seen & (root >= 0.0)
        scale = (z * xi + xp.sqrt(xp.where(seen, root, 1.0))) / (z * z + squared)
        return unit(scale * x, scale * y, scale * z - xi, seen)

    def magnification(self, coefficients: Coefficients) -> float:
        """1 / (1 + ξ)."""
        return 1.0 / (1.0 + float(coefficients[0]))

    def field(self, coefficients: Coefficients) -> float:
        """Where the image turns back or comes from infinity. Of the angle φ at the second centre the cosine is -w1
        there (eq. 44), and sin(θ - φ) = ξ sin φ; for ξ < 0 this is less than what eq. 43 says, which lets points
        through twice."""
        xi, alpha = (float(number) for number in coefficients)
        second = np.arccos(-_steepest(alpha))
        return float(second + np.arcsin(np.clip(xi * np.sin(second), -1.0, 1.0)))


class ExtendedUnified(LensModel):
    """Khomutenko, Garcia, Martinet: An enhanced unified camera model, RA-L 2016. Kalibr's and Basalt's `eucm`; with
    beta 1, the unified model of Geyer and Mei in another dress."""

    NAME = "eucm"
    ABOUT = "extended unified, two coefficients alpha beta"
    TERMS = CALIBRATED = ("alpha", "beta")
    COUNTS = (2,)

    def check(self, coefficients: Coefficients) -> None:
        """Refuse a surface that is no ellipsoid: alpha is from 0 to 1, beta positive."""
        alpha, beta = coefficients
        if not (0.0 <= alpha <= 1.0 and beta > 0.0):
            raise InputError(
                f"alpha {alpha:.4g} and beta {beta:.4g} are outside the extended unified model (0 <= alpha <= 1, beta "
                "> 0); correct the calibration."
            )

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """The image: x, y over the mean, weighted by alpha, of z and the distance to the ellipsoid's centre."""
        xp = namespace(x, y, z, coefficients)
        alpha, beta = coefficients
        below = alpha * xp.sqrt(beta * (x * x + y * y) + z * z) + (1.0 - alpha) * z
        return x / below, y / below

    def unproject(self, points: AnyArray, coefficients: AnyArray, start: np.ndarray | None = None) -> AnyArray:
        """The inverse."""
        _, points = in_kind(points, coefficients)
        alpha, beta = coefficients
        x, y = points[..., 0], points[..., 1]
        z, seen = _ahead(beta * (x * x + y * y), alpha)
        return unit(x, y, z, seen)

    def field(self, coefficients: Coefficients) -> float:
        """Where z is -w of sqrt(beta (x² + y²) + z²)."""
        alpha, beta = (float(number) for number in coefficients)
        w = _steepest(alpha)
        if w >= 1.0:  # nothing ends before straight behind
            return float(np.pi)
        return float(np.arctan2(np.sqrt((1.0 - w * w) / beta), -w))


def _ahead(squared: Any, alpha: Any) -> tuple[Any, Any]:
    """z of image points of a squared radius on the quadric that the pinhole looks at, and whether they meet it."""
    xp = namespace(squared, alpha)
    inside = 1.0 - (2.0 * alpha - 1.0) * squared
    seen = inside >= 0.0
    return (1.0 - alpha * alpha * squared) / (alpha * xp.sqrt(xp.where(seen, inside, 1.0)) + 1.0 - alpha), seen


def _steepest(alpha: float) -> float:
    """The cosine, of the angle behind the second centre, at which image points turn back."""
    return alpha / (1.0 - alpha) if alpha <= 0.5 else (1.0 - alpha) / alpha
