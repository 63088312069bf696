"""The tracker: corners of the left image, followed to its partner and into the next pair."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float, UInt8

from stereorecal._arrays import eight_bit
from stereorecal.geometry import StereoRig
from stereorecal.recordings import Pair
from stereorecal.scoring._correspondences import Correspondences, Tracks

_MOST = 2000  # corners
_NEAR = 1.5  # cells of dense correspondences
_QUALITY, _APART = 0.005, 6  # of the best corner's response; pixels between corners
_WINDOW = 15  # pixels
_LEVELS = 4  # of the pyramid in time; disparities are known to a pixel or so
_LEVELS_AGAIN = 2  # of disparities that were known a moment before
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

    @staticmethod
    def of(found: Correspondences, rig: StereoRig, frame: int = 0) -> "Matches":
        """Those of a frame.

        Args:
            rig: whose cameras gave the rays of the correspondences.
        """
        valid = np.asarray(found.weight[frame]) > 0
        left, right = (np.asarray(rays[frame], float)[valid] for rays in (found.left, found.right))
        return Matches(np.asarray(rig.left.project(left)), np.asarray(rig.right.project(right)))


def match_radius(found: Correspondences, rig: StereoRig) -> float:
    """Pixels at full size: what is farther from all correspondences is of something else."""
    width, height = rig.left.size
    return _NEAR * float(np.sqrt(width * height / found.weight.shape[1]))


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of one pair, until a later one shows them again.

    Attributes:
        image: the left image, 8 bit.
        left, right: (m, 2) pixels (column, row) at full size.
    """

    image: UInt8[np.ndarray, "h w"]
    left: Float[np.ndarray, "m 2"]
    right: Float[np.ndarray, "m 2"]


def corners(pair: Pair, matches: Matches, radius: float, most: int) -> Corners:
    """At most so many corners that both images of a pair show; `radius` as `tracked` has it."""
    left, right = eight_bit(pair.left), eight_bit(pair.right)
    found = cv2.goodFeaturesToTrack(left, most, _QUALITY, _APART)
    if found is None:
        return Corners(left, np.zeros((0, 2)), np.zeros((0, 2)))
    start = found.reshape(-1, 2)
    partner, good = _partners(left, right, start, matches, radius)
    return Corners(left, start[good].astype(float), partner[good].astype(float))


def corner_tracks(before: Corners, pair: Pair) -> Tracks:
    """Corners that both images of a later pair show again, whose disparities are about as they were."""
    moves = (before.right - before.left).astype(np.float32)
    return _tracks(before, pair, lambda left, right, later: _followed(left, right, later, later + moves, _LEVELS_AGAIN))


def tracked(first: Pair, second: Pair, matches: tuple[Matches, Matches], radius: float) -> Tracks:
    """Corners that all four images of two consecutive pairs show.

    Args:
        matches: of each pair.
        radius: pixels: corners that are farther from all matches are left out.
    """
    before = corners(first, matches[0], radius, _MOST)
    return _tracks(before, second, lambda left, right, later: _partners(left, right, later, matches[1], radius))


def _tracks(before: Corners, pair: Pair, partners: Callable[..., tuple[np.ndarray, Bool[np.ndarray, "n"]]]) -> Tracks:
    """Corners that both images of a later pair show again; `partners(left, right, pixels)` finds those of the left
    image in the right one, and says which are good."""
    if not len(before.left) or before.image.shape != pair.left.shape:
        return Tracks(np.zeros((2, 0, 2)), np.zeros((2, 0, 2)))
    left, right = eight_bit(pair.left), eight_bit(pair.right)
    start = before.left.astype(np.float32)
    later, good = _followed(before.image, left, start, start, _LEVELS)
    partner, found = partners(left, right, later)
    tracks = Tracks(np.stack([start, later]).astype(float), np.stack([before.right, partner]).astype(float))
    return tracks.of(good & found)


def _partners(
    left: np.ndarray, right: np.ndarray, pixels: np.ndarray, matches: Matches, radius: float
) -> tuple[np.ndarray, Bool[np.ndarray, "n"]]:
    """Pixels of the left image in the right one, and whether they are near the nearest match, and where it says."""
    from scipy.spatial import KDTree

    if not len(matches.left):
        return pixels, np.zeros(len(pixels), bool)
    away, nearest = KDTree(matches.left).query(pixels)
    guess = pixels + (matches.right - matches.left)[nearest]
    partner, good = _followed(left, right, pixels, guess.astype(np.float32), 1)
    return partner, good & (away < radius) & (np.linalg.norm(partner - guess, axis=1) < _FROM_GUESS)


def _followed(
    one: np.ndarray, other: np.ndarray, pixels: np.ndarray, guess: np.ndarray, levels: int
) -> tuple[np.ndarray, Bool[np.ndarray, "n"]]:
    """Pixels of one image in another one, and whether the way back ends where it began."""

    def follow(one, other, start, expected):
        found, status, _ = cv2.calcOpticalFlowPyrLK(
            one,
            other,
            start,
            expected.copy(),
            winSize=(_WINDOW, _WINDOW),
            maxLevel=levels - 1,
            criteria=_UNTIL,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return found, status.ravel() > 0

    moved, found = follow(one, other, pixels, guess)
    back, again = follow(other, one, moved, pixels)
    closed = np.linalg.norm(back - pixels, axis=1) < _CLOSED
    height, width = one.shape
    inside = ((moved >= 0.0) & (moved <= [width - 1, height - 1])).all(axis=1)
    return moved, found & again & closed & inside
