"""From one look to what is known: the estimate is followed, and what does not fit is named."""

import numpy as np
from jaxtyping import Float

from stereorecal.objectives import RigChart
from stereorecal.online._events import Event, Kind
from stereorecal.online._filter import SIZE, FilterEstimate, Measurement
from stereorecal.online._pair_estimate import PairEstimate
from stereorecal.online._reading import Reading, reading
from stereorecal.online._state import State
from stereorecal.recalibration import Condition

_AGREE = 1e-3  # chance, of two looks after a knock
_DISAGREEING = 4  # looks that fit nothing, until it is said


def measurement(state: State, look: PairEstimate, turned: Float[np.ndarray, "3"] | None) -> Measurement:
    """What a look measures of the offset.

    Args:
        turned: rotation of the rig since the last pair [rad], None if it is not known.
    """
    assert look.solution is not None
    units = look.chart.units
    turn = np.zeros(SIZE)
    if turned is not None:
        turn[:3] = np.degrees(turned)
    offset = state.offset_of(state.rig.with_extrinsics(look.chart.extrinsics(look.solution.z)))
    information = _information(look.chart, look.solution.covariance()) / np.outer(units, units)
    return Measurement(state.frame, offset, information, turn, synchronous=state.config.synchronous)


def _information(chart: RigChart, covariance: Float[np.ndarray, "5 5"]) -> Float[np.ndarray, "5 5"]:
    """What the look alone knows: the inverse of its covariance less that of the prior, which every look brings anew."""
    values, axes = np.linalg.eigh(covariance / chart.prior**2)
    return (axes * np.maximum(1.0 / values - 1.0, 0.0)) @ axes.T / chart.prior**2


def followed(state: State, measured: Measurement) -> tuple[State, list[Event]]:
    """The state after an informative look."""
    config = state.config
    if state.estimate.chance_of(measured) >= config.knock:
        state = state.measured(measured, state.config.together).replace(outlier=None, outliers_in_a_row=0)
        return standing(state)
    if state.outlier is None:
        return state.replace(outlier=measured), []
    changed = _after_two_outliers(state, state.outlier, measured)
    if changed is None:
        in_a_row = state.outliers_in_a_row + 1
        state = state.replace(outlier=measured, outliers_in_a_row=in_a_row)
        return state, [Event(state.frame, Kind.FRAMES_DISAGREE)] if in_a_row == _DISAGREEING else []
    estimate, knocked = changed
    before, state = state.estimate, state.standing_at(estimate).replace(outlier=None, outliers_in_a_row=0)
    moved = estimate.offset - before.offset
    if not knocked:
        return standing(state)
    state = state.replace(trial=None, ready=0)  # it was fitted to another rig
    if not reading(state.using_now(before.offset)).matters:
        return standing(state)
    facts = {"change": dict(zip(state.chart.names, moved.tolist(), strict=True))}
    return state.replace(reported=Kind.KNOCK), [Event(state.frame, Kind.KNOCK, _change_text(facts["change"]), facts)]


def _after_two_outliers(state: State, first: Measurement, second: Measurement) -> tuple[FilterEstimate, bool] | None:
    """The estimate after two looks that agree with each other, and whether the rig was knocked; None if they do not.
    A delay explains with one number what a knock explains with five, so it is asked first."""
    together = state.config.together
    if not state.config.synchronous:
        late = state.estimate.late().followed(first, together)
        if state.estimate.late().chance_of(first) > _AGREE and late.chance_of(second) > _AGREE:
            return late.followed(second, together), False
    knocked = state.estimate.after_knock(state.prior).followed(first, together)
    return (knocked.followed(second, together), True) if knocked.chance_of(second) > _AGREE else None


def standing(state: State) -> tuple[State, list[Event]]:
    """How the rig stands: said when it changes."""
    found = reading(state)
    kind = _kind(found)
    if kind is None or kind is state.reported or (kind is Kind.DRIFTING and state.reported is Kind.KNOCK):
        return state, []
    return state.replace(reported=kind), [Event(state.frame, kind, _why(kind, found), found.as_dict())]


def _why(kind: Kind, found: Reading) -> str:
    if kind is Kind.LATE:
        return f"by {found.delay.value:.2f} frames"
    if kind is Kind.SHIFTED:
        return f"y {found.axes['y'].value:+.1f}, z {found.axes['z'].value:+.1f} % of the baseline"
    return ""


def _kind(found: Reading) -> Kind | None:
    if found.late:
        return Kind.LATE
    if found.shifted:
        return Kind.SHIFTED
    standing = {Condition.HEALTHY: Kind.HEALTHY, Condition.REPAIR: Kind.DRIFTING}
    return standing.get(found.condition)


def _change_text(change: dict[str, float]) -> str:
    """The axes that moved, the farthest first."""
    turned = sorted(("pitch", "yaw", "roll"), key=lambda name: -abs(change[name]))
    return ", ".join(f"{name} {change[name]:+.2f} deg" for name in turned[:2])
