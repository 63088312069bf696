"""OpenCV's lens distortion."""

from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Inexact

from stereorecal._arrays import AnyArray, is_host, namespace
from stereorecal.geometry.lenses._model import FLAT_LIMIT, Coefficients, LensModel


class RadialTangential(LensModel):
    """None, 4, 5, 8, 12 or 14 coefficients: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty."""

    NAME = "radtan"
    ABOUT = "OpenCV's radial-tangential model, 0, 4, 5, 8, 12 or 14 coefficients"
    TERMS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
    CALIBRATED = ("k1", "k2", "p1", "p2", "k3", "s1", "s2", "s3", "s4")
    COUNTS = (0, 4, 5, 8, 12, 14)
    WIDE = False

    def check(self, coefficients: Coefficients) -> None:
        """Nothing: where the image folds back, `field` ends."""

    def project(self, x: Any, y: Any, z: Any, coefficients: Any) -> tuple:
        """The image of directions ahead of the camera."""
        return distort_planes(x / z, y / z, coefficients)

    def unproject(self, points: AnyArray, coefficients: AnyArray, start: np.ndarray | None = None) -> AnyArray:
        """Rays (x/z, y/z, 1)."""
        flat = undistort(points, coefficients, start=start)
        xp = namespace(flat)
        return xp.concatenate([flat, xp.ones_like(flat[..., :1])], axis=-1)

    def field(self, coefficients: Coefficients) -> float:
        """Where the radial terms fold back."""
        return float(np.arctan(self.flat_radius(coefficients)))

    def flat_radius(self, coefficients: Coefficients) -> float:
        """Beyond it the polynomial folds back into the image, and pixels there would show the wrong rays."""
        radial_only = np.array(coefficients, float)
        radial_only[2:4] = 0.0
        radial_only[8:] = 0.0
        return _turning_point(tuple(radial_only.tolist()))


def distort(points: Inexact[AnyArray, "*n 2"], coefficients: Inexact[AnyArray, "c"]) -> Inexact[AnyArray, "*n 2"]:
    """Distort normalised image points (x/z, y/z), as OpenCV's `projectPoints` does."""
    xp = namespace(points, coefficients)
    return xp.stack(distort_planes(points[..., 0], points[..., 1], coefficients), axis=-1)


def distort_planes(
    x: Inexact[AnyArray, "*n"], y: Inexact[AnyArray, "*n"], coefficients: Inexact[AnyArray, "c *lenses"]
) -> tuple:
    """`distort` with x and y apart, as maps of whole images want them: pairs in memory cost four times the time.
    Several lenses broadcast against the points."""
    count = coefficients.shape[0]
    if count == 0:
        return x, y
    k1, k2, p1, p2 = coefficients[:4]
    r2 = x * x + y * y
    k3 = coefficients[4] if count >= 5 else 0.0
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    if count >= 8:
        k4, k5, k6 = coefficients[5:8]
        radial = radial / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    if count >= 12:
        s1, s2, s3, s4 = coefficients[8:12]
        xd = xd + r2 * (s1 + r2 * s2)
        yd = yd + r2 * (s3 + r2 * s4)
    if count == 14:
        (m00, m01, m02), (m10, m11, m12), (m20, m21, m22) = _tilt_matrix(coefficients[12], coefficients[13])
        w = m20 * xd + m21 * yd + m22
        xd, yd = (m00 * xd + m01 * yd + m02) / w, (m10 * xd + m11 * yd + m12) / w
    return xd, yd


def _tilt_matrix(tau_x, tau_y):
    """The projective map of a tilted sensor (OpenCV documentation, "Camera calibration", eq. for tau)."""
    xp = namespace(tau_x, tau_y)
    cx, sx, cy, sy = xp.cos(tau_x), xp.sin(tau_x), xp.cos(tau_y), xp.sin(tau_y)
    # R = Ry(tau_y) Rx(tau_x), then a projection back onto the plane z = 1.
    r00, r01, r02 = cy, sx * sy, -cx * sy
    r10, r11, r12 = 0.0, cx, sx
    r20, r21, r22 = sy, -sx * cy, cx * cy
    return (
        (r22 * r00 - r02 * r20, r22 * r01 - r02 * r21, r22 * r02 - r02 * r22),
        (r22 * r10 - r12 * r20, r22 * r11 - r12 * r21, r22 * r12 - r12 * r22),
        (r20, r21, r22),
    )


_ITERATIONS = 20  # of Newton's method
_SETTLED = 1e-7  # of a step, normalised image points: the next would be of its square
_LONGEST = 0.25  # of a step: far corners of wide lenses must not jump over the model's turning point


