"""What strategies share that match features in each frame and refine an essential matrix."""

import abc
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome

Matched = tuple[Float[np.ndarray, "m 2"], Float[np.ndarray, "m 2"]]  # pixels, left and right

FEWEST = 8  # our choice: fewer matches hardly overdetermine five parameters


@dataclass(frozen=True)
class AbstractFit(AbstractStrategy):
    """Matches of all frames, an essential matrix (USAC-MAGSAC), and robust least squares of its inliers.

    Attributes:
        features: the most features per image.
        subpixel: whether matches are refined to parts of a pixel (Lucas-Kanade, there and back).
        threshold: the largest epipolar error of an inlier, in pixels.
        loss_scale: Sampson error in pixels beyond which a match counts less than quadratically (soft L1).
        min_matches: the run ends as STALLED with fewer matches or fewer inliers.
    """

    needs: ClassVar[Need] = Need.IMAGES
    positive: ClassVar[tuple[str, ...]] = ()  # further options that must be finite and above 0

    features: int = 4096
    subpixel: bool = False
    threshold: float = 1.0
    loss_scale: float = 0.25
    min_matches: int = 20

    def __post_init__(self) -> None:
        for name in (*self.positive, "threshold", "loss_scale"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"need {name} > 0, got {getattr(self, name)}")
        if not FEWEST <= self.min_matches <= self.features:
            raise ValueError(
                f"need {FEWEST} <= min_matches <= features, got {self.min_matches} and {self.features} features"
            )

    @abc.abstractmethod
    def matched(self, left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"]) -> Matched:
        """Pixels (column, row) in the left and in the right image, grey levels, of what they both show."""

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. `seed` is that of the random samples for the essential matrix."""
        from stereorecal_features._fit import search  # here, since SciPy's optimisers take long to import

        return search(self, objective, start, seed)
