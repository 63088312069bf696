"""The plane: (x/z, y/z). Straight lines stay straight, and disparity is proportional to 1/z."""

from typing import Any

import numpy as np

NAME = "pinhole"
ABOUT = "a plane, below 165 degrees"
WIDEST = 165.0
USUAL = WIDEST


def edge(angle: float) -> float:
    """Its tangent."""
    return float(np.tan(angle))


def angle(edge: float) -> float:
    """Its arc tangent."""
    return float(np.arctan(edge))


def directions(u: Any, v: Any) -> tuple[Any, Any, Any]:
    """(u, v, 1)."""
    return u, v, 1.0


def shows(u: Any, v: Any) -> Any:
    """True: every point of the plane is that of a direction."""
    return True


def project(x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """(x/z, y/z)."""
    return x / z, y / z


def row(y: Any, z: Any) -> Any:
    """y/z."""
    return y / z


def row_slopes(y: Any, z: Any) -> tuple[Any, Any]:
    """1/z and -y/z²."""
    inverse = 1.0 / z
    return inverse, -y * inverse * inverse


def stretch(y: Any, z: Any, length: Any) -> Any:
    """1."""
    return 1.0


def length(x: Any, y: Any, z: Any) -> Any:
    """Depth, z."""
    return z


def nearness(left: Any, right: Any) -> Any:
    """The disparity."""
    return left - right
