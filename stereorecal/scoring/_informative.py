"""Which frames of several tell the most."""

from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise

import cv2
import numpy as np

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: at which texture is looked at; what is finer is noise as often
_RECENT = 16  # pairs that are held at once: a tenth of a second, up to 160 of them a second
_STEEP = 31.0  # grey levels of the x-Sobel response: matchers cut it there


def informative(
    pairs: Sequence[Pair], most: int, follows: Callable[[Pair, Pair], bool] | None = None
) -> tuple[Pair, ...]:
    """At most `most` of the pairs, in order: the one with the most texture of each of as many equal stretches, so that
    they show different moments.

    Args:
        follows: whether a pair follows another; of half as many stretches, each pair then comes with the next one that
            does, or else with the last before that it follows.
    """
    if len(pairs) <= most:
        return tuple(pairs)
    bounds = np.linspace(0, len(pairs), (most if follows is None else most // 2) + 1).round().astype(int)
    stretches = [pairs[first:end] for first, end in pairwise(bounds)]
    # One after the other: they may lie in a video.
    if follows is None:
        return tuple(max(stretch, key=_texture) for stretch in stretches)
    return tuple(pair for stretch in stretches for pair in _window(stretch, follows))


def _window(stretch: Sequence[Pair], follows: Callable[[Pair, Pair], bool]) -> tuple[Pair, ...]:
    """The pair with the most texture, and a neighbour; each pair is read once."""
    best, texture, before, after = None, -1.0, None, None
    recent: deque[Pair] = deque(maxlen=_RECENT)  # the last one that a pair follows, and those after it
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
    """The mean response of an x-Sobel filter to the left image, steep edges counted once."""
    width, height = pair.size
    small = cv2.resize(pair.left, (_WIDTH, max(1, height * _WIDTH // width)), interpolation=cv2.INTER_AREA)
    return float(np.minimum(np.abs(cv2.Sobel(small, cv2.CV_32F, 1, 0)), _STEEP).mean())
