"""Where the search for the rig's motion begins: the motion of a few tracks that most of the others agree with.

What moves as a whole beside the rig, such as a boat that fills a third of the view, is no outlier of least squares that
begin at rest: they end between its motion and the rig's. Least median of squares (Rousseeuw 1984) is not drawn to it.
"""

import numpy as np

from stereorecal.estimation._motion_residuals import MOVES, Motion, TrackReadings, residuals
from stereorecal.geometry import StereoRig, rotation_from_vector

_DRAWS, _OF = 200, 4  # sets of tracks, and how many each; three would do for exact ones
_SEED = 0
_TURN, _MOVE = 0.3, 10.0  # rad, baselines: standard deviations, for sets that tell nothing of one of them
_ERROR = 0.5  # pixels


def consensus(readings: TrackReadings, rig: StereoRig) -> Motion:
    """The motion, to first order of its rotation, from whose flow the tracks' median distance is least; their depths
    are those of the first pair."""
    number, at_rest = len(readings.tracks), Motion(np.eye(3), np.zeros(3))
    first = residuals(readings, rig, at_rest, np.zeros(number))
    linear = residuals(readings, rig, at_rest, -first.value[:, 0] / first.by_nearness[:, 0])
    unit = np.repeat([_TURN, _MOVE * float(rig.baseline)], MOVES // 2)
    offsets, flow = linear.value[:, 1:3], -linear.by_motion[:, 1:3] * unit
    draws = np.random.default_rng(_SEED).integers(number, size=(_DRAWS, _OF))
    some = flow[draws].reshape(_DRAWS, -1, MOVES)
    known = some.swapaxes(1, 2) @ some + _ERROR**2 * np.eye(MOVES)
    moves = np.linalg.solve(known, some.swapaxes(1, 2) @ offsets[draws].reshape(_DRAWS, -1, 1))[..., 0]
    squared_errors = np.sum((offsets[..., None] - flow @ moves.T) ** 2, axis=1)  # (tracks, draws)
    turn, move = np.split(unit * moves[np.argmin(np.median(squared_errors, axis=0))], 2)
    return Motion(np.asarray(rotation_from_vector(turn), float), move)
