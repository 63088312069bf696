"""From one look to what is known, and which calibration is in use: the estimate is followed, what does not fit is
named, and the calibration is switched when the decision asks for it.

What the looks cannot follow is repaired: rigs so far off that hardly anything matches. And a recalibration on request,
in place of waiting until looks ask for one.
"""

from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.decision import Decision
from stereorecal.estimation import CalibrationCovariance, Estimate, Prior, is_exact
from stereorecal.objectives import EXTRINSICS, Parameters
from stereorecal.online._config import Event, Kind
from stereorecal.online._filter import DRIFT, SIZE, FilterEstimate, Measurement
from stereorecal.online._matches import row_error
from stereorecal.online._reading import reading
from stereorecal.online._state import Offset, State, theta_of
from stereorecal.recalibration import (
    Case,
    Condition,
    Progress,
    Reason,
    Solution,
    as_settings,
    next_slice,
    recalibrate as recalibrated,
)
from stereorecal.recordings import Pairs
from stereorecal.scoring import Correspondences, pyramid

_TRUSTED = 0.1  # degrees and percent: how well an estimate by few frames is trusted, beyond its own covariance
_KNOCK = 1e-6  # chance that a look is taken for a sign of a knock though nothing happened; two that agree are a knock
_AGREE = 1e-3  # chance, of two looks after a knock
_DISAGREEING = 4  # looks that fit nothing, until it is said
_KEPT = 8  # calibrations that can be returned to: the first, and the last ones


def switched(state: State, offset: Offset) -> State:
    """Another calibration in use; the first and the last ones before it are kept."""
    first, *last = *state.previous, state.using
    return state.replace(
        using=offset,
        previous=(first, *last[1 - _KEPT :]),
        ready=state.frame + state.config.rest,
        reported=None,
        job=None,
        repair_pairs=(),
        unmatched_in_a_row=0,
    )


def decided(state: State, found: Correspondences) -> State:
    """The state with the change in use that the decision asks for, and against which the look does not speak.

    y and z stay, unless a trigger opens both shutters: one that is late on a rig that travels straight on poses as a
    shift, and no look tells them apart. A repair of pairs that hardly match, which is judged by its own misfit, may
    change them.
    """
    if not state.config.repair or state.outlier is not None or state.frame < state.ready:
        return state
    stands = reading(state)
    if stands.late or stands.shifted or stands.change is None:
        return state
    offset = state.using + stands.change
    if row_error(found, state.chart, theta_of(offset, state.chart)) > state.row_error:
        return state
    return _switched_by(state, offset, Kind.REPAIRED, stands.decision, "looks")


def _switched_by(state: State, offset: Offset, kind: Kind, decision: Decision, by: str) -> State:
    """The state that says that another calibration is in use; `by` says what the decision rests on."""
    before, after = decision.rows_px[:, 0].tolist()
    facts: dict[str, Any] = {
        name: {"offset": one.tolist(), "extrinsics": np.asarray(state.rig_at(one).extrinsics).tolist()}
        for name, one in (("old", state.using), ("new", offset))
    }
    facts["proof"] = {
        "by": by,
        "row_error_before_px": before,
        "row_error_after_px": after,
        "probability_better": decision.better,
        "probability_worse": decision.worse,
    }
    return switched(state, offset).saying(kind, facts=facts)


def prior_now(state: State) -> Prior:
    """What is known of the calibration in use, for an estimate by other pairs: of exact intrinsics only that they are;
    else all that looks have told, lenses included."""
    if is_exact(state.config.prior):
        return state.config.prior
    names, covariance = state.chart.names, state.posterior.covariance
    some = np.flatnonzero(np.diag(covariance) > 0.0)
    mean = (state.posterior.mean - state.theta)[some]
    return CalibrationCovariance([names[index] for index in some], covariance[np.ix_(some, some)], mean)


def told_by(state: State, estimate: Estimate) -> State:
    """The state that knows of the rig what an estimate by some pairs does, which is trusted less than it says: they may
    err together. The kinds of calibration were told apart before, and will be again: lenses that no pair shows seem
    better known, 1.4 times.

    Args:
        estimate: with `prior_now` as its prior, of changes of the calibration in use.
    """
    covariance = estimate.posterior.covariance.copy()
    covariance[:SIZE, :SIZE] += _TRUSTED**2 * np.eye(SIZE)
    return state.standing_at(state.estimate.moved(state.theta + estimate.theta, covariance))


def followed(state: State, measured: Measurement) -> State:
    """The state after an informative look."""
    if state.estimate.chance_of(measured) >= _KNOCK:
        state = state.measured(measured, state.config.together).replace(outlier=None, outliers_in_a_row=0)
        return standing(state)
    first = state.outlier
    if first is None:
        return state.replace(outlier=measured)
    # Where a turn is not known, nor is how far a late shutter could explain it: such a look speaks to its like alone.
    alike = (first.turn is None) == (measured.turn is None)
    changed = _after_two_outliers(state, first, measured) if alike else None
    if changed is None:
        state = state.replace(outlier=measured, outliers_in_a_row=state.outliers_in_a_row + 1)
        return state.saying(Kind.FRAMES_DISAGREE) if state.outliers_in_a_row == _DISAGREEING else state
    estimate, knocked = changed
    before, state = state.offset, state.standing_at(estimate).replace(outlier=None, outliers_in_a_row=0)
    if knocked:
        state = state.replace(ready=0)
    if not (knocked and reading(state.replace(using=before)).matters):
        return standing(state)
    change = dict(zip(EXTRINSICS, (state.offset - before).tolist(), strict=True))
    farthest = sorted(("pitch", "yaw", "roll"), key=lambda name: -abs(change[name]))[:2]
    text = ", ".join(f"{name} {change[name]:+.2f} deg" for name in farthest)
    return state.replace(reported=Kind.KNOCK).saying(Kind.KNOCK, text, {"change": change})


