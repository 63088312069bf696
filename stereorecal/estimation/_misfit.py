"""Structured misfit: what stays together in a region and is in no parameter of the rig.

A moved thing, a shutter, a lens that the model lacks: a field over the places of each frame, and one that all frames
have in common. The evidence finds their deviations; their length is short, since a smooth field would be the keystone
of a yaw.
"""

from functools import cache

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._groups import PLACES

DEVIATIONS = (0.0, 0.02, 0.04, 0.07, 0.12, 0.2, 0.4, 0.8)  # pixels, of the field of a frame
COMMON = (0.0, 0.02, 0.04, 0.07, 0.12, 0.2)  # pixels, of the field that all frames have in common
USUAL = 0.07  # pixels, of the field of a frame: that of most good pairs, or more
_LENGTH = 1.5  # places


def correlation(place: Int[np.ndarray, "g"]) -> Float[np.ndarray, "g g"]:
    """The correlation of the field at places."""
    return _correlation_of_places()[np.ix_(place, place)]


@cache
def _correlation_of_places() -> Float[np.ndarray, "p p"]:
    """Of all places."""
    row, column = np.divmod(np.arange(PLACES[0] * PLACES[1]), PLACES[0])
    apart2 = (row[:, None] - row) ** 2 + (column[:, None] - column) ** 2
    return np.exp(-0.5 * apart2 / _LENGTH**2)


def covariance_of_rows(
    place: Int[np.ndarray, "g"], deviation: Float[np.ndarray, "g"], misfit: float
) -> Float[np.ndarray, "g g"]:
    """Of the mean row differences of the groups of one frame, with a misfit of this deviation."""
    return misfit**2 * correlation(place) + np.diag(deviation**2)


def unexpected(covariance: Float[np.ndarray, "g g"], residual: Float[np.ndarray, "g"]) -> Float[np.ndarray, "g"]:
    """Residuals of groups against what all others of their frame let expect of them, in standard deviations: large
    where one group errs alone, small in a region that moved as a whole."""
    precision = np.linalg.inv(covariance)
    return precision @ residual / np.sqrt(np.diag(precision))
