"""Which frames of several tell the most."""

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np

from stereorecal.recordings import Pair

_WIDTH = 128  # pixels: at which texture is looked at; what is finer is noise as often
_STEEP = 31.0  # grey levels of the x-Sobel response: matchers cut it there


def informative(pairs: Sequence[Pair], most: int) -> tuple[Pair, ...]:
    """At most `most` of the pairs, in order: the one with the most texture of each of as many equal stretches, so that
    they show different moments."""
    if len(pairs) <= most:
        return tuple(pairs)
    bounds = np.linspace(0, len(pairs), most + 1).round().astype(int)
    stretches = [pairs[first:end] for first, end in pairwise(bounds)]
    return tuple(max(stretch, key=_texture) for stretch in stretches)  # one after the other: they may lie in a video


def _texture(pair: Pair) -> float:
    """The mean response of an x-Sobel filter to the left image, steep edges counted once."""
    width, height = pair.size
    small = cv2.resize(pair.left, (_WIDTH, max(1, height * _WIDTH // width)), interpolation=cv2.INTER_AREA)
    return float(np.minimum(np.abs(cv2.Sobel(small, cv2.CV_32F, 1, 0)), _STEEP).mean())
