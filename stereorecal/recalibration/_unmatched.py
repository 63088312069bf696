"""Frames that hardly match where others do: they show another rig than those, or another time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereorecal.decision import ENOUGH
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, image_quality

_FEWER = 0.5  # of what the frame that matches most covers
MOST_EXCLUDED = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told


def without_frames_of(found: Correspondences, frames: Sequence[int]) -> Correspondences:
    """The correspondences of the other frames."""
    if not len(frames):
        return found
    used = np.isin(np.arange(len(found.weight)), frames, invert=True)
    return replace(found, weight=np.asarray(found.weight) * used[:, None])


def is_sparse(covered: float, texture: float) -> bool:
    """Whether correspondences cover less of an image than those of an aligned rig would, of what has texture; both are
    shares of the image. So many may be there by chance."""
    return covered < ENOUGH.of_texture * texture


def unmatched(found: Correspondences, pairs: Sequence[Pair]) -> tuple[int, ...]:
    """Frames with light and texture that hardly match, where another one does match."""
    covered = (np.asarray(found.weight) > 0).mean(axis=1)
    best = int(covered.argmax())
    fewer = [index for index, share in enumerate(covered) if share < _FEWER * covered[best]]
    if not fewer or is_sparse(covered[best], image_quality(pairs[best]).texture):
        return ()
    quality = {index: image_quality(pairs[index]) for index in fewer}
    return tuple(i for i in fewer if quality[i].enough and is_sparse(covered[i], quality[i].texture))
