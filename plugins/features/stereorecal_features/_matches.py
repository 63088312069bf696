"""Feature matches between the left and the right images, as rays of the two cameras."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import Camera, StereoRig

Pixels = Float[np.ndarray, "m 2"]
PixelsOfFrame = Float[np.ndarray, "_ 2"]  # each frame has its own number of matches

# Where a pixel's ray projects farther from the pixel than this, the lens model could not be inverted.
_ROUND_TRIP_PX = 0.05
_SLOPE_STEP = 1e-5  # of the central differences of a projection, in x/z; about the cube root of float64's epsilon


@dataclass(frozen=True, eq=False)
class Described:
    """Features of an image: pixels (column, row), and words that describe what is there."""

    pixels: Pixels
    words: Float[np.ndarray, "m k"]


@dataclass(frozen=True, eq=False)
class Seen:
    """The matched points as one camera sees them.

    Attributes:
        rays: (m, 3) rays (x/z, y/z, 1), camera frame.
        per_px: (m, 2, 2) derivatives of (x/z, y/z) with respect to the pixel (column, row), lens distortion included.
    """

    rays: Float[np.ndarray, "m 3"]
    per_px: Float[np.ndarray, "m 2 2"]

    def __len__(self) -> int:
        return len(self.rays)

    def __getitem__(self, chosen: Bool[np.ndarray, "m"]) -> "Seen":
        return Seen(self.rays[chosen], self.per_px[chosen])


def matched_pixels(
    left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"], features: int, contrast: float, ratio: float
) -> tuple[Pixels, Pixels]:
    """Pixels (column, row), left and right, of SIFT features that are mutual nearest neighbours by descriptor.

    Args:
        features: the most features per image; those of the highest contrast are kept.
        contrast: OpenCV's `contrastThreshold`.
        ratio: Lowe's ratio test: the most that the nearest distance may be, relative to the second nearest.
    """
    # Without precise upscaling every feature is shifted by a fraction of a pixel.
    sift = cv2.SIFT.create(nfeatures=features, contrastThreshold=contrast, enable_precise_upscale=True)
    return mutual(_described(sift, left), _described(sift, right), ratio=ratio)


def mutual(left: Described, right: Described, distance: float = np.inf, ratio: float = 1.0) -> tuple[Pixels, Pixels]:
    """Pixels of features, left and right, whose words are each other's nearest ones.

    Args:
        distance: the most that they may be apart.
        ratio: as of `matched_pixels`.
    """
    if min(len(left.pixels), len(right.pixels)) < 2:  # there is no second nearest
        return left.pixels[:0], right.pixels[:0]
    # SIFT's words hold integers up to 255, so these sums are exact in float32, in any order.
    apart = np.square(left.words).sum(1)[:, None] + np.square(right.words).sum(1) - 2.0 * left.words @ right.words.T
    everyone, nearest = np.arange(len(apart)), apart.argmin(1)
    chosen = apart.argmin(0)[nearest] == everyone
    first = apart[everyone, nearest]
    chosen &= first < distance**2
    apart[everyone, nearest] = np.inf
    chosen &= first < ratio**2 * apart.min(1)
    return left.pixels[chosen], right.pixels[nearest[chosen]]


def seen_by_both(rig: StereoRig, pixels: Sequence[tuple[PixelsOfFrame, PixelsOfFrame]]) -> tuple[Seen, Seen]:
    """The matched pixels of all frames, as the left and as the right camera see them."""
    left, right = (np.concatenate(side) for side in zip(*pixels, strict=True))
    (left_rays, left_good), (right_rays, right_good) = _rays(rig.left, left), _rays(rig.right, right)
    good = left_good & right_good
    return _seen(rig.left, left_rays[good]), _seen(rig.right, right_rays[good])


def _described(sift: cv2.SIFT, image: Float[np.ndarray, "h w"]) -> Described:
    points, words = sift.detectAndCompute(np.clip(np.rint(image), 0, 255).astype(np.uint8), None)
    pixels = np.array([point.pt for point in points], float).reshape(-1, 2)
    return Described(pixels, np.zeros((0, 128), np.float32) if words is None else words)


def _rays(camera: Camera, pixels: Pixels) -> tuple[Float[np.ndarray, "m 3"], Bool[np.ndarray, "m"]]:
    """The rays through pixels, and whether each lies within the valid range of the lens model."""
    rays = np.asarray(camera.rays(pixels))
    returns = np.abs(camera.project(rays) - pixels).max(1, initial=0.0) < _ROUND_TRIP_PX
    return rays, returns & (np.linalg.norm(rays[:, :2], axis=1) < camera.lens_radius)


def _seen(camera: Camera, rays: Float[np.ndarray, "m 3"]) -> Seen:
    steps = _SLOPE_STEP * np.eye(3)[:2]
    slopes = [(camera.project(rays + step) - camera.project(rays - step)) / (2.0 * _SLOPE_STEP) for step in steps]
    return Seen(rays, np.linalg.inv(np.stack(slopes, axis=-1)))
