"""Frames against each other: does each show the rig that all show together?"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._linear_groups import LinearGroups
from stereorecal.estimation._misfit import covariance_of_rows
from stereorecal.estimation._rig_parameters import DRIFTING

_CHANCE = 1e-3  # that a frame of the same rig is taken for one of another
_OWN = np.array([0.5, 0.5, 0.5, 0.5, 0.5])  # degrees and percent: how far the rig may have moved between frames
ROWS_MATTER = 0.1  # pixels: frames that differ by less agree well enough


@dataclass(frozen=True)
class OtherRig:
    """A frame that shows another rig than the others.

    Attributes:
        frame: its number.
        rows_px: root mean square of the rows by which its own rig differs.
    """

    frame: int
    rows_px: float


def other_rigs(rows: LinearGroups, misfit: float, theta: Float[np.ndarray, "n"]) -> tuple[OtherRig, ...]:
    """The frames that would be far more probable with extrinsics of their own, by rows that matter; the farthest first.

    Args:
        misfit: deviation of the field of each frame, pixels.
        theta: the solution of all frames.
    """
    if len(rows.frames) < 2:
        return ()
    own, limit = len(DRIFTING), _chi_square(len(DRIFTING), 1.0 - _CHANCE / len(rows.frames))
    residual, found = rows.residual(theta), []
    for f in rows.frames:
        precision = np.linalg.inv(covariance_of_rows(rows.groups.place[f], rows.deviation[f], misfit))
        slopes = rows.jacobian[f, :own]
        pull = slopes.T @ precision @ residual[f]
        move = np.linalg.solve(slopes.T @ precision @ slopes + np.diag(_OWN**-2.0), pull)
        rows_px = float(np.sqrt(np.mean((slopes @ move) ** 2)))
        if float(pull @ move) > limit and rows_px > ROWS_MATTER:
            found.append(OtherRig(int(rows.groups.frame[f[0]]), rows_px))
    return tuple(sorted(found, key=lambda one: -one.rows_px))


def _chi_square(degrees: int, probability: float) -> float:
    """A quantile, by the cube root of Wilson & Hilferty (1931)."""
    tenth = 2.0 / (9.0 * degrees)
    return degrees * (1.0 - tenth + NormalDist().inv_cdf(probability) * np.sqrt(tenth)) ** 3
