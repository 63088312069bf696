"""The tracker: corners of the left image, followed to its partner and into the next pair."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._cv2 import cv2
from stereorecal.recordings import Pair
from stereorecal.scoring._tracks import Tracks

_MOST = 2000  # corners
_QUALITY, _APART = 0.005, 6  # of the best corner's response; pixels between corners
_WINDOW = 15  # pixels
_LEVELS = 4  # of the pyramid in time; disparities are known to a pixel or so
_CLOSED = 0.3  # pixels that a corner may be off, followed to and fro
_FROM_GUESS = 3.0  # pixels that a partner may lie from where dense correspondences say
_UNTIL = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-4)


class Matches(NamedTuple):
    """Pixels of one pair that show the same: where partners of corners are looked for.

    Attributes:
        left, right: (k, 2) pixels (column, row) at full size.
    """

    left: Float[np.ndarray, "k 2"]
    right: Float[np.ndarray, "k 2"]

    def partners(self, pixels: Float[np.ndarray, "n 2"]) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n"]]:
        """Where pixels of the left image are expected in the right one, by the match that is nearest; and how far away
        that is."""
        from scipy.spatial import KDTree

        away, nearest = KDTree(self.left).query(pixels)
        return pixels + (self.right - self.left)[nearest], away


def tracked(first: Pair, second: Pair, matches: tuple[Matches, Matches], near: float) -> Tracks:
    """Corners that all four images of two consecutive pairs show.

    Args:
        matches: of each pair.
        near: pixels: corners that are farther from all matches are left out.
    """
    left, right = ([_eight_bit(getattr(pair, side)) for pair in (first, second)] for side in ("left", "right"))
    nothing = Tracks(np.zeros((2, 0, 2)), np.zeros((2, 0, 2)))
    if not all(len(one.left) for one in matches):
        return nothing
    corners = cv2.goodFeaturesToTrack(left[0], _MOST, _QUALITY, _APART)
    if corners is None:
        return nothing
    start = corners.reshape(-1, 2)
    later, good = _followed(left[0], left[1], start, start, _LEVELS)
    partners = []
    for frame, corner in enumerate((start, later)):
        guess, away = matches[frame].partners(corner)
        partner, found = _followed(left[frame], right[frame], corner, guess.astype(np.float32), 1)
        good &= found & (away < near) & (np.linalg.norm(partner - guess, axis=1) < _FROM_GUESS)
        partners.append(partner)
    return Tracks(np.stack([start, later]).astype(float), np.stack(partners).astype(float)).of(good)


def _followed(
    one: np.ndarray, other: np.ndarray, pixels: np.ndarray, guess: np.ndarray, levels: int
) -> tuple[np.ndarray, Bool[np.ndarray, "n"]]:
    """Pixels of one image in another one, and whether the way back ends where it began."""

    def follow(here, there, start, expected):
        found, status, _ = cv2.calcOpticalFlowPyrLK(
            here,
            there,
            start,
            expected.copy(),
            winSize=(_WINDOW, _WINDOW),
            maxLevel=levels - 1,
            criteria=_UNTIL,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return found, status.ravel() > 0

    there, found = follow(one, other, pixels, guess)
    back, again = follow(other, one, there, pixels)
    closed = np.linalg.norm(back - pixels, axis=1) < _CLOSED
    height, width = one.shape
    inside = ((there >= 0.0) & (there <= [width - 1, height - 1])).all(axis=1)
    return there, found & again & closed & inside


def _eight_bit(image: Float[np.ndarray, "h w"]) -> np.ndarray:
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)
