"""How well corners of boards are found, by their reprojection errors; and which of them are outliers."""

import numpy as np
from jaxtyping import Bool, Float

from stereorecal_boards._poses import BoardRows

WIDTH = 640  # of an image, for which limits in pixels are given
_FLOOR = 0.05  # pixels, standard deviation: no corner is found better
_FAR_OFF = 5.0  # standard deviations: beyond, a corner was not found where it is
_MEDIAN = 1.567  # standard deviations: of the larger one of two distances from the truth, in two images
_FEW = 10.0  # numbers: from fewer no deviation is estimated


def corner_errors(residual: Float[np.ndarray, "n 4"]) -> Float[np.ndarray, "n"]:
    """Reprojection error of each corner [px]: in the image where it is larger."""
    return np.linalg.norm(residual.reshape(-1, 2, 2), axis=-1).max(axis=1)


def deviation(errors: Float[np.ndarray, "n"], width: int) -> float:
    """Standard deviation of a coordinate of corners with these errors, whatever a few of them do."""
    return max(float(np.median(errors)) / _MEDIAN, _FLOOR * width / WIDTH)


def inliers(errors: Float[np.ndarray, "n"], width: int) -> Bool[np.ndarray, "n"]:
    """Which corners count: those within five standard deviations."""
    return errors < _FAR_OFF * deviation(errors, width)


def noise(rows: BoardRows, root: Float[np.ndarray, "m n"], before: float, width: int) -> float:
    """Standard deviation of a coordinate of a corner [px]: by all that is left, or, if that is more, by what boards
    would have otherwise than the others: what bends a whole board moves rigs, and hardly shows among single corners.

    Args:
        root: of the covariance of the parameters, before any board was seen.
        before: about what it is: it says about which directions boards tell.
        width: of the images.
    """
    white, size = rows.jacobian @ root / before, root.shape[1]
    values = np.linalg.eigvalsh(white.T @ white)
    fitted = float(np.sum(values / (1.0 + values)))
    # What the best parameters leave, of linear rows.
    rows_and_prior = np.concatenate([white, np.eye(size)]), np.concatenate([rows.residual / before, np.zeros(size)])
    unexplained = rows.residual - before * white @ np.linalg.lstsq(*rows_and_prior, rcond=None)[0]
    powers = [(float(unexplained @ unexplained), len(unexplained) - 6 * rows.boards - fitted)]
    by_board, degrees_of_freedom = 0.0, 0
    for number in np.unique(rows.board):
        which = rows.board == number
        axes, lengths, _ = np.linalg.svd(white[which], full_matrices=False)
        of_rig = axes[:, lengths > 1.0].T @ unexplained[which]
        by_board, degrees_of_freedom = by_board + float(of_rig @ of_rig), degrees_of_freedom + len(of_rig)
    powers.append((by_board, degrees_of_freedom - fitted))
    found = [float(np.sqrt(power / freedom)) for power, freedom in powers if freedom >= _FEW]
    return max([_FLOOR * width / WIDTH, *found])
