"""Which frames of a long recording are looked at, and which of them follow each other."""

from collections.abc import Sequence
from itertools import pairwise, starmap

from stereorecal.recordings import Pair, Range, times_of
from stereorecal.scoring import select_frames

MOST_FRAMES = 24  # of a recording: more of one place tell hardly more, and each costs a match
_LEAST = 0.09  # seconds from one pair to the next: in less, hardly anything moves; 10 Hz, with what clocks err
_SOON = 0.5  # seconds, at most: farther apart, few corners can be followed


def chosen_frames(pairs: Sequence[Pair], most: int = MOST_FRAMES) -> tuple[Pair, ...]:
    """At most so many of the pairs, in order: of equal stretches, which are moments apart, the ones with the most
    texture; where pairs were taken soon after each other, of half as many, each with one a moment later: the rig's
    own motion tells depth."""
    windows = most > 1 and any(starmap(_is_consecutive, pairwise(times_of(pairs))))
    return select_frames(pairs, most, a_moment_after if windows else None)


def soon_after(first: Pair, second: Pair) -> bool:
    """Whether the times of two pairs say that one was taken soon after the other."""
    return _is_consecutive(first.time, second.time)


def a_moment_after(first: Pair, second: Pair) -> bool:
    """The same, and not so soon that nothing has moved: of 30 pairs a second, the third after."""
    return soon_after(first, second) and (second.time or 0.0) - (first.time or 0.0) >= _LEAST


def _is_consecutive(first: float | None, second: float | None) -> bool:
    return first is not None and second is not None and 0.0 < second - first <= _SOON


def selected_frames(pairs: Sequence[Pair], ranges: Sequence[Range]) -> tuple[int, ...]:
    """Numbers of the chosen frames, and of those that (resolved) ranges name; of what was chosen before, all."""
    named = {id(one.pair) for one in ranges}
    few = len(pairs) <= MOST_FRAMES + sum(id(pair) in named for pair in pairs)
    wanted = {id(pair) for pair in (pairs if few else chosen_frames(pairs))} | named
    return tuple(number for number, pair in enumerate(pairs) if id(pair) in wanted)
