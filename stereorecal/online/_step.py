"""One step: a pair comes, and what is known of the rig follows; and steps through a recording, for scripts."""

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from stereorecal._errors import InputError
from stereorecal.decision import ENOUGH, Seen
from stereorecal.estimation import Normal, normal_of_pair, one_blas_thread
from stereorecal.geometry import StereoRig, as_view, checked_rig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.online._calibration_kinds import before_looks
from stereorecal.online._config import Config, Event, Kind
from stereorecal.online._filter import DRIFT, SIZE, Measurement, at_start, filters_beside
from stereorecal.online._matches import covered_by, row_error
from stereorecal.online._moving import Small, anchored, moved, small, turn
from stereorecal.online._reading import reading
from stereorecal.online._state import Offset, State, known_matcher
from stereorecal.online._switching import begun, continued, decided, followed, switched
from stereorecal.recalibration import Schedule, is_sparse, places_of, watching_scale
from stereorecal.recordings import Images, LazyPairs, Pair, check_pairs
from stereorecal.scoring import Correspondences, image_quality, is_coarse, pyramid
from stereorecal.scoring.host import correspondences, with_measured_range

_FIRST = 2  # pairs that hardly match, until a repair is tried; after twice as many again
_BLIND = 1.5  # pixels of epipolar error: beyond, windows show other things
_LEARN = 100  # looks: those that tell of lenses
_FALSE = 0.4  # pixels left: chance matches lie evenly within a row of where they were sought, median 0.5


def init(rig: StereoRig, config: Config = Config()) -> State:  # noqa: B008  frozen
    """The state before the first pair.

    Args:
        rig: the calibration to start from.

    Raises:
        InputError: if the matcher is none, or a strategy that repairs need is not installed; it says the install line.
    """
    rig = checked_rig(rig)
    Schedule.default()  # raises now, and not after the first knock
    start, freed = (at_start(before_looks(rig, config.prior, any_yaw=any_yaw), config) for any_yaw in (False, True))
    view, using = as_view(config.view, rig), np.zeros(SIZE)
    return State(config, rig, view, using, start, filters_beside(freed, start), matcher=known_matcher(config))


def step(state: State, pair: Pair | Images, seconds: float | None = None) -> tuple[State, tuple[Event, ...]]:
    """The state after one more pair, and what happened. A pair that cannot be used is an event, never an exception; of
    several, one after the other, the first is.

    A step is one look at the pair. After a knock that leaves hardly anything to match a repair of up to three pairs is
    under way, and each step does one slice of it in place of a look: the survey, a stage on the count, one round of
    matching and solving. After a repair of such a rig in this process, with that range, nothing is compiled in it.

    Args:
        seconds: slices of a repair go on until so much time has passed since the step began; infinite: to its end.
            None: one slice a step, so that the same pairs give the same states.
    """
    until = None if seconds is None else time.monotonic() + seconds
    try:
        (pair,) = check_pairs(state.initial, [pair])
        after = _after_pair(state, pair)
    except InputError as error:
        return without_pair(state, error)
    while until is not None and after.job is not None and time.monotonic() < until:
        after = continued(after)
    return after.replace(frame=state.frame + 1).told()


def without_pair(state: State, error: InputError) -> tuple[State, tuple[Event, ...]]:
    """The state after a pair that cannot be used, and the event, once of several in a row."""
    again = state.last is None and state.reported is Kind.BAD_FRAME
    said = state if again else state.saying(Kind.BAD_FRAME, str(error))
    return said.later().replace(frame=state.frame + 1, last=None, corners=None, reported=Kind.BAD_FRAME).told()


def freeze(state: State, frozen: bool = True) -> State:
    """The same state, in which nothing is switched any more; or, not `frozen`, in which it is again."""
    return state.configured(replace(state.config, repair=not frozen))


def rollback(state: State, to: Offset | None = None) -> State:
    """A calibration that was in use before, and frozen: what led away from it would do so again.

    Args:
        to: its offset, one of `state.previous`; default the last one. Those after it are forgotten.

    Raises:
        InputError: if no other has been in use, or not that one.
    """
    if not state.previous:
        raise InputError("no other calibration has been in use; there is nothing to return to.")
    numbers = [number for number, offset in enumerate(state.previous) if to is None or np.array_equal(offset, to)]
    if not numbers:
        raise InputError("that calibration has not been in use, or too long ago; give one of state.previous.")
    earlier = state.previous[: numbers[-1]]
    return freeze(switched(state, state.previous[numbers[-1]]).replace(previous=earlier))


@one_blas_thread()
def _after_pair(state: State, pair: Pair) -> State:
    config, before, current = state.config, state.last, small(pair.left)
    state = state.later().replace(last=current)
    if state.job is not None:
        return continued(state)
    if state.frame % config.every:
        return state
    return _after_look(moved(state, pair), pair, before, current)


