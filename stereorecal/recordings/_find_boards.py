"""Chessboards in pairs of images."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from stereorecal._cv2 import cv2
from stereorecal._errors import InputError
from stereorecal.recordings._as_pairs import Pairs, as_pairs
from stereorecal.recordings._board import Board

_FEWEST = 3  # corners in a row, as OpenCV wants them
_OF_SQUARE, _WINDOWS = 0.25, (2, 10)  # half of the window in which a corner is refined: of a square; pixels
_UNTIL = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 50, 1e-3)  # steps, pixels


def find_boards(pairs: Pairs, corners: tuple[int, int] = (9, 6), square: float = 0.03) -> tuple[Board, ...]:
    """The chessboards that both images of a pair show; pairs without one are skipped.

    Args:
        pairs: images of the calibration, as they were taken.
        corners: inner corners in a row and in a column; a board of 10 by 7 squares has (9, 6).
        square: length of the side of a square, metres: the one that the calibration was made with.

    Raises:
        InputError: if no pair shows such a board, or corners or square make no sense.
    """
    if len(corners) != 2 or any(int(number) != number or number < _FEWEST for number in corners):
        raise InputError(f"corners is {corners}; give those inside of the board, such as (9, 6) for 10 by 7 squares.")
    if not 0.0 < square < np.inf:
        raise InputError(f"square is {square}; give the length of the side of a square in metres, such as 0.03.")
    pairs, (columns, rows) = as_pairs(pairs), (int(number) for number in corners)
    flat = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    points = square * np.column_stack([flat, np.zeros(len(flat))])
    found = []
    for pair in pairs:
        left = _corners(pair.left, columns, rows)
        right = None if left is None else _corners(pair.right, columns, rows)
        if left is not None and right is not None:
            # The right camera sees the board shifted, and slightly tilted.
            same = min(_turned(right), key=lambda one: float(np.std(one - left, axis=(0, 1)).sum()))
            found.append(Board(left.reshape(-1, 2), same.reshape(-1, 2), points))
    if not found:
        raise InputError(
            f"none of {len(pairs)} pairs shows a chessboard with {columns}x{rows} inner corners in both images; check "
            "how many corners the board has inside, and that all of it is seen."
        )
    return tuple(found)


def _corners(image: Float[np.ndarray, "h w"], columns: int, rows: int) -> Float[np.ndarray, "rows columns 2"] | None:
    grey = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
    complete, found = cv2.findChessboardCornersSB(grey, (columns, rows), flags=flags)
    if not complete:
        return None
    # At the rim of a board OpenCV's finder is off by up to half a pixel.
    rough = np.asarray(found, np.float32).reshape(rows, columns, 2)
    steps = min(float(np.linalg.norm(np.diff(rough, axis=axis), axis=-1).min()) for axis in (0, 1))
    half = int(np.clip(_OF_SQUARE * steps, *_WINDOWS))
    fine = cv2.cornerSubPix(grey, rough.reshape(-1, 1, 2).copy(), (half, half), (-1, -1), _UNTIL)
    return np.asarray(fine, float).reshape(rows, columns, 2)


def _turned(found: Float[np.ndarray, "rows columns 2"]) -> Iterator[Float[np.ndarray, "rows columns 2"]]:
    """The orders in which the same board may be read: by half turns; by quarter turns where it has as many rows as
    columns."""
    step = 1 if found.shape[0] == found.shape[1] else 2
    yield from (np.rot90(found, turns) for turns in range(0, 4, step))
