"""The unified sphere with radial-tangential distortion."""

from typing import Any

import numpy as np

from stereorecal._arrays import AnyArray, namespace
from stereorecal._errors import InputError
from stereorecal.geometry.lenses._model import LEAST_FIELD, Coefficients, LensModel, in_kind, unit
from stereorecal.geometry.lenses._radial_tangential import distort, distort_planes, undistort

_FARTHEST = 2.0  # radius before distortion, which is inverted up to there: 127 degrees off the axis for ξ = 1
_MET = 1e-4  # between an image point and where its direction is seen; float32


class Omni(LensModel):
    """Mei & Rives: Single view point omnidirectional camera calibration from planar grids, ICRA 2007. A direction is
    laid on the unit sphere, seen from ξ behind its centre, and distorted as by OpenCV's k1 k2 p1 p2. Kalibr's `omni`
    with `radtan` or none, OpenCV's `omnidir`."""

    NAME = "omni"
    ABOUT = "unified sphere with radial-tangential distortion, five coefficients xi k1 k2 p1 p2"
    TERMS = CALIBRATED = ("xi", "k1", "k2", "p1", "p2")
    COUNTS = (5,)

    def check(self, coefficients: Coefficients) -> None:
        """Refuse a centre before that of the sphere, and a lens that folds the image back within 5 degrees."""
        xi = coefficients[0]
        if not xi >= 0.0 or self.field(coefficients) < LEAST_FIELD:
            raise InputError(
                f"xi {xi:.4g} and the distortion {', '.join(f'{k:.4g}' for k in coefficients[1:])} are outside the "
                "omni model (xi >= 0, and no fold within 5 degrees off the axis); correct the calibration."
            )

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """The image of the unit sphere, seen from behind its centre."""
        xp = namespace(x, y, z, coefficients)
        below = z + coefficients[0] * xp.sqrt(x * x + y * y + z * z)
        return distort_planes(x / below, y / below, coefficients[1:])

    def unproject(self, points: AnyArray, coefficients: AnyArray, start: np.ndarray | None = None) -> AnyArray:
        """The inverse; NaN where the distortion is not inverted."""
        xp, points = in_kind(points, coefficients)
        xi, distortion = coefficients[0], coefficients[1:]
        undistorted = undistort(points, distortion)
        x, y = undistorted[..., 0], undistorted[..., 1]
        squared = x * x + y * y
        root = 1.0 + (1.0 - xi * xi) * squared
        error = xp.abs(distort(undistorted, distortion) - points).max(axis=-1)
        converged = (root >= 0.0) & (squared <= _fold(distortion)) & (error <= _MET * (1.0 + xp.sqrt(squared)))
        ahead = (xi + xp.sqrt(xp.where(converged, root, 1.0))) / (1.0 + squared)
        return unit(ahead * x, ahead * y, ahead - xi, converged)

    def magnification(self, coefficients: Coefficients) -> float:
        """1 / (1 + ξ)."""
        return 1.0 / (1.0 + float(coefficients[0]))

    def field(self, coefficients: Coefficients) -> float:
        """Where the sphere turns its image back, or the distortion folds or is inverted no more."""
        xi, fold = float(coefficients[0]), float(_fold(np.asarray(coefficients, float)[1:]))
        root = 1.0 + (1.0 - xi * xi) * fold
        if root <= 0.0:
            return float(np.arccos(-1.0 / xi))
        ahead = (xi + np.sqrt(root)) / (1.0 + fold)
        return float(np.arctan2(ahead * np.sqrt(fold), ahead - xi))


def _fold(distortion: Any) -> Any:
    """The squared radius, before distortion, at which the radial terms fold back, 1 + 3 k1 r² + 5 k2 r⁴ = 0, or the
    largest one that is looked at."""
    xp = namespace(distortion)
    half, other = 1.5 * distortion[0], 5.0 * distortion[1]
    inverse = xp.sqrt(xp.maximum(half * half - other, 0.0)) - half  # the largest 1 / r²
    folds = (half * half >= other) & (inverse > _FARTHEST**-2)
    return xp.minimum(xp.where(folds, 1.0 / xp.where(folds, inverse, 1.0), xp.inf), _FARTHEST**2)