def _after_look(state: State, pair: Pair, before: Small | None, current: Small) -> State:
    config = state.config
    if is_coarse(pair):
        return _too_little(state)
    matcher = state.matcher
    if matcher is None:
        if not image_quality(pair).enough:
            return _too_little(state)
        matcher = with_measured_range(config.matcher, pyramid(state.rig, [pair], state.view))
        state = state.replace(matcher=matcher)
    seen = _look(state, pair, matcher)
    if seen is None:
        return _unmatched_pair(state, pair)
    normal, found = seen
    turned = np.zeros(3)  # by which a late shutter would have turned the right image, in a frame
    if not config.synchronous:
        turned = None if before is None else turn(state.initial.left, before, current)
    # Looks have a misfit in common that is in no lens: of more, it would seem to be.
    as_extrinsics = state.as_extrinsics if state.seen >= _LEARN else None
    measured = Measurement(normal, None if turned is None else np.degrees(turned), as_extrinsics)
    state = state.replace(
        seen=state.seen + 1,
        row_error=row_error(found, state.chart, state.theta),
        coverage=state.coverage + covered_by(found, state.rig, state.view),
        unmatched_in_a_row=0,
    )
    state = anchored(state, pair, found)
    told = state.reported in (Kind.DRIFTING, Kind.KNOCK)
    state = followed(state, measured)
    knocked = any(event.kind is Kind.KNOCK for event in state.events)
    if knocked or state.outlier is not None:
        state = state.with_repair_pair(pair).replace(corners=None, outlier_motion=None)
    else:
        state = state.replace(repair_pairs=())
    if knocked and reading(state).rows_px.value > _BLIND:
        return begun(state)
    # One look is no proof; and without an image before it, nobody knows how far a late shutter could explain it.
    return decided(state, found) if told and before is not None else state


def _look(state: State, pair: Pair, matcher: AbstractMatcher) -> tuple[Normal, Correspondences] | None:
    """The likelihood of θ, and the correspondences that it rests on, of a pair through the calibration in use, at half
    scale, solved once: a rig that is watched is not far off. None if too little matches, or what does so by chance."""
    data = pyramid(state.rig, [pair], state.view).at(watching_scale(state.rig.left.size))
    found = correspondences(data, with_unit_baseline(state.rig.extrinsics), matcher)
    if found.covered < ENOUGH.covered or Seen(matches=found.found, places=len(places_of(found))).few:
        return None
    known = state.estimate.widened(DRIFT)
    solved = normal_of_pair(found, state.chart, state.theta, known.theta, known.of_theta)
    if solved is None or (
        is_sparse(found.covered, 1.0)
        and is_sparse(found.covered, image_quality(pair).texture)
        and row_error(found, state.chart, solved[1]) * float(found.scale) > _FALSE
    ):
        return None
    return solved[0], found


def _unmatched_pair(state: State, pair: Pair) -> State:
    """A pair of which hardly anything matches: too little to see, or a rig that is far off."""
    if not image_quality(pair).enough:
        return _too_little(state)
    state = state.with_repair_pair(pair).replace(unmatched_in_a_row=state.unmatched_in_a_row + 1)
    number = state.unmatched_in_a_row
    again = number >= _FIRST and number & (number - 1) == 0  # a power of 2
    return begun(state) if again else state


def _too_little(state: State) -> State:
    kind = Kind.TOO_LITTLE_TEXTURE
    return state if state.reported is kind else state.replace(reported=kind).saying(kind)


@dataclass(frozen=True, eq=False)
class Stepped:
    """The result of a step.

    Attributes:
        pair: the pair; None if its files cannot be read.
        state: after the step.
        events: of the step.
    """

    pair: Pair | Images | None
    state: State
    events: tuple[Event, ...]


def run(
    rig: StereoRig | State,
    pairs: Iterable[Pair | Images],
    config: Config = Config(),  # noqa: B008
    seconds: float | None = math.inf,
) -> Iterator[Stepped]:
    """The results of steps, one for each pair, as the pairs come.

    Args:
        rig: the calibration to start from, or a state to continue from, with its own config.
        pairs: any iterable, such as a recording (damaged files become events), a drive or a camera.
        seconds: time for a repair in each step (`step`); by default a repair is finished within the step.
    """
    state = rig if isinstance(rig, State) else init(rig, config)
    for pair in _read(pairs):
        if isinstance(pair, InputError):
            state, events = without_pair(state, pair)
            yield Stepped(None, state, events)
        else:
            state, events = step(state, pair, seconds)
            yield Stepped(pair, state, events)


def _read(pairs: Iterable[Pair | Images]) -> Iterator[Pair | Images | InputError]:
    """The pairs, or the error in place of a pair that cannot be read."""
    if not isinstance(pairs, LazyPairs):
        yield from pairs
        return
    for number in range(len(pairs)):
        try:
            pair = pairs[number]
        except InputError as error:
            yield error
        else:
            yield pair
