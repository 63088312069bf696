"""The strategy: match features, estimate an essential matrix, refine the extrinsics."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal_features._abstract_fit import AbstractFit, Matched


@dataclass(frozen=True)
class Features(AbstractFit):
    """SIFT features, an essential matrix (USAC-MAGSAC) and robust least squares on the images; no score is evaluated.

    The matches of all frames are pooled, since the rig is the same. The inliers of an essential matrix have their
    Sampson errors minimised over all free parameters within the box, once from the start and once from the pose of the
    essential matrix; the result with the lower cost is kept. The inliers are then selected anew and the errors
    minimised again, until the set of inliers does not change.

    It spends no units of the budget: a unit is one run of the stereo matcher, and it runs none. A limit in seconds is
    checked between frames.

    Attributes:
        features: the most features per image; matching them takes about 8 features² bytes.
        contrast: the least contrast of a feature (OpenCV's `contrastThreshold`); lower it where texture is weak.
        ratio: Lowe's ratio test, in (0, 1]; 1 turns it off.
        threshold: the largest epipolar error of an inlier, in pixels.
        loss_scale: Sampson error in pixels beyond which a match counts less than quadratically (soft L1).
        min_matches: the run ends as STALLED with fewer matches or fewer inliers.
        subpixel: whether matches are refined by their windows (Lucas-Kanade, there and back); SIFT has parts of a pixel
            of its own.
    """

    positive: ClassVar[tuple[str, ...]] = ("contrast",)

    features: int = 5000
    contrast: float = 0.04
    ratio: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.ratio <= 1.0:
            raise ValueError(f"need 0 < ratio <= 1, got {self.ratio}")

    def matched(self, left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"]) -> Matched:
        """See `AbstractFit.matched`."""
        from stereorecal_features._matches import matched_pixels  # here, since OpenCV takes long to import

        return matched_pixels(left, right, self.features, self.contrast, self.ratio)