def undistort(
    points: Float[AnyArray, "*n 2"], coefficients: Float[AnyArray, "c"], start: Float[np.ndarray, "*n 2"] | None = None
) -> Float[AnyArray, "*n 2"]:
    """Invert `distort` by Newton's method, where the model is monotone: float64 for NumPy arrays, else exact to
    float32.

    Args:
        start: of NumPy arrays: a point near the answer, if one is known; default `points`.
    """
    if not is_host(points, coefficients):
        points, coefficients = jnp.asarray(points, jnp.float32), jnp.asarray(coefficients, jnp.float32)
        return _undistort(points, coefficients) if coefficients.shape[0] else points
    goals, coefficients = np.asarray(points, float), np.asarray(coefficients, float)
    if coefficients.size == 0:
        return goals.copy()
    goals_x, goals_y = goals.reshape(-1, 2).T
    x, y = np.array(goals if start is None else start, float).reshape(-1, 2).T
    with np.errstate(all="ignore"):  # NaN where the model folds
        for _ in range(_ITERATIONS):
            (u, v), ((a, b), (c, d)) = _distorted_with_slopes(x, y, coefficients)
            u, v, determinant = u - goals_x, v - goals_y, a * d - b * c
            by_x, by_y = (d * u - b * v) / determinant, (a * v - c * u) / determinant
            length = np.sqrt(by_x * by_x + by_y * by_y)
            shorter = 1.0 / np.maximum(1.0, length / _LONGEST)
            x, y = x - shorter * by_x, y - shorter * by_y
            if not np.any(length > _SETTLED):
                break
    return np.stack([x, y], axis=-1).reshape(goals.shape)


def _distorted_with_slopes(
    x: Float[np.ndarray, "*n"], y: Float[np.ndarray, "*n"], coefficients: Float[np.ndarray, "c"]
):
    """`distort_planes`, and the derivatives of both by x and by y."""
    missing = [0.0] * (12 - coefficients.size)
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, *tilt = [*coefficients.tolist(), *missing]
    xx, xy, yy = x * x, x * y, y * y
    r2 = xx + yy
    radial, grows = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)), k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3)
    if k4 or k5 or k6:
        below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
        radial = radial / below
        grows = (grows - radial * (k4 + r2 * (2.0 * k5 + 3.0 * r2 * k6))) / below
    u = x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * xx)
    v = y * radial + p1 * (r2 + 2.0 * yy) + 2.0 * p2 * xy
    a = radial + 2.0 * (xx * grows + p1 * y + 3.0 * p2 * x)
    d = radial + 2.0 * (yy * grows + 3.0 * p1 * y + p2 * x)
    b = c = 2.0 * (xy * grows + p1 * x + p2 * y)
    if s1 or s2 or s3 or s4:
        across, down = 2.0 * (s1 + 2.0 * r2 * s2), 2.0 * (s3 + 2.0 * r2 * s4)
        u, v = u + r2 * (s1 + r2 * s2), v + r2 * (s3 + r2 * s4)
        a, b, c, d = a + across * x, b + across * y, c + down * x, d + down * y
    if not any(tilt):
        return (u, v), ((a, b), (c, d))
    m0, m1, m2 = _tilt_matrix(*tilt)
    w = m2[0] * u + m2[1] * v + m2[2]
    ends = [(m[0] * u + m[1] * v + m[2]) / w for m in (m0, m1)]
    of_ends = [((m[0] - end * m2[0]) / w, (m[1] - end * m2[1]) / w) for m, end in zip((m0, m1), ends, strict=True)]
    (au, av), (bu, bv) = of_ends
    return ends, ((au * a + av * c, au * b + av * d), (bu * a + bv * c, bu * b + bv * d))


@jax.jit  # or else every call outside a trace compiles the loop again
def _undistort(points: Float[jax.Array, "*n 2"], coefficients: Float[jax.Array, "c"]) -> Float[jax.Array, "*n 2"]:
    def newton(goal: jax.Array) -> jax.Array:
        def step(_, p):
            error = distort(p, coefficients) - goal
            (a, b), (c, d) = jax.jacfwd(lambda q: distort(q, coefficients))(p)
            determinant = a * d - b * c
            update = jnp.stack([d * error[0] - b * error[1], a * error[1] - c * error[0]]) / determinant
            return p - update / jnp.maximum(1.0, jnp.linalg.norm(update) / _LONGEST)

        return jax.lax.fori_loop(0, _ITERATIONS, step, goal)

    return jax.vmap(newton)(points.reshape(-1, 2)).reshape(points.shape)


@lru_cache(maxsize=64)  # each camera asks twice, for its radius and its field, and many cameras have one lens
def _turning_point(radial_only: tuple[float, ...]) -> float:
    """The undistorted radius up to which the model is monotone."""
    radii = np.linspace(0.0, FLAT_LIMIT, 4001)
    distorted, _ = distort_planes(radii, np.zeros_like(radii), np.array(radial_only))
    falling = np.diff(distorted) <= 0.0
    return float(radii[np.argmax(falling)]) if falling.any() else FLAT_LIMIT
