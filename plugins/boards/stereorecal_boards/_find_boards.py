"""Chessboards and ChArUco boards in pairs of images."""

from collections.abc import Iterator

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.recordings import Pairs, as_pairs
from stereorecal_boards._board import FEWEST, Board

_IN_A_ROW = 3  # corners, as OpenCV wants them
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
    if len(corners) != 2 or any(int(number) != number or number < _IN_A_ROW for number in corners):
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


def find_charuco(pairs: Pairs, board: cv2.aruco.CharucoBoard) -> tuple[Board, ...]:
    """The ChArUco boards that both images of a pair show, in part or whole; pairs without one are skipped.

    Args:
        pairs: images of the calibration, as they were taken.
        board: OpenCV's, with lengths in metres.

    Raises:
        InputError: if no pair shows at least six of its corners in both images.
    """
    detector, pairs, found = cv2.aruco.CharucoDetector(board), as_pairs(pairs), []
    points = np.asarray(board.getChessboardCorners(), float)
    for pair in pairs:
        seen = []
        for image in (pair.left, pair.right):
            corners, numbers, *_ = detector.detectBoard(_grey(image))
            seen.append({} if numbers is None else dict(zip(numbers.ravel(), corners.reshape(-1, 2), strict=True)))
        both = sorted(seen[0].keys() & seen[1].keys())
        if len(both) >= FEWEST and np.ptp(points[both][:, :2], axis=0).all():
            left, right = (np.array([one[number] for number in both], float) for one in seen)
            found.append(Board(left, right, points[both]))
    if not found:
        raise InputError(f"none of {len(pairs)} pairs shows the ChArUco board in both images; check its description.")
    return tuple(found)


def _grey(image: Float[np.ndarray, "h w"]) -> np.ndarray:
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def _corners(image: Float[np.ndarray, "h w"], columns: int, rows: int) -> Float[np.ndarray, "rows columns 2"] | None:
    grey = _grey(image)
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
