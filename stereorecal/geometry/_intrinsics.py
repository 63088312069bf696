"""Changes of a camera's intrinsics, and how the ray of a pixel moves with them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry._camera import Camera, same_camera
from stereorecal.geometry.lenses import LensModel

_TINY = 1e-30


def changed_camera(camera: Camera, changes: Mapping[str, float]) -> Camera:
    """The camera with other intrinsics.

    Args:
        changes: "f", "aspect": by which the logarithms of both focal lengths, or of fy alone, grow; "cx", "cy": pixels;
            the terms of the lens model, "k1", "k2", …: added to the coefficients. A model of fewer coefficients grows.

    Raises:
        InputError: if its lens model has no such term, or it is none of a lens.
    """
    changes = {name: change for name, change in changes.items() if change}  # nothing grows for a change of nothing
    matrix = np.array(camera.matrix, float)
    matrix[0, 0] *= np.exp(changes.get("f", 0.0))
    matrix[1, 1] *= np.exp(changes.get("f", 0.0) + changes.get("aspect", 0.0))
    matrix[:2, 2] += [changes.get("cx", 0.0), changes.get("cy", 0.0)]
    _check_terms(camera.lens, changes)
    coefficients = _long_enough(camera.lens, np.array(camera.distortion, float), changes)
    for index, name in enumerate(camera.lens.TERMS[: coefficients.size]):
        coefficients[index] += changes.get(name, 0.0)
    if np.array_equal(coefficients, camera.distortion):
        return replace(camera, matrix=matrix)
    return Camera(camera.size, matrix, coefficients, model=camera.model)


def intrinsic(camera: Camera, name: str) -> float:
    """One of what `changed_camera` changes: "f" is the focal length along x, "aspect" that along y over it; pixels but
    for "aspect" and the coefficients. A coefficient that the lens model lacks is 0."""
    (fx, _, cx), (_, fy, cy), _ = np.asarray(camera.matrix)
    if name in OF_MATRIX:
        return float({"f": fx, "aspect": fy / fx, "cx": cx, "cy": cy}[name])
    _check_terms(camera.lens, (name,))
    index = camera.lens.TERMS.index(name)
    return float(camera.distortion[index]) if index < len(camera.distortion) else 0.0


def camera_changes(camera: Camera, changed: Camera) -> dict[str, float]:
    """The changes by which `changed_camera` makes one camera from another of the same lens model, all of them."""
    ratios = np.log(np.diag(changed.matrix)[:2] / np.diag(camera.matrix)[:2])
    centre = np.asarray(changed.matrix)[:2, 2] - np.asarray(camera.matrix)[:2, 2]
    terms = camera.lens.TERMS
    from_coefficients, to_coefficients = (
        _long_enough(camera.lens, np.array(one.distortion, float), terms) for one in (camera, changed)
    )
    coefficients = zip(terms, to_coefficients - from_coefficients, strict=False)
    named = {"f": ratios[0], "aspect": ratios[1] - ratios[0], "cx": centre[0], "cy": centre[1], **dict(coefficients)}
    return {name: float(change) for name, change in named.items()}


OF_MATRIX = ("f", "aspect", "cx", "cy")
"""Names of the intrinsics in the matrix of a camera; the terms of its lens follow."""


def _check_terms(lens: LensModel, names: Iterable[str]) -> None:
    """Refuse what the lens model does not have."""
    for name in names:
        if name not in OF_MATRIX and name not in lens.TERMS:
            raise InputError(
                f"{name} is no term of the lens model {lens.NAME!r}; it has {', '.join((*OF_MATRIX, *lens.TERMS))}."
            )


def _long_enough(lens: LensModel, coefficients: Float[np.ndarray, "n"], names: Iterable[str]) -> Float[np.ndarray, "m"]:
    needed = max((1 + lens.TERMS.index(name) for name in names if name in lens.TERMS), default=0)
    length = next(count for count in lens.COUNTS if count >= max(needed, coefficients.size))
    return np.concatenate([coefficients, np.zeros(length - coefficients.size)])


def reread(rays: Float[np.ndarray, "*n 3"], true: Camera, read: Camera) -> Float[np.ndarray, "*n 3"]:
    """The rays (x/z, y/z, 1) that `read` gives to the pixels in which `true` sees points along `rays`; the very `rays`,
    where the cameras are equal."""
    if same_camera(true, read):
        return rays
    rays = np.asarray(rays, float)
    return np.asarray(read.rays(true.project(rays), start=rays[..., :2] / rays[..., 2:]))


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
    terms = camera.lens.TERMS
    coefficients = _long_enough(camera.lens, np.array(camera.distortion, float), (*terms[:4], *names))
    lens = [index for index, name in enumerate(terms) if name in names]
    # Complex steps (Squire & Trapp 1998), all at once: derivatives without a difference, exact.
    steps = _TINY * 1j * np.eye(2 + coefficients.size)[[0, 1, *(2 + index for index in lens)]]
    lenses = (coefficients + steps[:, 2:]).T[..., None]
    ends = np.stack(
        camera.lens.project(points[:, 0] + steps[:, :1], points[:, 1] + steps[:, 1:2], 1.0, lenses), axis=-1
    )
    focal = np.asarray(camera.matrix)[(0, 1), (0, 1)]
    slopes = np.imag(ends) / _TINY * focal
    of_name = dict(zip((terms[index] for index in lens), slopes[2:], strict=True))
    of_name |= {"f": np.real(ends[0]) * focal, "aspect": np.real(ends[0]) * focal * [0, 1]}
    of_name |= {"cx": np.broadcast_to([1.0, 0.0], points.shape), "cy": np.broadcast_to([0.0, 1.0], points.shape)}
    moved = np.stack([of_name[name] for name in names]) if names else np.zeros((0, *points.shape))
    shape = rays.shape[:-1]
    by_ray = np.moveaxis(slopes[:2], 0, -1)
    return by_ray.reshape(*shape, 2, 2), moved.reshape(len(names), *shape, 2)
