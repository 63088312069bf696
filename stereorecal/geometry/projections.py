"""Projections of views: how directions become columns and rows, and disparities distances."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._arrays import namespace
from stereorecal._errors import checked_choice


@dataclass(frozen=True, eq=False)
class Projection:
    """The functions of one projection, of both cameras of a view. Image points (u, v) are pixels less the principal
    point, over the focal length; directions (x, y, z) have any length, in the rectified frame, the baseline along x. A
    row v depends on y and z alone, so that epipolar planes are rows. All functions take NumPy arrays (float64) or JAX
    arrays (float32, traced, differentiable) and answer in kind; near the middle all projections are the same.

    Attributes:
        widest: the largest field that a view may show across, in degrees.
        usual: the largest field that a view shows unless more is asked for, in degrees.
        edge: the image point of a direction so many radians off the middle, along the columns.
        directions: x, y and z of image points u, v. Beyond what the projection shows, those of its edge.
        shows: whether image points are those of directions; True if all are.
        project: u and v of directions; analytic, so that complex steps differentiate it.
        row: v alone, of y and z; analytic as `project`.
        stretch: by how much rows of directions y, z, of a length, are wider apart than they are in the middle: by as
            much, what lies there has less disparity than it would have in the middle.
        length: of a vector, in lengths of `directions`; analytic as `project`.
        nearness: baselines over the `length` from the left camera to the point that both cameras see at columns u,
            left and right. Zero or less: infinitely far away. Analytic as `project`.
    """

    widest: float
    usual: float
    edge: Callable[[float], float]
    directions: Callable[[Any, Any], tuple[Any, Any, Any]]
    shows: Callable[[Any, Any], Any]
    project: Callable[[Any, Any, Any], tuple[Any, Any]]
    row: Callable[[Any, Any], Any]
    stretch: Callable[[Any, Any, Any], Any]
    length: Callable[[Any, Any, Any], Any]
    nearness: Callable[[Any, Any], Any]


def projection(name: str) -> Projection:
    """The projection of that name.

    Raises:
        InputError: if there is none.
    """
    return _PROJECTIONS[checked_choice(name, NAMES, "projection")]


def _sphere_directions(u: Any, v: Any) -> tuple[Any, Any, Any]:
    """Unit vectors."""
    xp = namespace(u, v)
    u = xp.clip(u, -0.5 * np.pi, 0.5 * np.pi)
    across = xp.cos(u)
    return xp.sin(u), across * xp.sin(v), across * xp.cos(v)


def _sphere_point(x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """The angle towards the baseline and the one about it."""
    xp = namespace(x, y, z)
    return xp.arctan(x / xp.sqrt(y * y + z * z)), _sphere_row(y, z)


def _sphere_row(y: Any, z: Any) -> Any:
    """The angle about the baseline: atan2(y, z), written so that it is analytic."""
    xp = namespace(y, z)
    return 2.0 * xp.arctan(y / (z + xp.sqrt(y * y + z * z)))


def _sphere_nearness(left: Any, right: Any) -> Any:
    """The sine of the angle at the point over that at the right camera: law of sines."""
    xp = namespace(left, right)
    return xp.sin(left - right) / xp.cos(right)


_PROJECTIONS = {
    # The plane (x/z, y/z): straight lines stay straight, and disparity is proportional to 1/z.
    "pinhole": Projection(
        widest=165.0,
        usual=165.0,
        edge=lambda angle: float(np.tan(angle)),
        directions=lambda u, v: (u, v, 1.0),
        shows=lambda u, v: True,
        project=lambda x, y, z: (x / z, y / z),
        row=lambda y, z: y / z,
        stretch=lambda y, z, length: 1.0,
        length=lambda x, y, z: z,
        nearness=lambda left, right: left - right,
    ),
    # Angles about the baseline: rows are those of epipolar planes, columns those from the plane that stands across it;
    # up to 180 degrees across, where the baseline itself points, and all around in rows. OpenCV's `omnidir` calls it
    # longitude and latitude, mrcal `LENSMODEL_LATLON`.
    "equirectangular": Projection(
        widest=180.0,
        usual=160.0,  # beyond, the baseline is a sixth of what it is in the middle
        edge=lambda angle: angle,
        directions=_sphere_directions,
        shows=lambda u, v: (abs(u) <= 0.5 * np.pi) & (abs(v) <= np.pi),
        project=_sphere_point,
        row=_sphere_row,
        stretch=lambda y, z, length: length / namespace(y, z).sqrt(y * y + z * z),
        length=lambda x, y, z: namespace(x, y, z).sqrt(x * x + y * y + z * z),
        nearness=_sphere_nearness,
    ),
}
NAMES = tuple(_PROJECTIONS)
