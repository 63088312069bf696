"""Which calibration is in use: candidates, their trials, the switch, and the way back."""

from collections.abc import Callable

import numpy as np

from stereorecal.decision import chance_of_harm
from stereorecal.estimation import Estimate
from stereorecal.online._events import Event, Kind
from stereorecal.online._filter import Measurement
from stereorecal.online._filter_posterior import filtered_by, known
from stereorecal.online._pair_estimate import PairEstimate
from stereorecal.online._reading import reading
from stereorecal.online._sequential_test import SequentialTest
from stereorecal.online._state import Offset, State

Outcome = tuple[State, list[Event]]

_TRUSTED = 0.1  # degrees and percent: how well an estimate by few frames is trusted, beyond its own covariance


def trial_after_look(state: State, measured: Measurement, look: PairEstimate) -> Outcome:
    """The trial after a look through the calibration in use; one that does not fit what is known takes no part."""
    trial = state.trial
    if trial is None or measured.frame <= trial.since or state.outlier is not None:
        return state, []
    found = reading(state)
    if found.late or (found.shifted and trial.by == "looks"):  # what was measured may be the shutter's
        return state.replace(trial=None), []
    after = look.rows(state.rig_at(trial.offset))
    state = state.replace(trial=trial.measured(state.using, measured, state.row_error, after))
    return decided(state)


def trial_after_motion(state: State, measured: Measurement) -> State:
    """The trial after what the rig's motion told, which alone decides nothing: it shows no rows."""
    trial = state.trial
    if trial is None or measured.frame <= trial.since or state.outlier is not None:
        return state
    return state.replace(trial=trial.moved(state.using, measured))


def trial_after_unmatched(state: State, before: float, look: Callable[[], PairEstimate]) -> Outcome:
    """The trial after a look through the calibration in use that showed hardly anything: `before` of the image."""
    trial = state.trial
    if trial is None or state.frame <= trial.since:
        return state, []
    candidate_look = look()
    return decided(
        state.replace(
            trial=trial.matched(before, candidate_look.covered if candidate_look.solution is not None else 0.0)
        )
    )


def decided(state: State) -> Outcome:
    """The switch, if the candidate has won and hardly harms by what the filter knows by now; else it is dropped, once
    it has won or lost.

    Looks of one place err together, and a trial of them alone would take the error of all for the rig's.
    """
    trial = state.trial
    assert trial is not None
    won = trial.won(state.config.switch)
    if not won and not trial.lost:
        return state, []
    harm = _chance_of_harm(state, trial.offset)
    proof = {**trial.as_dict(), "chance_of_harm": harm}
    if won and harm <= state.config.harm:
        facts = {
            "old": calibration_data(state, state.using),
            "new": calibration_data(state, trial.offset),
            "proof": proof,
        }
        state = switched(state, trial.offset)
        return state, [Event(state.frame, Kind.REPAIRED, "", facts)]
    facts = {"candidate": calibration_data(state, trial.offset), "proof": proof}
    state = state.replace(trial=None, ready=state.frame + state.config.rest)
    why = "it may harm" if won else "no better on later pairs"
    return state, [Event(state.frame, Kind.REJECTED, f"fitted by {trial.by}; {why}", facts)]


def _chance_of_harm(state: State, offset: Offset) -> float:
    """Of a switch, by what the filter knows; 1 if that is no number."""
    if not state.estimate.is_finite:
        return 1.0
    estimate = known(state.initial, tuple(state.using.tolist()), state.estimate, state.view)
    change = estimate.chart.coordinates(np.asarray(state.rig_at(offset).extrinsics, float))
    return chance_of_harm(estimate, change, state.config.tolerances)


def switched(state: State, offset: Offset) -> State:
    """Another calibration in use; the one before it is kept."""
    previous = (*state.previous, state.using)[-state.config.keep :]
    return state.using_now(offset).replace(
        previous=previous,
        ready=state.frame + state.config.rest,
        job=None,
        trial=None,
        repair_pairs=(),
        unmatched_in_a_row=0,
        attempt=2,
    )


def nominated(state: State) -> Outcome:
    """The change that the decision asks for as a candidate, or one that is better on average: later looks must bear
    out either, and a calibration in use can be replaced again.

    y and z stay, unless a trigger opens both shutters: one that is late on a rig that travels straight on poses as a
    shift, and no look tells them apart. A repair of pairs that hardly match, which is judged by its own misfit, may
    change them.
    """
    if not state.config.repair or state.trial is not None or state.outlier is not None:
        return state, []
    if state.frame < state.ready:
        return state, []
    found = reading(state)
    if found.late or found.shifted or found.change is None:
        return state, []
    return state.replace(trial=SequentialTest(state.using + found.change, "looks", state.frame)), []


def after_repair(state: State, offset: Offset, estimate: Estimate) -> State:
    """A candidate of a repair on trial, unless nothing is to be switched."""
    trial = SequentialTest(offset, "repair", state.frame) if state.config.repair else None
    return told_by(state, estimate).replace(trial=trial, outlier=None)


def told_by(state: State, estimate: Estimate) -> State:
    """The state that knows of the rig what an estimate by some pairs does, which is trusted less than it says: they may
    err together."""
    return state.standing_at(filtered_by(state, estimate, _TRUSTED))


def calibration_data(state: State, offset: Offset) -> dict[str, list[float]]:
    """A calibration, as plain data."""
    return {
        "offset": [float(value) for value in offset],
        "extrinsics": np.asarray(state.rig_at(offset).extrinsics).tolist(),
    }
