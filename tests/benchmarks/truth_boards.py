"""A rig by chessboards that it saw: rows of their corners, and the length of their squares."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from truth_optics import optics
from truth_rows import row_differences

import stereorecal as sr

FOLDER = "boofcv_bumblebee2/calibration_chess"
_GRID = (4, 6)  # inner corners of 5 x 7 squares
_SQUARE = 0.030  # metres
_ROWS_WORSE, _SQUARES_WORSE = 0.05, 0.12  # px; percentage points, which are one of depth at 30 baselines
_FLAGS = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY


@dataclass(frozen=True, eq=False)
class Board:
    """Corners (6, 4, 2) of one board in both raw images."""

    name: str
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True)
class ByBoards:
    """What a rig makes of the boards.

    Attributes:
        rows_rms_px, rows_mean_px: of all corners, row differences [px of the stored left camera].
        squares_percent: median length of the sides of squares, relative to the true one.
        squares_spread_percent: standard deviation over boards of each one's median.
        baselines: median distance of the corners.
        boards: how many there are.
    """

    rows_rms_px: float
    rows_mean_px: float
    squares_percent: float
    squares_spread_percent: float
    baselines: float
    boards: int

    def worse_than(self, other: "ByBoards") -> bool:
        """By more than the tolerance, in rows or in the length of squares."""
        rows_worse = self.rows_rms_px > other.rows_rms_px + _ROWS_WORSE
        return rows_worse or abs(self.squares_percent) > abs(other.squares_percent) + _SQUARES_WORSE


def found_boards(folder: Path) -> list[Board]:
    """Those whose corners are all found in both images, in the same order."""
    boards = []
    for file in sorted(folder.glob("left*.jpg")):
        ends = [_corners(file), _corners(file.with_name(file.name.replace("left", "right")))]
        if any(end is None for end in ends):
            continue
        left, right = (np.asarray(end) for end in ends)
        turned = right[::-1, ::-1]  # a board of odd by odd squares looks the same upside down
        right = min((right, turned), key=lambda end: float((end - left).std(axis=(0, 1)).sum()))
        boards.append(Board(file.stem, left, right))
    return boards


def _corners(file: Path) -> np.ndarray | None:
    image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    there, corners = cv2.findChessboardCornersSB(image, _GRID, flags=_FLAGS)
    return corners.reshape(_GRID[1], _GRID[0], 2).astype(float) if there else None


def by_boards(judged: sr.StereoRig, stored: sr.StereoRig, boards: list[Board]) -> ByBoards:
    """Rectify, triangulate, measure."""
    made = optics(judged)
    apart, lengths, far = [], [], []
    for board in boards:
        left, right = made.left(board.left.reshape(-1, 2)), made.right(board.right.reshape(-1, 2))
        apart.append(row_differences(judged, stored, board.left.reshape(-1, 2), board.right.reshape(-1, 2)))
        z = made.focal_baseline / (left[:, 0] - right[:, 0] - made.at_infinity)
        middle = np.column_stack([left[:, 0], (left[:, 1] + right[:, 1]) / 2]) - made.made.P1[:2, 2]
        points = (np.column_stack([middle / made.focal, np.ones(len(z))]) * z[:, None]).reshape(
            *board.left.shape[:2], 3
        )
        sides = [np.linalg.norm(np.diff(points, axis=axis), axis=-1).ravel() for axis in (0, 1)]
        lengths.append(np.concatenate(sides))
        far.append(z / float(judged.baseline))
    rows, each = np.concatenate(apart), [100 * (np.median(some) / _SQUARE - 1) for some in lengths]
    return ByBoards(
        rows_rms_px=float(np.sqrt(np.mean(rows**2))),
        rows_mean_px=float(rows.mean()),
        squares_percent=float(100 * (np.median(np.concatenate(lengths)) / _SQUARE - 1)),
        squares_spread_percent=float(np.std(each, ddof=1)),
        baselines=float(np.median(np.concatenate(far))),
        boards=len(boards),
    )
