"""Refuses boards that do not fit the given rig, such as those of another one."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from stereorecal import InputError
from stereorecal.objectives import BASELINE, RigChart
from stereorecal_boards._board import Board
from stereorecal_boards._noise import WIDTH, corner_errors, inliers
from stereorecal_boards._poses import Posed

_GIVEN, _FITTED = 3.0, 1.0  # pixels in an image 640 wide: medians under the given rig, and at the end
_LEAST_KEPT = 0.5  # of the corners of a board
_LENGTH = 3.0  # percent: a calibration of few views gets the baseline wrong by less, and other squares differ by more


def check_inside(chart: RigChart, boards: Sequence[Board]) -> None:
    """Refuse corners of other images.

    Raises:
        InputError: says which, or that there is no board.
    """
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


def check_given(chart: RigChart, posed_boards: Posed) -> None:
    """Refuse boards that are far from what the given rig sees, wherever they are.

    Raises:
        InputError: says how far.
    """
    _check_median(corner_errors(posed_boards.residual(chart.rig)), _GIVEN, chart)


def check_fitted(chart: RigChart, posed_boards: Posed, theta: Float[np.ndarray, "n"], length: float) -> None:
    """Refuse boards that no rig near the given one sees like this.

    Args:
        theta: the rig that fits them best.
        length: standard deviation of its baseline, percent.

    Raises:
        InputError: says what does not fit.
    """
    errors = corner_errors(posed_boards.residual(chart.rig_at(theta)))
    _check_median(errors, _FITTED, chart)
    longer = float(theta[chart.names.index(BASELINE)])
    if abs(longer) > _LENGTH + 3.0 * length:
        raise InputError(
            f"by the boards the baseline is {abs(longer):.1f} % {'longer' if longer > 0 else 'shorter'} than the "
            "calibration says; give the length of a square with which it was calibrated."
        )
    counted = inliers(errors, chart.rig.left.size[0])
    for number in range(len(posed_boards.shifts)):
        own = posed_boards.board == number
        if counted[own].mean() < _LEAST_KEPT:
            raise InputError(
                f"board {number} does not fit the rig as the others do (its corners are "
                f"{np.median(errors[own]):.1f} px off); check the order of its corners, or leave it out."
            )


def _check_median(errors: Float[np.ndarray, "n"], limit: float, chart: RigChart) -> None:
    middle = float(np.median(errors))
    if not middle <= limit * chart.rig.left.size[0] / WIDTH:
        raise InputError(
            f"the boards do not fit the calibration: the median corner is {middle:.1f} px off; give the boards that it "
            "was made from, and check the order of the corners and the size of the squares."
        )
