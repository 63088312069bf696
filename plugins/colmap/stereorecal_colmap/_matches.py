"""Feature matches between the left and the right images, by COLMAP."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pycolmap
from jaxtyping import Float, Int, UInt8

from stereorecal.recordings import Pair

Pixels = Float[np.ndarray, "m 2"]
PixelsOfFrame = Float[np.ndarray, "_ 2"]  # each frame has its own number of matches


@dataclass(frozen=True, eq=False)
class Matches:
    """What was matched in all frames.

    Attributes:
        left, right: (m, 2) pixels in COLMAP's terms.
        frame: (m,) number of the frame.
    """

    left: Pixels
    right: Pixels
    frame: Int[np.ndarray, "m"]

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, chosen: np.ndarray) -> "Matches":
        return Matches(self.left[chosen], self.right[chosen], self.frame[chosen])


def matched_pixels(pair: Pair) -> tuple[Pixels, Pixels]:
    """Pixels, left and right, of features that match."""
    extractor, matcher = pycolmap.FeatureExtractor.create(), pycolmap.FeatureMatcher.create()
    features = [extractor.extract_from_uint8_array(_grey_levels(image)) for image in (pair.left, pair.right)]
    left, right = (np.array([(point.x, point.y) for point in points]).reshape(-1, 2) for points, _ in features)
    if min(len(left), len(right)) == 0:
        return left[:0], right[:0]
    matches = matcher.match(*features[0], *features[1])
    return left[matches[:, 0]], right[matches[:, 1]]


def pooled(pixels: Sequence[tuple[PixelsOfFrame, PixelsOfFrame]]) -> Matches:
    """The matches of all frames, one after the other."""
    left, right = (np.concatenate(side) for side in zip(*pixels, strict=True))
    return Matches(left, right, np.repeat(np.arange(len(pixels)), [len(one) for one, _ in pixels]))


def _grey_levels(image: Float[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w"]:
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)