def _after_two_outliers(state: State, first: Measurement, second: Measurement) -> tuple[FilterEstimate, bool] | None:
    """The estimate after two looks that agree with each other, and whether the rig was knocked; None if they do not.
    A delay explains with one number what a knock explains with five, so it is asked first."""
    together = state.config.together
    if not state.config.synchronous:
        late = state.estimate.late().updated(first, together)
        if state.estimate.late().chance_of(first) > _AGREE and late.chance_of(second) > _AGREE:
            return late.updated(second, together), False
    knocked = state.estimate.widened(DRIFT).updated(first, together)
    return (knocked.updated(second, together), True) if knocked.chance_of(second) > _AGREE else None


def standing(state: State) -> State:
    """The state that says how the rig stands, when that changes."""
    found, why = reading(state), ""
    kind = {Condition.HEALTHY: Kind.HEALTHY, Condition.REPAIR: Kind.DRIFTING}.get(found.condition)
    if found.late:
        kind, why = Kind.LATE, f"by {found.delay.value:.2f} frames"
    elif found.shifted:
        kind, (y, z) = Kind.SHIFTED, (found.axes[name].value for name in "yz")
        why = f"y {y:+.1f}, z {z:+.1f} % of the baseline"
    if kind is None or kind is state.reported or (kind is Kind.DRIFTING and state.reported is Kind.KNOCK):
        return state
    return state.replace(reported=kind).saying(kind, why, found.as_dict())


def begun(state: State) -> State:
    """The state with a repair under way, on the pairs that hardly match; or, where nothing is switched, a search for
    how the rig stands, which is no repair."""
    state = state.replace(job=Progress(state.rig))
    return state.saying(Kind.REPAIRING, f"from {len(state.repair_pairs)} pairs") if state.config.repair else state


def continued(state: State) -> State:
    """The state after one more slice of its repair; after the last one what it found in use, if it was accepted."""
    job, matcher = state.job, state.matcher
    assert job is not None
    assert matcher is not None
    try:
        settings = as_settings({"matcher": matcher, "free": EXTRINSICS})
        images = pyramid(state.rig, state.repair_pairs, state.config.view)
        ended = next_slice(Case(images, settings, matcher, Parameters(), prior_now(state)), job)
    except InputError as error:  # such as: images that are exchanged
        return state.replace(job=None).saying(Kind.REJECTED, str(error))
    if isinstance(ended, Progress):
        return state.replace(job=ended)
    return _after_solution(state.replace(job=None), ended)


def _after_solution(state: State, solution: Solution) -> State:
    if not solution.accepted or solution.estimate is None or solution.decision is None:
        kind = Kind.FRAMES_DISAGREE if solution.reason is Reason.FRAMES_DISAGREE else Kind.REJECTED
        return state.saying(kind, solution.reason.value)
    offset = state.offset_of(solution.rig)
    if state.reported is not Kind.KNOCK:
        change = dict(zip(EXTRINSICS, (offset - state.using).tolist(), strict=True))
        state = state.saying(Kind.KNOCK, "almost nothing matched", {"change": change})
    state = told_by(state, solution.estimate).replace(reported=Kind.KNOCK, ready=0, outlier=None)
    if not state.config.repair or reading(state).late:
        return standing(state)
    state = _switched_by(state, offset, Kind.REPAIRED, solution.decision, "repair")
    return state.replace(ready=0)  # looks may correct it at once


def recalibrate(state: State, pairs: Pairs) -> tuple[State, tuple[Event, ...]]:
    """What `sr.recalibrate` finds of the extrinsics in use, which takes their place if the decision accepts it; else
    the state stays as it is. A state that is frozen stays so.

    Args:
        pairs: the last ones, of different views of the scene; used jointly.

    Returns:
        The state, and RECALIBRATED, or REJECTED with the reason.
    """
    try:
        solution = recalibrated(
            state.rig,
            pairs,
            matcher=state.config.matcher,
            view=state.config.view,
            motion=False,
            free=EXTRINSICS,
            prior=prior_now(state),
        )
    except InputError as error:
        return state, state.saying(Kind.REJECTED, str(error)).events
    if not solution.accepted or solution.estimate is None or solution.decision is None:
        return state, state.saying(Kind.REJECTED, solution.reason.value).events
    offset = state.offset_of(solution.rig)
    state = told_by(state, solution.estimate).replace(outlier=None, outliers_in_a_row=0)
    return _switched_by(state, offset, Kind.RECALIBRATED, solution.decision, "recalibration").told()
