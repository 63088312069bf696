"""The prior of a calibration, given the boards that it was made from.

They were seen before the rig drifted, so they tell of what the calibration left and nothing of the drift. Gauss-Newton
on the reprojections of all corners in both cameras; what the poses of the boards explain is taken out of the rows.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.estimation._board_checks import check_fitted, check_given, check_inside
from stereorecal.estimation._board_noise import corner_errors, deviation, inliers, noise
from stereorecal.estimation._board_poses import BoardRows, Posed, posed, rows_without_poses
from stereorecal.estimation._calibration_prior import SQUARES, CalibrationPrior, physical_prior
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._posterior import root
from stereorecal.estimation._prior_choice import DEFAULT, Prior, as_prior, check_prior, is_exact
from stereorecal.estimation._prior_conversions import updated
from stereorecal.geometry import turned_pixels
from stereorecal.objectives import BASELINE, RigChart
from stereorecal.recordings import Board

_ROUNDS, _OF_POSES = 20, 5
_SETTLED = 0.05  # standard deviations of θ
_LEAST = 1e-3  # of the weight of all normal distributions: below, one is dropped
# How much worse than its noise a set of boards may be as a whole, told apart by the evidence of the images: no print is
# quite flat.
_WORSE = (1.0, 2.0)


def with_boards(prior: Prior, boards: Sequence[Board] | None, chart: RigChart) -> Prior:
    """The prior that users choose, given the boards of the calibration, if there are any.

    They take the place of the default, which stands for such boards; whatever else is said of the calibration counts
    beside them.

    Raises:
        InputError: as `check_prior`, `check_boards` and `prior_of_boards`.
    """
    check_prior(prior, chart)
    check_boards(boards, prior)
    if boards is None:
        return prior
    left, right = chart.rig.turns
    boards = [
        replace(
            board,
            left=turned_pixels(np.asarray(board.left), chart.rig.sizes_taken[0], left),
            right=turned_pixels(np.asarray(board.right), chart.rig.sizes_taken[1], right),
        )
        for board in boards
    ]
    known_before = physical_prior(chart) if prior is None or prior == DEFAULT else as_prior(prior, chart)
    return prior_of_boards(chart, boards, known_before)


def prior_of_boards(chart: RigChart, boards: Sequence[Board], prior: CalibrationPrior) -> CalibrationPrior:
    """The prior, given the corners of the boards of the calibration.

    Args:
        chart: of the given rig, which saw the boards but for what its calibration left.
        boards: at least one.
        prior: what is known without them.

    Raises:
        InputError: if there is no board, one lies outside of the images, or they do not fit the rig.
    """
    check_inside(chart, boards)
    joint, n = _with_squares(prior, chart), chart.dim
    normal = _likelihood(chart, _at_best_poses(chart, posed(chart.rig, boards)), joint)
    several = [updated(joint, Normal(normal.a / k**2, normal.b / k**2, normal.c / k**2)) for k in _WORSE]
    weights = np.concatenate([one.weights for one in several]) / len(several)
    significant = weights > _LEAST
    roots = np.concatenate([one.roots for one in several])[significant, :n]
    means = np.concatenate([one.means for one in several])[significant, :n]
    return CalibrationPrior(
        np.stack([root(one @ one.T) for one in roots]), weights[significant] / weights[significant].sum(), means=means
    )


def check_boards(boards: Sequence[Board] | None, prior: Prior) -> None:
    """Refuse what are no boards, and boards beside intrinsics that are exact.

    Raises:
        InputError: says what to do.
    """
    if boards is None:
        return
    if not isinstance(boards, Sequence) or not all(isinstance(board, Board) for board in boards):
        raise InputError("boards holds something else than boards; give sr.find_boards(pairs), or a list of sr.Board.")
    if is_exact(prior):
        raise InputError(
            'boards determine the errors that the calibration left, and prior="exact" says that there are none; '
            "give one."
        )


def _with_squares(prior: CalibrationPrior, chart: RigChart) -> CalibrationPrior:
    """Of x: θ and the error of the squares' length in percent. The calibration was made with these boards: what its
    baseline errs by for their sake is that error, so far as the prior lets it err."""
    length, roots = chart.names.index(BASELINE), []
    for one in prior.roots:
        other_rows = np.delete(one, length, axis=0)
        scales = np.linalg.norm(other_rows, axis=1, keepdims=True)
        other_rows = other_rows / np.where(scales > 0.0, scales, 1.0)
        alone = one[length] - np.linalg.lstsq(other_rows.T, one[length], rcond=None)[0] @ other_rows
        common = np.zeros((chart.dim, 1))
        common[length] = SQUARES * min(SQUARES, float(np.linalg.norm(alone)))
        roots.append(root(np.block([[one @ one.T, common], [common.T, np.full((1, 1), SQUARES**2)]])))
    return replace(prior, roots=np.stack(roots), means=np.column_stack([prior.means, np.zeros(len(roots))]))


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


def _likelihood(chart: RigChart, posed_boards: Posed, prior: CalibrationPrior) -> Normal:
    """Of x, linear where it is most probable.

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
