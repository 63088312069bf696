"""Changes of a camera's intrinsics, and how the ray of a pixel moves with them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal.geometry._camera import Camera
from stereorecal.geometry._distortion import COEFFICIENT_COUNTS, distort, undistort

_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
_TINY = 1e-30


def changed_camera(camera: Camera, changes: Mapping[str, float]) -> Camera:
    """The camera with other intrinsics.

    Args:
        changes: "f", "aspect": by which the logarithms of both focal lengths, or of fy alone, grow; "cx", "cy": pixels;
            "k1", "k2", "p1", "p2", "k3", … "s4": added to the coefficients. A lens model of fewer coefficients grows.
    """
    changes = {name: change for name, change in changes.items() if change}  # nothing grows for a change of nothing
    matrix = np.array(camera.matrix, float)
    matrix[0, 0] *= np.exp(changes.get("f", 0.0))
    matrix[1, 1] *= np.exp(changes.get("f", 0.0) + changes.get("aspect", 0.0))
    matrix[:2, 2] += [changes.get("cx", 0.0), changes.get("cy", 0.0)]
    coefficients = _long_enough(np.array(camera.distortion, float), changes)
    for index, name in enumerate(_COEFFICIENTS[: coefficients.size]):
        coefficients[index] += changes.get(name, 0.0)
    if np.array_equal(coefficients, camera.distortion):
        return replace(camera, matrix=matrix)
    return Camera(camera.size, matrix, coefficients)


def intrinsic(camera: Camera, name: str) -> float:
    """One of what `changed_camera` changes: "f" is the focal length along x, "aspect" that along y over it; pixels but
    for "aspect" and the coefficients. A coefficient that the lens model lacks is 0."""
    matrix = np.asarray(camera.matrix)
    of_matrix = {"f": matrix[0, 0], "aspect": matrix[1, 1] / matrix[0, 0], "cx": matrix[0, 2], "cy": matrix[1, 2]}
    if name in of_matrix:
        return float(of_matrix[name])
    index = _COEFFICIENTS.index(name)
    return float(camera.distortion[index]) if index < len(camera.distortion) else 0.0


def camera_changes(camera: Camera, changed: Camera) -> dict[str, float]:
    """The changes by which `changed_camera` makes one camera from another, all of them."""
    ratios = np.log(np.diag(changed.matrix)[:2] / np.diag(camera.matrix)[:2])
    centre = np.asarray(changed.matrix)[:2, 2] - np.asarray(camera.matrix)[:2, 2]
    here, there = (_long_enough(np.array(one.distortion, float), _COEFFICIENTS) for one in (camera, changed))
    coefficients = zip(_COEFFICIENTS, there - here, strict=False)
    named = {"f": ratios[0], "aspect": ratios[1] - ratios[0], "cx": centre[0], "cy": centre[1], **dict(coefficients)}
    return {name: float(change) for name, change in named.items()}


def _long_enough(coefficients: Float[np.ndarray, "n"], names: Mapping[str, float] | Sequence[str]):
    needed = max((1 + _COEFFICIENTS.index(name) for name in names if name in _COEFFICIENTS), default=0)
    length = next(count for count in COEFFICIENT_COUNTS if count >= max(needed, coefficients.size))
    return np.concatenate([coefficients, np.zeros(length - coefficients.size)])


def reread(rays: Float[np.ndarray, "*n 3"], true: Camera, read: Camera) -> Float[np.ndarray, "*n 3"]:
    """The rays (x/z, y/z, 1) that `read` gives to the pixels in which `true` sees points along `rays`."""
    rays = np.asarray(rays, float)
    points = rays[..., :2] / rays[..., 2:]
    goals = (true.project(rays) - read.matrix[:2, 2]) / read.matrix[(0, 1), (0, 1)]
    points = undistort(goals, np.asarray(read.distortion), start=points)
    return np.concatenate([points, np.ones_like(points[..., :1])], axis=-1)


def ray_slopes(camera: Camera, rays: Float[np.ndarray, "*n 3"], names: Sequence[str]) -> Float[np.ndarray, "p *n 2"]:
    """Derivatives of (x/z, y/z) of the pixels that lie on `rays`, by the intrinsics that `changed_camera` knows.

    The pixel stays where it is: with p = c + F d(x), d the distortion, 0 = dp gives dx = -(F ∂d/∂x)⁻¹ ∂p/∂θ.
    """
    rays = np.asarray(rays, float)
    points = rays[..., :2] / rays[..., 2:]
    coefficients = _long_enough(np.array(camera.distortion, float), names)
    distorted, focal = distort(points, coefficients), np.asarray(camera.matrix)[(0, 1), (0, 1)]
    # Complex steps (Squire & Trapp 1998), as in `undistort`.
    by_x, by_y = (np.imag(distort(points + _TINY * 1j * axis, coefficients)) / _TINY for axis in np.eye(2))
    (a, c), (b, d) = np.moveaxis(by_x, -1, 0), np.moveaxis(by_y, -1, 0)
    determinant = a * d - b * c
    slopes = []
    for name in names:
        if name in _COEFFICIENTS:
            step = _TINY * 1j * np.eye(coefficients.size)[_COEFFICIENTS.index(name)]
            moved = np.imag(distort(points, coefficients + step)) / _TINY
        else:
            of_axes = {"f": (1, 1), "aspect": (0, 1)}.get(name)
            moved = distorted * of_axes if of_axes else np.array([name == "cx", name == "cy"]) / focal
            moved = np.broadcast_to(moved, points.shape)
        u, v = moved[..., 0], moved[..., 1]
        slopes.append(np.stack([b * v - d * u, c * u - a * v], axis=-1) / determinant[..., None])
    return np.stack(slopes) if slopes else np.zeros((0, *points.shape))
