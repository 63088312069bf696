"""Steps through a recording, for scripts."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.online._config import Config
from stereorecal.online._events import Event
from stereorecal.online._state import State
from stereorecal.online._step import init, step, without_pair
from stereorecal.recordings import Images, LazyPairs, Pair


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
