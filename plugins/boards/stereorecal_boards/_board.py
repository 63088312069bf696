"""A calibration board that both cameras saw: its corners in both images, and on the board."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal import InputError

FEWEST = 6  # corners: a pose takes three of them
_THIN = 1e-3  # of the length: what is narrower is a line, and has no pose
_SIZES = (0.005, 20.0)  # metres, of a board


@dataclass(frozen=True, eq=False)
class Board:
    """A board, or another target of known shape, as a pair of images shows it; `find_boards` finds chessboards.

    Attributes:
        left, right: (n, 2) float64, pixels (column, row) of its corners in the left and the right image as they were
            taken, in the same order; corners that only one camera sees stay out.
        points: (n, 3) float64, the same corners in the frame of the board, metres.

    Raises:
        InputError: if shapes do not fit, numbers are not finite, there are fewer than 6 corners, all lie on one line,
            or the board is smaller than 5 mm or larger than 20 m.
    """

    left: Float[np.ndarray, "..."]
    right: Float[np.ndarray, "..."]
    points: Float[np.ndarray, "..."]

    def __post_init__(self) -> None:
        left, right, points = (np.array(values, float) for values in (self.left, self.right, self.points))
        if left.ndim != 2 or not left.shape == right.shape == (len(points), 2) or points.shape[1:] != (3,):
            raise InputError(
                f"a board has left {left.shape}, right {right.shape} and points {points.shape}; give (n, 2), (n, 2) "
                "and (n, 3) for the same n corners."
            )
        if len(points) < FEWEST:
            raise InputError(f"a board has {len(points)} corners; give at least {FEWEST}.")
        if not all(np.isfinite(values).all() for values in (left, right, points)):
            raise InputError("a board has corners that are NaN or infinite; leave out those that were not found.")
        _, lengths, _ = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        if lengths[1] <= _THIN * lengths[0]:
            raise InputError("the corners of a board lie on one line; give several rows of them.")
        size = float(np.ptp(points, axis=0).max())
        if not _SIZES[0] < size < _SIZES[1]:
            raise InputError(f"a board is {size:.3g} m large; give its points in metres.")
        for name, values in (("left", left), ("right", right), ("points", points)):
            object.__setattr__(self, name, values)
