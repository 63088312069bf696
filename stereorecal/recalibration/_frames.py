"""Which frames of a long recording a joint solution looks at."""

from collections.abc import Sequence

from stereorecal.recordings import Pair, Range
from stereorecal.scoring import informative

MOST_FRAMES = 24  # of a recording: more of one place tell hardly more, and each costs a match


def chosen_frames(pairs: Sequence[Pair], most: int = MOST_FRAMES) -> tuple[Pair, ...]:
    """At most so many of the pairs, in order: of equal stretches, which are moments apart, the ones with the most
    texture."""
    return informative(pairs, most)


def looked_at(pairs: Sequence[Pair], ranges: Sequence[Range]) -> tuple[int, ...]:
    """Numbers of the chosen frames, and of those that (resolved) ranges name."""
    wanted = {id(pair) for pair in chosen_frames(pairs)} | {id(one.pair) for one in ranges}
    return tuple(number for number, pair in enumerate(pairs) if id(pair) in wanted)
