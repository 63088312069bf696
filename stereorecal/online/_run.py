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
    """What a step left.

    Attributes:
        pair: that came; None for one of a recording whose files cannot be read.
        state: after it.
        events: that happened.
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
    """A step for each pair, as they come.

    Args:
        rig: the calibration to start from, or a state to go on from (whose own config counts).
        pairs: any iterable: a recording, of which damaged files are events, a drive, a camera.
        seconds: of each step, for a repair, as `step` has it; default all that it takes.
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
    """The pairs; of a recording that is read as it is used, also why one cannot be read."""
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
