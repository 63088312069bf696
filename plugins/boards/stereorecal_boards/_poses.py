"""Corners of boards as rows: linear near a rig and the poses of the boards, which each board's rows then go without."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.estimation import pixels_of, slopes_by_point, slopes_of
from stereorecal.geometry import StereoRig, rotation_from_vector
from stereorecal.objectives import RigChart
from stereorecal_boards._board import Board

_FLAT = 1e-6  # of its size: a board that is no thicker is plane
_FEWEST = 4  # corners in both images: from fewer a pose is guessed


@dataclass(frozen=True, eq=False)
class Posed:
    """The n corners of b boards, and where the boards are.

    Attributes:
        pixels: (n, 4) in the left and the right image, as they were found.
        points: (n, 3) metres, on their board, about its middle.
        board: (n,) which one it is.
        rotations, shifts: (b, 3, 3), (b, 3): from the frames of the boards to that of the left camera, metres.
    """

    pixels: Float[np.ndarray, "n 4"]
    points: Float[np.ndarray, "n 3"]
    board: Int[np.ndarray, "n"]
    rotations: Float[np.ndarray, "b 3 3"]
    shifts: Float[np.ndarray, "b 3"]

    @property
    def _arms(self) -> Float[np.ndarray, "n 3"]:
        """From the middle of its board to each corner, in the frame of the left camera."""
        return np.einsum("nij,nj->ni", self.rotations[self.board], self.points)

    @property
    def _corners(self) -> Float[np.ndarray, "n 3"]:
        return self._arms + self.shifts[self.board]

    def residual(self, rig: StereoRig) -> Float[np.ndarray, "n 4"]:
        """Reprojection errors, pixels."""
        return pixels_of(rig, self._corners) - self.pixels

    def by_rig(self, chart: RigChart, theta: Float[np.ndarray, "p"]) -> Float[np.ndarray, "n 4 p"]:
        """Derivatives of the residual by θ."""
        return np.moveaxis(slopes_of(chart, theta, self._corners), 0, -1)

    def by_pose(self, rig: StereoRig) -> Float[np.ndarray, "n 4 6"]:
        """Derivatives by a turn of its board about its middle, and by a shift as a share of the distance."""
        corners, arms = self._corners, self._arms
        distance = np.linalg.norm(self.shifts, axis=1)[self.board][:, None]
        by_point = slopes_by_point(rig, corners) * distance[..., None]
        turns = np.stack([np.cross(axis, arms) for axis in np.eye(3)], axis=-1) / distance[..., None]
        return np.concatenate([by_point @ turns, by_point], axis=-1)

    def moved(self, steps: Float[np.ndarray, "b 6"]) -> "Posed":
        """With the boards turned and shifted."""
        turns = np.stack([np.asarray(rotation_from_vector(step)) for step in steps[:, :3]])
        distance = np.linalg.norm(self.shifts, axis=1)[:, None]
        return replace(self, rotations=turns @ self.rotations, shifts=self.shifts + distance * steps[:, 3:])


def posed(rig: StereoRig, boards: Sequence[Board]) -> Posed:
    """Boards where they look best in the left image, or, of two poses that look alike there, in both."""
    number = np.repeat(np.arange(len(boards)), [len(board.points) for board in boards])
    pixels = np.concatenate([np.column_stack([board.left, board.right]) for board in boards])
    points = np.concatenate([board.points - board.points.mean(axis=0) for board in boards])
    poses = [_pose(rig, pixels[number == index], points[number == index]) for index in range(len(boards))]
    return Posed(pixels, points, number, np.stack([r for r, _ in poses]), np.stack([t for _, t in poses]))


def _pose(
    rig: StereoRig, pixels: Float[np.ndarray, "n 4"], points: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
    lengths = np.linalg.svd(points, compute_uv=False)
    flag = cv2.SOLVEPNP_IPPE if lengths[2] <= _FLAT * lengths[0] else cv2.SOLVEPNP_SQPNP
    rays = np.ascontiguousarray(np.asarray(rig.left.rays(pixels[:, :2]))[:, :2])
    found = cv2.solvePnPGeneric(points, rays, np.eye(3), np.zeros(0), flags=flag)
    poses = [
        (np.asarray(rotation_from_vector(turn.ravel())), shift.ravel())
        for turn, shift in zip(found[1], found[2], strict=True)
    ]

    def median_error(pose) -> float:
        at = pixels_of(rig, points @ pose[0].T + pose[1])
        return float(np.median(np.abs(at - pixels)))

    return min(poses, key=median_error)


@dataclass(frozen=True, eq=False)
class BoardRows:
    """The rows of corners that count, without what the poses of their boards explain.

    Attributes:
        jacobian: (r, p), by the rig's parameters.
        residual: (r,) pixels.
        board: (r,) of each row.
        boards: how many count.
        steps, follows: (b, 6), (b, 6, p): `steps - follows @ move` is how poses follow a move of the rig's parameters.
    """

    jacobian: Float[np.ndarray, "r p"]
    residual: Float[np.ndarray, "r"]
    board: Int[np.ndarray, "r"]
    boards: int
    steps: Float[np.ndarray, "b 6"]
    follows: Float[np.ndarray, "b 6 p"]


def rows_without_poses(
    posed_boards: Posed, rig: StereoRig, by_rig: Float[np.ndarray, "n 4 p"], counted: Bool[np.ndarray, "n"]
) -> BoardRows:
    """The rows near a rig.

    Args:
        by_rig: derivatives of the residual.
        counted: the corners that count; of a board with fewer than four of them, none does.
    """
    residual, by_pose = posed_boards.residual(rig), posed_boards.by_pose(rig)
    boards, size = len(posed_boards.shifts), by_rig.shape[-1]
    steps, follows = np.zeros((boards, 6)), np.zeros((boards, 6, size))
    unexplained, numbers = [np.zeros((0, size + 1))], [np.zeros(0, int)]
    for index in range(boards):
        which = (posed_boards.board == index) & counted
        if which.sum() < _FEWEST:
            continue
        rows = np.concatenate([by_rig[which], residual[which][..., None]], axis=-1).reshape(-1, size + 1)
        axes, upper = np.linalg.qr(by_pose[which].reshape(-1, 6))
        explained = axes.T @ rows
        solved = np.linalg.lstsq(upper, explained, rcond=None)[0]
        steps[index], follows[index] = -solved[:, -1], solved[:, :-1]
        unexplained.append(rows - axes @ explained)
        numbers.append(np.full(len(rows), index))
    rows = np.concatenate(unexplained)
    return BoardRows(rows[:, :-1], rows[:, -1], np.concatenate(numbers), len(unexplained) - 1, steps, follows)
