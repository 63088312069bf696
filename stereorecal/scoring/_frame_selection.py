"""Frame selection: the frames with the most texture, spread over a recording."""

from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from stereorecal.recordings import Pair
from stereorecal.scoring._image_quality import x_slopes

_RECENT = 16  # pairs that are held at once: a tenth of a second, at up to 160 pairs a second
_STEEP = 31.0  # grey levels of the x-Sobel response: matchers clip it there


def select_frames(
    pairs: Sequence[Pair], most: int, follows: Callable[[Pair, Pair], bool] | None = None
) -> tuple[Pair, ...]:
    """At most `most` of the pairs, in order: of as many equal stretches, the pair with the most texture of each, so
    that they show different moments.

    Args:
        follows: whether a pair follows another; each of half as many stretches then gives a pair and a neighbour: the
            next pair that follows it, else the last one before that it follows.
    """
    if len(pairs) <= most:
        return tuple(pairs)
    bounds = np.linspace(0, len(pairs), (most if follows is None else most // 2) + 1).round().astype(int)
    stretches = [pairs[first:end] for first, end in pairwise(bounds)]
    # One stretch after the other: the pairs may lie in a video.
    if follows is None:
        return tuple(max(stretch, key=_texture) for stretch in stretches)
    return tuple(pair for stretch in stretches for pair in _with_neighbour(stretch, follows))


def _with_neighbour(stretch: Sequence[Pair], follows: Callable[[Pair, Pair], bool]) -> tuple[Pair, ...]:
    """The pair with the most texture, and a neighbour; each pair is read once."""
    best, texture, before, after = None, -1.0, None, None
    recent: deque[Pair] = deque(maxlen=_RECENT)  # the last pair that a pair follows, and those after it
    for pair in stretch:
        while len(recent) > 1 and follows(recent[1], pair):
            recent.popleft()
        if best is not None and after is None and follows(best, pair):
            after = pair
        if (here := _texture(pair)) > texture:
            earlier = recent[0] if recent and follows(recent[0], pair) else None
            best, texture, before, after = pair, here, earlier, None
        recent.append(pair)
    assert best is not None
    if after is not None:
        return best, after
    return (best,) if before is None else (before, best)


def _texture(pair: Pair) -> float:
    """The mean response of an x-Sobel filter to the left image, clipped."""
    return float(np.minimum(np.abs(x_slopes(pair.left)), _STEEP).mean())
