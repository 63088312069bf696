"""Matches of whole pixels, refined to parts of a pixel."""

import cv2
import numpy as np
from jaxtyping import Float

from stereorecal.recordings import Pair

_WINDOW = (11, 11)  # pixels
_UNTIL = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 1e-3)  # steps, pixels
_RETURN = 0.2  # pixels between a feature and where it comes back to
_FARTHEST = 3.0  # pixels that a match may move: beyond it, it is another one


def refined(
    pair: Pair, left: Float[np.ndarray, "m 2"], right: Float[np.ndarray, "m 2"]
) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, "k 2"]]:
    """The matches, the right ones where windows around the left ones lie (Lucas & Kanade 1981). Those that do not come
    back to the left feature, or move far, are left out."""
    if not len(left):
        return left, right
    first, second = (np.clip(np.rint(image), 0, 255).astype(np.uint8) for image in (pair.left, pair.right))
    begun = left.astype(np.float32).reshape(-1, 1, 2), right.astype(np.float32).reshape(-1, 1, 2)
    found, there = _followed(first, second, begun[0], begun[1])
    back, here = _followed(second, first, found, begun[0])
    good = (there.ravel() > 0) & (here.ravel() > 0)
    good &= np.linalg.norm(back - begun[0], axis=-1).ravel() < _RETURN
    good &= np.linalg.norm(found - begun[1], axis=-1).ravel() < _FARTHEST
    return left[good], found.reshape(-1, 2)[good].astype(float)


def _followed(image, other, points, guess):
    """Where windows around points (m, 1, 2) of an image lie in another one, begun at a guess, and whether they do."""
    how = {"winSize": _WINDOW, "criteria": _UNTIL, "flags": cv2.OPTFLOW_USE_INITIAL_FLOW}
    found, there, _ = cv2.calcOpticalFlowPyrLK(image, other, points, guess.copy(), maxLevel=0, **how)
    return found, there
