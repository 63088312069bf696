"""Changes of a camera's intrinsics, and how the ray of a pixel moves with them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal.geometry._camera import Camera
from stereorecal.geometry._distortion import COEFFICIENT_COUNTS, distort_planes, undistort

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
    by_ray, moved = pixel_slopes(camera, rays, names)
    (a, b), (c, d) = np.moveaxis(by_ray, (-2, -1), (0, 1))
    u, v = moved[..., 0], moved[..., 1]
    return np.stack([b * v - d * u, c * u - a * v], axis=-1) / (a * d - b * c)[..., None]


def pixel_slopes(
    camera: Camera, rays: Float[np.ndarray, "*n 3"], names: Sequence[str]
) -> tuple[Float[np.ndarray, "*n 2 2"], Float[np.ndarray, "p *n 2"]]:
    """Derivatives of the pixels in which points along `rays` appear, by (x/z, y/z) and by the intrinsics that
    `changed_camera` knows."""
    rays = np.asarray(rays, float)
    points = (rays[..., :2] / rays[..., 2:]).reshape(-1, 2)
    coefficients = _long_enough(np.array(camera.distortion, float), _COEFFICIENTS[:4])
    coefficients = _long_enough(coefficients, names)
    lens = [index for index, name in enumerate(_COEFFICIENTS) if name in names]
    # Complex steps (Squire & Trapp 1998), all at once: derivatives without a difference, exact.
    steps = _TINY * 1j * np.eye(2 + coefficients.size)[[0, 1, *(2 + index for index in lens)]]
    lenses = (coefficients + steps[:, 2:]).T[..., None]
    ends = np.stack(distort_planes(points[:, 0] + steps[:, :1], points[:, 1] + steps[:, 1:2], lenses), axis=-1)
    focal = np.asarray(camera.matrix)[(0, 1), (0, 1)]
    slopes = np.imag(ends) / _TINY * focal
    of_name = dict(zip((_COEFFICIENTS[index] for index in lens), slopes[2:], strict=True))
    of_name |= {"f": np.real(ends[0]) * focal, "aspect": np.real(ends[0]) * focal * [0, 1]}
    of_name |= {"cx": np.broadcast_to([1.0, 0.0], points.shape), "cy": np.broadcast_to([0.0, 1.0], points.shape)}
    moved = np.stack([of_name[name] for name in names]) if names else np.zeros((0, *points.shape))
    shape = rays.shape[:-1]
    by_ray = np.moveaxis(slopes[:2], 0, -1)
    return by_ray.reshape(*shape, 2, 2), moved.reshape(len(names), *shape, 2)
