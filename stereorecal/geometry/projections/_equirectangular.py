"""Angles about the baseline: rows are those of epipolar planes, columns those from the plane that stands across it.

Up to 180 degrees across, where the baseline itself points, and all around in rows. OpenCV's `omnidir` calls it
longitude and latitude, mrcal `LENSMODEL_LATLON`.
"""

from typing import Any

import numpy as np

from stereorecal._arrays import namespace

NAME = "equirectangular"
ABOUT = "angles about the baseline, up to 180 degrees across"
WIDEST = 180.0
USUAL = 160.0  # beyond, the baseline is a sixth of what it is in the middle


def edge(angle: float) -> float:
    """The angle."""
    return angle


def angle(edge: float) -> float:
    """The angle."""
    return edge


def directions(u: Any, v: Any) -> tuple[Any, Any, Any]:
    """Unit vectors."""
    xp = namespace(u, v)
    u = xp.clip(u, -0.5 * np.pi, 0.5 * np.pi)
    across = xp.cos(u)
    return xp.sin(u), across * xp.sin(v), across * xp.cos(v)


def shows(u: Any, v: Any) -> Any:
    """Within the poles, and once around."""
    return (abs(u) <= 0.5 * np.pi) & (abs(v) <= np.pi)


def project(x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """The angle towards the baseline and the one about it."""
    xp = namespace(x, y, z)
    return xp.arctan(x / xp.sqrt(y * y + z * z)), row(y, z)


def row(y: Any, z: Any) -> Any:
    """The angle about the baseline: atan2(y, z), written so that it is analytic."""
    xp = namespace(y, z)
    return 2.0 * xp.arctan(y / (z + xp.sqrt(y * y + z * z)))


def row_slopes(y: Any, z: Any) -> tuple[Any, Any]:
    """z and -y over y² + z²."""
    squared = y * y + z * z
    return z / squared, -y / squared


def stretch(y: Any, z: Any, length: Any) -> Any:
    """Over the cosine of the angle from the plane across the baseline."""
    return length / namespace(y, z).sqrt(y * y + z * z)


def length(x: Any, y: Any, z: Any) -> Any:
    """Distance."""
    return namespace(x, y, z).sqrt(x * x + y * y + z * z)


def nearness(left: Any, right: Any) -> Any:
    """The sine of the angle at the point over that at the right camera: law of sines."""
    xp = namespace(left, right)
    return xp.sin(left - right) / xp.cos(right)
