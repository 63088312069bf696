"""What a calibration left, given the boards that it was made from.

They were seen before the rig drifted, so they tell of what the calibration left and nothing of the drift. Gauss-Newton
on the reprojections of all corners in both cameras; what the poses of the boards explain is taken out of the rows.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal import CalibrationCovariance, InputError, StereoRig
from stereorecal.estimation import (
    Mixture,
    Normal,
    as_prior,
    physical_prior,
    rig_parameters,
    updated,
)
from stereorecal.geometry import turned_pixels
from stereorecal.objectives import BASELINE, RigChart
from stereorecal_boards._board import Board
from stereorecal_boards._checks import check_fitted, check_given, check_inside
from stereorecal_boards._noise import corner_errors, deviation, inliers, noise
from stereorecal_boards._poses import BoardRows, Posed, posed, rows_without_poses

_ROUNDS, _OF_POSES = 20, 5
_SETTLED = 0.05  # standard deviations of θ
# How much worse than its noise a set of boards may be as a whole, told apart by the evidence of the images: no print is
# quite flat.
_WORSE = (1.0, 2.0)


def covariance_of_boards(
    rig: StereoRig, boards: Sequence[Board], prior: CalibrationCovariance | None = None, *, squares: float = 0.15
) -> CalibrationCovariance:
    """By how much the true rig probably differs from its calibration, and how sure that is: `prior=` of a repair.

    Args:
        rig: the calibration that was made with these boards.
        boards: as its cameras saw them before it drifted, of `find_boards`, `find_charuco` or your own; at least one.
        prior: what is known of the calibration beside them; by default no more than what is physical.
        squares: standard deviation of the length of the squares, percent: no board tells the length of the baseline
            better.

    Raises:
        InputError: if there is no board, one lies outside of the images, or they do not fit the rig.
    """
    if not isinstance(boards, Sequence) or not all(isinstance(board, Board) for board in boards):
        raise InputError("boards holds something else than boards; give find_boards(pairs), or a list of Board.")
    rig, boards = rig.side_by_side(), tuple(_turned(rig.side_by_side(), board) for board in boards)
    chart = rig_parameters(rig)
    check_inside(chart, boards)
    known = physical_prior(chart, squares) if prior is None else as_prior(prior, chart)
    joint = _with_squares(known, chart, squares)
    normal = _likelihood(chart, _at_best_poses(chart, posed(rig, boards)), joint)
    several = [updated(joint, Normal(normal.a / k**2, normal.b / k**2, normal.c / k**2)) for k in _WORSE]
    weights, *parts = (
        np.concatenate([getattr(one, name) for one in several]) for name in ("weights", "means", "covariances")
    )
    all_of_x = Mixture(weights / weights.sum(), *parts)
    told = np.flatnonzero(np.diag(all_of_x.covariance)[: chart.dim] > 0.0)
    names = [chart.names[index] for index in told]
    return CalibrationCovariance(names, all_of_x.covariance[np.ix_(told, told)], all_of_x.mean[told])


def _turned(rig: StereoRig, board: Board) -> Board:
    """A board as images show it that are turned as the rig's."""
    left, right = (
        turned_pixels(np.asarray(pixels), size, turn)
        for pixels, size, turn in zip((board.left, board.right), rig.sizes_taken, rig.turns, strict=True)
    )
    return replace(board, left=left, right=right)


def _with_squares(prior: Mixture, chart: RigChart, squares: float) -> Mixture:
    """The prior of x: θ and the error of the squares' length in percent. The calibration was made with these boards:
    what its baseline errs by for their sake is that error, so far as the prior lets it err."""
    length, (one,) = chart.names.index(BASELINE), prior.roots
    other_rows = np.delete(one, length, axis=0)
    scales = np.linalg.norm(other_rows, axis=1, keepdims=True)
    other_rows = other_rows / np.where(scales > 0.0, scales, 1.0)
    alone = one[length] - np.linalg.lstsq(other_rows.T, one[length], rcond=None)[0] @ other_rows
    common = np.zeros((chart.dim, 1))
    common[length] = squares * min(squares, float(np.linalg.norm(alone)))
    covariance = np.block([[one @ one.T, common], [common.T, np.full((1, 1), squares**2)]])
    return Mixture(np.ones(1), np.column_stack([prior.means, np.zeros(1)]), covariance[None])


def _at_best_poses(chart: RigChart, posed_boards: Posed) -> Posed:
    """Where the boards are by both cameras, if the given rig is the truth.

    Raises:
        InputError: if they are nowhere.
    """
    width, nothing = chart.rig.left.size[0], np.zeros((len(posed_boards.board), 4, 0))
    for _ in range(_OF_POSES):
        counted = inliers(corner_errors(posed_boards.residual(chart.rig)), width)
        posed_boards = posed_boards.moved(rows_without_poses(posed_boards, chart.rig, nothing, counted).steps)
    check_given(chart, posed_boards)
    return posed_boards


def _likelihood(chart: RigChart, posed_boards: Posed, prior: Mixture) -> Normal:
    """The likelihood of x, linear where it is most probable.

    Raises:
        InputError: if the boards do not fit even there.
    """
    width, length = chart.rig.left.size[0], chart.names.index(BASELINE)
    # The rig that boards of nominal squares are seen by: longer squares are a shorter baseline.
    seen_by = np.column_stack([np.eye(chart.dim), -np.eye(chart.dim)[length]])
    x, sigma = np.zeros(chart.dim + 1), deviation(corner_errors(posed_boards.residual(chart.rig)), width)
    rounds = 0
    while True:
        rig = chart.rig_at(seen_by @ x)
        counted = inliers(corner_errors(posed_boards.residual(rig)), width)
        rows = rows_without_poses(posed_boards, rig, posed_boards.by_rig(chart, seen_by @ x) @ seen_by, counted)
        sigma = noise(rows, prior.roots[int(prior.weights.argmax())], sigma, width)
        normal = _normal(rows, x, sigma)
        found = updated(prior, normal)
        best = int(found.weights.argmax())
        move, spread = found.means[best] - x, found.roots[best]
        x, posed_boards = found.means[best], posed_boards.moved(rows.steps - rows.follows @ move)
        rounds += 1
        if rounds == _ROUNDS or (np.abs(move) < _SETTLED * np.linalg.norm(spread, axis=1)).all():
            break
    check_fitted(chart, posed_boards, seen_by @ x, float(np.linalg.norm((seen_by @ spread)[length])))
    return normal


def _normal(rows: BoardRows, x: Float[np.ndarray, "n"], sigma: float) -> Normal:
    """The likelihood of corners, linear at x."""
    jacobian, at_zero = rows.jacobian / sigma, (rows.residual - rows.jacobian @ x) / sigma
    return Normal(jacobian.T @ jacobian, -jacobian.T @ at_zero, float(at_zero @ at_zero))
