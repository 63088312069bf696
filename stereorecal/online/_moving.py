"""Depth from the rig's own motion while it drives: corners are followed until the rig has moved, and then tell the yaw
that rows alone do not."""

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Normal, is_exact, rig_parameters, window
from stereorecal.geometry import vector_from_rotation
from stereorecal.online._estimate import OF_LENSES, SIZE, Measurement
from stereorecal.online._pair_estimate import PairEstimate
from stereorecal.online._state import State
from stereorecal.online._switching import Outcome, weighed
from stereorecal.online._watching import standing
from stereorecal.recordings import Pair
from stereorecal.scoring.host import corners, shown_again

_MOST = 400  # corners
_FEWEST = 30  # of them that are seen again
_AHEAD = 0.5  # baselines: in less, depth is hardly told
_LEFT = 0.4  # of the corners that were found: if fewer are seen again, sooner
# Pairs, where their times are not known, and seconds, after which nothing is the same.
_LONGEST, _SECONDS = 16, 2.0
# Windows of one place show the same things, and err together: standard deviations in those that each believes.
_WORSE = 3.0
_FITS = 1e-3  # chance: what fits less may be the motion of other things


def anchored(state: State, pair: Pair, look: PairEstimate) -> State:
    """With the corners of a pair, where none are followed."""
    if not state.config.motion or state.corners is not None:
        return state
    found = corners(pair, look.matches, look.near, _MOST)
    return state.but(corners=found, found_at=state.frame, since=pair.time) if len(found.left) >= _FEWEST else state


def moved(state: State, pair: Pair) -> Outcome:
    """The state after a pair that may show corners again from elsewhere."""
    before, pairs = state.corners, state.frame - state.found_at
    if before is None or pairs < state.apart:
        return state, []
    if not _soon(state.since, pair.time, pairs):
        return state.but(corners=None), []
    tracks, chart = shown_again(before, pair), rig_parameters(state.rig)
    seen = window(tracks, chart, np.zeros(chart.dim))
    lost = seen.motion is None or len(tracks) < _LEFT * len(before.left)
    near = seen.metres[0] < _AHEAD * float(state.rig.baseline)
    apart = max(state.apart // 2, 1) if lost else min(2 * state.apart, _longest(state)) if near else state.apart
    state = state.but(corners=None, apart=apart)
    if seen.motion is None:
        return state, []
    turned = np.degrees(vector_from_rotation(seen.motion.rotation)) / pairs
    return _after_window(state, _measurement(state, seen.normal, turned))


def _soon(first: float | None, second: float | None, pairs: int) -> bool:
    """Whether a pair comes soon after another one: by their times, or, where not both are known, by pairs; a repair in
    between may have taken many."""
    if first is None or second is None:
        return pairs <= _LONGEST
    return 0.0 < second - first <= _SECONDS


def _longest(state: State) -> int:
    """Pairs to the last look that comes soon enough."""
    return max(_LONGEST - _LONGEST % state.config.every, 1)


def _measurement(state: State, normal: Normal, turned: Float[np.ndarray, "3"]) -> Measurement:
    """What a window says of the offset, near the calibration in use.

    Args:
        turned: rotation vector of the rig from one pair to the next, degrees.
    """
    a, b = normal.a[:SIZE, :SIZE], normal.b[:SIZE]
    offset = state.using + np.linalg.pinv(a, rcond=1e-9, hermitian=True) @ b
    turn = np.concatenate([turned, np.zeros(SIZE - len(turned))])
    doubt = 0.0 if is_exact(state.config.prior) else OF_LENSES  # in all windows alike
    return Measurement(state.found_at, offset, a / _WORSE**2, turn, keystone=False, doubt=doubt)


def _after_window(state: State, measured: Measurement) -> Outcome:
    """The state after a window. One that does not fit waits for the next: most that moves may not be the rig."""
    estimate = state.estimate
    if estimate.chance_of(measured) >= _FITS:
        return standing(weighed(state.measured(measured).but(suspect_depth=None), measured))
    first, state = state.suspect_depth, state.but(suspect_depth=measured)
    if first is None:
        return state, []
    turned = estimate.turned(float(state.prior[1])).seen(first)
    if turned.chance_of(measured) < _FITS:
        return state, []
    turned = turned.seen(measured)
    if abs(turned.keystone) > abs(estimate.keystone):  # rows know of no such yaw
        return state, []
    return standing(state.standing_at(turned).but(suspect_depth=None, trial=None))
