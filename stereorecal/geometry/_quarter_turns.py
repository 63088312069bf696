"""Quarter turns of images, for rigs that stand otherwise than side by side and upright: as `np.rot90` turns them."""

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import Mat3, Vec3
from stereorecal._errors import InputError

Turns = tuple[int, int]  # quarter turns of the left and of the right image, 0 to 3, counter-clockwise
UPRIGHT = (0, 0)
_UPSIDE_DOWN = np.cos(np.radians(30.0))  # of the roll between the cameras: so near to half a turn
_VECTORS = (("p2", "p1"), ("s1", "s3"), ("s2", "s4"), ("tx", "ty"))  # coefficients that turn with the image, x and y
_SAID = {1: "90 degrees counter-clockwise", 2: "180 degrees", 3: "90 degrees clockwise"}


def turn_of(quarters: int) -> Float[np.ndarray, "3 3"]:
    """The rotation of a camera's frame to that of its turned image."""
    return np.linalg.matrix_power(np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), quarters % 4).astype(float)


def turned_size(size: tuple[int, int], quarters: int) -> tuple[int, int]:
    """(width, height) of the turned image."""
    return (size[1], size[0]) if quarters % 2 else size


def turned_pixels(pixels: Float[np.ndarray, "*n 2"], size: tuple[int, int], quarters: int) -> Float[np.ndarray, "*n 2"]:
    """Where pixels (column, row) of an image of `size` are in the turned one."""
    turn = turn_of(quarters)[:2, :2]
    last = np.where(turn.sum(axis=1) < 0.0, np.array(turned_size(size, quarters)) - 1.0, 0.0)
    return pixels @ turn.T + last


def turned_coefficients(
    coefficients: Float[np.ndarray, "c"], terms: tuple[str, ...], quarters: int
) -> Float[np.ndarray, "c"]:
    """Those of the same lens before the turned image.

    Args:
        terms: their names; after those of OpenCV's model come tx and ty.
    """
    found, names, turn = np.array(coefficients, float), (*terms, "tx", "ty"), turn_of(quarters)[:2, :2]
    if "s1" in names and found.size > 12 and quarters % 2 and np.all(found[12:]):
        raise InputError(
            "a sensor that is tilted about both axes (tx, ty) cannot be turned by 90 degrees; calibrate turned images, "
            "or without tilt."
        )
    for vector in _VECTORS:
        places = [names.index(name) for name in vector if name in names]
        if len(places) == 2 and max(places) < found.size:
            found[places] = turn @ found[places] + 0.0  # no -0
    return found


def turns_of(rotation: Mat3, translation: Vec3) -> Turns:
    """How far the images of two cameras, one above the other or one upside down, are turned to be those of a left
    and a right one; none where that makes no such rig."""
    R, (x, y, z) = np.asarray(rotation), np.asarray(translation)
    along, across = R[0, 0] + R[1, 1], R[1, 0] - R[0, 1]
    apart = 2 if along < -_UPSIDE_DOWN * np.hypot(along, across) else 0
    right = apart if x > max(abs(y), abs(z)) else 0
    if abs(y) > max(abs(x), abs(z)):
        right = 1 if y < 0.0 else 3
    return (right - apart) % 4, right


def described_turns(turns: Turns) -> str:
    """Why images are turned, and by how much."""
    sides = [(side, turn) for side, turn in zip(("the left", "the right"), turns, strict=True) if turn]
    sides = [("both", turns[0])] if turns[0] == turns[1] else sides
    done = ", ".join(f"{side} images are turned by {_SAID[turn]}" for side, turn in sides)
    why = "the cameras stand one above the other" if turns[0] == turns[1] else "one camera is upside down"
    return f"{why}: {done}"
