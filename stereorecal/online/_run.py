"""Steps through a recording, for scripts."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from stereorecal.geometry import StereoRig
from stereorecal.online._config import Config
from stereorecal.online._events import Event
from stereorecal.online._state import State
from stereorecal.online._step import init, step
from stereorecal.recordings import Images, Pair


@dataclass(frozen=True, eq=False)
class Stepped:
    """What a step left.

    Attributes:
        pair: that came.
        state: after it.
        events: that happened.
    """

    pair: Pair | Images
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
        pairs: any iterable: a recording, a drive, a camera.
        seconds: of each step, for a repair, as `step` has it; default all that it takes.
    """
    state = rig if isinstance(rig, State) else init(rig, config)
    for pair in pairs:
        state, events = step(state, pair, seconds)
        yield Stepped(pair, state, events)
