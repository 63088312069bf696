"""A rig by chessboards that it saw: rows of their corners, and the length of their squares."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from stereorecal_boards import Board

from stereorecal.geometry import StereoRig
from stereorecal_field.judges._judgement import DEPTH_WORSE, ROWS_WORSE
from stereorecal_field.judges._optics import Pixels, optics
from stereorecal_field.judges._rows import row_differences

_FAR = 30  # baselines, at which depth is judged
_SIDE = 1.001  # of the shortest distance on a board: longer ones are no side of a square


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
        """By more than the tolerance, in rows or in what the length of squares says of depth at 30 baselines."""
        rows_worse = self.rows_rms_px > other.rows_rms_px + ROWS_WORSE
        after, before = (abs(one.depth_error_percent(_FAR)) for one in (self, other))
        return rows_worse or after > before + DEPTH_WORSE

    def depth_error_percent(self, baselines: float) -> float:
        """At a distance: what is wrong with squares, an offset of disparity, grows with it."""
        return self.squares_percent * baselines / self.baselines


def by_boards(judged: StereoRig, stored: StereoRig, boards: Sequence[Board]) -> ByBoards:
    """Rectify, triangulate, measure."""
    made = optics(judged)
    row_errors, lengths, depths = [], [], []
    for board in boards:
        left, right = made.left(np.asarray(board.left)), made.right(np.asarray(board.right))
        row_errors.append(row_differences(judged, stored, np.asarray(board.left), np.asarray(board.right)))
        points = _triangulated(made.focal, made.at_infinity, made.focal_baseline, made.made.P1[:2, 2], left, right)
        start, end = _sides(np.asarray(board.points))
        length = np.linalg.norm(np.subtract(*np.asarray(board.points)[[start[0], end[0]]]))
        lengths.append(np.linalg.norm(points[start] - points[end], axis=1) / length)
        depths.append(points[:, 2] / float(judged.baseline))
    rows, each = np.concatenate(row_errors), [100 * (np.median(some) - 1) for some in lengths]
    return ByBoards(
        rows_rms_px=float(np.sqrt(np.mean(rows**2))),
        rows_mean_px=float(rows.mean()),
        squares_percent=float(100 * (np.median(np.concatenate(lengths)) - 1)),
        squares_spread_percent=float(np.std(each, ddof=1)) if len(each) > 1 else 0.0,
        baselines=float(np.median(np.concatenate(depths))),
        boards=len(boards),
    )


def _triangulated(
    focal: float, at_infinity: float, focal_baseline: float, centre: np.ndarray, left: Pixels, right: Pixels
) -> Float[np.ndarray, "n 3"]:
    z = focal_baseline / (left[:, 0] - right[:, 0] - at_infinity)
    middle = np.column_stack([left[:, 0], (left[:, 1] + right[:, 1]) / 2]) - centre
    return np.column_stack([middle / focal, np.ones(len(z))]) * z[:, None]


def _sides(points: Float[np.ndarray, "n 3"]) -> tuple[Int[np.ndarray, "m"], Int[np.ndarray, "m"]]:
    """The ends of the sides of squares: of the corners that are nearest to each other."""
    distances = np.linalg.norm(points[:, None] - points, axis=-1)
    start, end = np.triu_indices(len(points), 1)
    shortest = distances[start, end].min()
    adjacent = distances[start, end] < _SIDE * shortest
    return start[adjacent], end[adjacent]
