"""Kannala and Brandt's lens, with four coefficients."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, namespace
from stereorecal._errors import InputError
from stereorecal.geometry.lenses._model import LEAST_FIELD, Coefficients, LensModel, in_kind

_REAL = 1e-9  # of a root's size: rounding
_SETTLED = 1e-15  # radians
_ROUNDS = 100  # of Newton's method: at the end of the field, where it halves the way, some fifty


class Equidistant(LensModel):
    """An image point lies at the distance θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) from the middle, θ the angle off the
    axis. OpenCV's `cv2.fisheye`, Kalibr's and ROS' `equidistant`."""

    NAME = "equidistant"
    ABOUT = "Kannala-Brandt, four coefficients k1 k2 k3 k4 (cv2.fisheye)"
    TERMS = CALIBRATED = ("k1", "k2", "k3", "k4")
    COUNTS = (4,)

    def check(self, coefficients: Coefficients) -> None:
        """Refuse a lens that folds the image back within 5 degrees."""
        if self.field(coefficients) < LEAST_FIELD:
            raise InputError(
                "the coefficients of the equidistant lens fold the image back within 5 degrees off its axis, as no "
                "lens does; correct the calibration."
            )

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple[Any, Any]:
        """Analytic, also behind the camera."""
        xp = namespace(x, y, z, coefficients)
        squared = x * x + y * y
        off_axis = xp.real(squared) > 0.0
        aside = xp.sqrt(xp.where(off_axis, squared, 1.0))  # of the axis: anything that has a derivative
        angle = 2.0 * xp.arctan(aside / (z + xp.sqrt(squared + z * z)))
        scale = xp.where(off_axis, _grown(angle, coefficients) / aside, 1.0 / xp.where(off_axis, 1.0, z))
        return x * scale, y * scale

    def unproject(self, points: AnyArray, coefficients: AnyArray, start: np.ndarray | None = None) -> AnyArray:
        """Solved for the angle by Newton's method."""
        xp, points = in_kind(points, coefficients)
        x, y = points[..., 0], points[..., 1]
        squared = x * x + y * y
        off_axis = squared > 0.0
        radius = xp.sqrt(xp.where(off_axis, squared, 1.0))
        if xp is np:
            most = self.field(np.asarray(coefficients))
            angle = _angles_on_host(np.asarray(radius), np.asarray(coefficients, float), most)
        else:
            angle = _angles(radius, coefficients)
        sine = xp.where(off_axis, xp.sin(angle) / radius, 1.0)
        return xp.stack([x * sine, y * sine, xp.where(off_axis, xp.cos(angle), 1.0)], axis=-1)

    def field(self, coefficients: Coefficients) -> float:
        """Where the derivative by the angle first vanishes; π where it nowhere does."""
        k1, k2, k3, k4 = np.asarray(coefficients, float)
        inverse = np.roots(np.array([1.0, 3.0 * k1, 5.0 * k2, 7.0 * k3, 9.0 * k4]))  # 1 / θ², whose first factor is 1
        real = inverse.real[np.abs(inverse.imag) <= _REAL * np.abs(inverse)]
        return float(1.0 / np.sqrt(max(real.max(initial=0.0), np.pi**-2)))


def _grown(angle: Any, coefficients: Any) -> Any:
    k1, k2, k3, k4 = coefficients
    t = angle * angle
    return angle * (1.0 + t * (k1 + t * (k2 + t * (k3 + t * k4))))


def _growth(angle: Any, coefficients: Any) -> Any:
    """The derivative of `_grown` by the angle."""
    k1, k2, k3, k4 = coefficients
    t = angle * angle
    return 1.0 + t * (3.0 * k1 + t * (5.0 * k2 + t * (7.0 * k3 + t * 9.0 * k4)))


def _angles_on_host(
    radius: Float[np.ndarray, "*n"], coefficients: Coefficients, most: float
) -> Float[np.ndarray, "*n"]:
    """Newton's method between bounds, 0 and `most`, halving them where it would leave them."""
    low, high = np.zeros_like(radius), np.full_like(radius, most)
    angle = np.asarray(np.minimum(radius, most))
    for _ in range(_ROUNDS):
        error = _grown(angle, coefficients) - radius
        low, high = np.where(error < 0.0, angle, low), np.where(error < 0.0, high, angle)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = angle - error / _growth(angle, coefficients)
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        moved, angle = np.abs(new - angle), new
        if not (moved > _SETTLED * (1.0 + angle)).any():
            break
    return np.asarray(np.where(radius <= _grown(most, coefficients), angle, np.nan))


def _angles(radius: jax.Array, coefficients: Any) -> jax.Array:
    """Newton's method in float32, from below, where a model without a fold comes in from one side."""

    def step(_: Any, angle: jax.Array) -> jax.Array:
        change = (_grown(angle, coefficients) - radius) / jnp.maximum(_growth(angle, coefficients), 1e-3)
        return jnp.clip(angle - jnp.clip(change, -0.25, 0.25), 0.0, np.pi)

    angle = jax.lax.fori_loop(0, 20, step, jnp.minimum(radius, 1.0))
    converged = (jnp.abs(_grown(angle, coefficients) - radius) < 1e-4) & (_growth(angle, coefficients) > 0.0)
    return jnp.where(converged, angle, jnp.nan)
