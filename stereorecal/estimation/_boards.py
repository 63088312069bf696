"""What a calibration left, given the boards that it was made from.

They were seen before the rig drifted, so they tell of what the calibration left and nothing of the drift. Gauss-Newton
on the reprojections of all corners in both cameras; what the poses of the boards explain is taken out of the rows.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import InputError
from stereorecal.estimation._board_poses import BoardRows, Posed, posed, rows_without_poses
from stereorecal.estimation._calibration_prior import SQUARES, CalibrationPrior
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._posterior import root
from stereorecal.objectives import BASELINE, RigChart
from stereorecal.recordings import Board

_WIDTH = 640
_FLOOR = 0.05  # pixels, standard deviation of a corner in an image 640 wide: no corner is found better
_ROUNDS, _OF_POSES = 20, 5
_SETTLED = 0.05  # standard deviations of θ
_FAR_OFF = 5.0  # standard deviations: beyond, a corner was not found where it is
_MEDIAN = 1.567  # standard deviations: of the larger one of two distances from the truth, in two images
_FITS_GIVEN, _FITS = 3.0, 1.0  # pixels in an image 640 wide: medians under the given rig, and at the end
_LEFT = 0.5  # of the corners of a board, at least
_LENGTH = 1.0  # percent: squares of another length than those of the calibration differ by more
_LEAST = 1e-3  # of the weight of all normal distributions: below, one is dropped
_FEW = 10.0  # numbers: from fewer no deviation is estimated
# How much worse than its noise a set of boards may be as a whole, told apart by the evidence of the images: no print is
# quite flat.
NOISES = (1.0, 2.0)


def prior_of_boards(chart: RigChart, boards: Sequence[Board], prior: CalibrationPrior) -> CalibrationPrior:
    """The prior, given the corners of the boards of the calibration.

    Args:
        chart: of the given rig, which is the one that the boards were seen by but for what its calibration left.
        boards: at least one.
        prior: what is known without them.

    Raises:
        InputError: if there is no board, one lies outside of the images, or they do not fit the rig.
    """
    _check_inside(chart, boards)
    joint, length = _with_squares(prior, chart), chart.names.index(BASELINE)
    # The rig that boards of nominal squares are seen by: longer squares are a shorter baseline.
    of_joint = np.column_stack([np.eye(chart.dim), -np.eye(chart.dim)[length]])
    scale = chart.rig.left.size[0] / _WIDTH
    here, apart = _first_poses(chart, posed(chart.rig, boards))
    if np.median(apart) > _FITS_GIVEN * scale:
        raise _unfit(float(np.median(apart)))
    x, rows, noise = np.zeros(chart.dim + 1), None, _deviation(apart, scale)
    for _ in range(_ROUNDS):
        seen = chart.rig_at(of_joint @ x)
        kept = _kept(_apart(here.residual(seen)), scale)
        by_rig = here.by_rig(chart, of_joint @ x) @ of_joint
        rows, steps, follows = rows_without_poses(here, seen, by_rig, kept)
        noise = _noise(rows, joint, noise, scale)
        found = _updated(joint, _normal(rows, x, noise))
        best = int(found.weights.argmax())
        move = found.means[best] - x
        x, here = found.means[best], here.moved(steps - follows @ move)
        if (np.abs(move) < _SETTLED * np.linalg.norm(found.roots[best], axis=1)).all():
            break
    _check_fit(here, chart, of_joint @ x, np.linalg.norm((of_joint @ found.roots[best])[length]), scale)
    normal, n = _normal(rows, x, noise), chart.dim
    several = [_updated(joint, Normal(normal.a / k**2, normal.b / k**2, normal.c / k**2)) for k in NOISES]
    weights = np.concatenate([one.weights for one in several]) / len(several)
    kept = weights > _LEAST * weights.max()
    roots = np.concatenate([one.roots for one in several])[kept, :n]
    means = np.concatenate([one.means for one in several])[kept, :n]
    some = weights[kept] / weights[kept].sum()
    return CalibrationPrior(np.stack([root(one @ one.T) for one in roots]), some, means=means)


def _check_inside(chart: RigChart, boards: Sequence[Board]) -> None:
    if not boards:
        raise InputError("no board was given; give at least one, or leave boards out.")
    width, height = chart.rig.left.size
    for number, board in enumerate(boards):
        corners = np.concatenate([board.left, board.right])
        if (corners < -1.0).any() or (corners > [width, height]).any():
            raise InputError(
                f"board {number} has corners outside of the {width}x{height} images of the calibration; give pixels of "
                "the images as they were taken."
            )


def _first_poses(chart: RigChart, here: Posed) -> tuple[Posed, Float[np.ndarray, "n"]]:
    """Where the boards are by both cameras, if the given rig were the truth; and how far corners are apart then."""
    nothing, scale = np.zeros((len(here.board), 4, 0)), chart.rig.left.size[0] / _WIDTH
    for _ in range(_OF_POSES):
        kept = _kept(_apart(here.residual(chart.rig)), scale)
        here = here.moved(rows_without_poses(here, chart.rig, nothing, kept)[1])
    return here, _apart(here.residual(chart.rig))


def _apart(residual: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n"]:
    """How far a corner is from where it should be, in the image where it is farther."""
    return np.linalg.norm(residual.reshape(-1, 2, 2), axis=-1).max(axis=1)


def _deviation(apart: Float[np.ndarray, "n"], scale: float) -> float:
    """Of a coordinate of a corner, whatever a few of them do."""
    return max(float(np.median(apart)) / _MEDIAN, _FLOOR * scale)


def _kept(apart: Float[np.ndarray, "n"], scale: float) -> Bool[np.ndarray, "n"]:
    """The corners that count."""
    return apart < _FAR_OFF * _deviation(apart, scale)


def _with_squares(prior: CalibrationPrior, chart: RigChart) -> CalibrationPrior:
    """Of θ and of the squares' error in percent. The calibration was made with these boards: what its baseline errs by
    for their sake is that error, so far as the prior lets it err."""
    length, roots = chart.names.index(BASELINE), []
    for one in prior.roots:
        covariance = one @ one.T
        others = np.delete(one, length, axis=0)
        scales = np.linalg.norm(others, axis=1, keepdims=True)
        others = others / np.where(scales > 0.0, scales, 1.0)
        alone = one[length] - np.linalg.lstsq(others.T, one[length], rcond=None)[0] @ others
        cross = np.zeros((chart.dim, 1))
        cross[length] = SQUARES * min(SQUARES, float(np.linalg.norm(alone)))
        roots.append(root(np.block([[covariance, cross], [cross.T, np.array([[SQUARES**2]])]])))
    means = np.column_stack([prior.means, np.zeros(len(roots))])
    return replace(prior, roots=np.stack(roots), means=means)


def _normal(rows: BoardRows, x: Float[np.ndarray, "n"], noise: float) -> Normal:
    """The likelihood of corners, linear at x."""
    at_zero = (rows.residual - rows.jacobian @ x) / noise
    jacobian = rows.jacobian / noise
    return Normal(jacobian.T @ jacobian, -jacobian.T @ at_zero, float(at_zero @ at_zero))


def _updated(prior: CalibrationPrior, normal: Normal) -> CalibrationPrior:
    """Each normal distribution given the likelihood, weighed by its evidence."""
    roots, means, logs = [], [], []
    for one, mean, weight in zip(prior.roots, prior.means, prior.weights, strict=True):
        around = normal.around(mean)
        lower = np.linalg.cholesky(np.eye(len(mean)) + one.T @ around.a @ one)
        pull = np.linalg.solve(lower, one.T @ around.b)
        after = np.linalg.solve(lower, one.T).T
        roots.append(after)
        means.append(mean + after @ pull)
        logs.append(np.log(weight) - 0.5 * (around.c - pull @ pull) - np.log(np.diag(lower)).sum())
    weights = np.exp(np.array(logs) - np.logaddexp.reduce(logs))
    return CalibrationPrior(np.stack(roots), weights, means=np.stack(means))


def _noise(rows: BoardRows, prior: CalibrationPrior, noise: float, scale: float) -> float:
    """Standard deviation of a coordinate of a corner [px]: by all that is left, or, if that is more, by what boards
    would have otherwise than the others: what bends a whole board moves rigs, and hardly shows among single corners.

    Args:
        noise: about what it is: which directions boards tell about.
    """
    one = prior.roots[int(prior.weights.argmax())]
    whitened = rows.jacobian @ one / noise
    values = np.linalg.eigvalsh(whitened.T @ whitened)
    fitted = float((values / (1.0 + values)).sum())
    # At the best x for this prior, of linear rows.
    best = np.linalg.lstsq(np.concatenate([whitened, np.eye(one.shape[1])]),
        np.concatenate([rows.residual, np.zeros(one.shape[1])]), rcond=None)[0]
    left = rows.residual - whitened @ best
    found = [_FLOOR * scale]
    free = len(left) - 6 * rows.boards - fitted
    if free >= _FEW:
        found.append(float(np.sqrt(left @ left / free)))
    power = count = 0.0
    for number in np.unique(rows.board):
        which = rows.board == number
        axes, lengths, _ = np.linalg.svd(whitened[which], full_matrices=False)
        told = axes[:, lengths > 1.0]
        power += float(np.sum((told.T @ left[which]) ** 2))
        count += told.shape[1]
    if count - fitted >= _FEW:
        found.append(float(np.sqrt(power / (count - fitted))))
    return max(found)


def _check_fit(here: Posed, chart: RigChart, theta: Float[np.ndarray, "n"], length: float, scale: float) -> None:
    """Refuse boards that this rig has not seen.

    Args:
        theta: the rig that they ask for.
        length: standard deviation of its baseline, percent.
    """
    apart = _apart(here.residual(chart.rig_at(theta)))
    if np.median(apart) > _FITS * scale:
        raise _unfit(float(np.median(apart)))
    longer = float(theta[chart.names.index(BASELINE)])
    if abs(longer) > _LENGTH + 3.0 * length:
        raise InputError(
            f"by the boards the baseline is {abs(longer):.1f} % {'longer' if longer > 0 else 'shorter'} than the "
            "calibration says; give the length of a square with which it was calibrated."
        )
    kept = _kept(apart, scale)
    for number in range(len(here.shifts)):
        if kept[here.board == number].mean() < _LEFT:
            raise InputError(
                f"board {number} does not fit the rig as the others do (its corners are "
                f"{np.median(apart[here.board == number]):.1f} px off); check the order of its corners, or leave it out."
            )


def _unfit(pixels: float) -> InputError:
    return InputError(
        f"the boards do not fit the calibration: half of their corners are {pixels:.1f} px off and more; give those "
        "that it was made from, with the right order of corners and length of squares."
    )
