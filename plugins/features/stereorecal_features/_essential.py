"""The strategy: SIFT matches and OpenCV's essential matrix, as they are."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome
from stereorecal_features._abstract_fit import FEWEST


@dataclass(frozen=True)
class Essential(AbstractStrategy):
    """OpenCV's essential matrix as it is (SIFT, RANSAC, `cv2.recoverPose`), with nothing after it.

    The matches of all frames are pooled, since the rig is the same, and `cv2.recoverPose` makes a pose of them, with
    its defaults. It refines nothing, and moves the whole pose: axes that are held stay as they are all the same, those
    that are free take its result, with the length of the baseline that x gives, cut at the reach of the search.

    Attributes:
        ratio: Lowe's ratio test, in (0, 1]; OpenCV's tutorial on matching takes 0.7, the one on epipolar geometry 0.8.
        probability, threshold: of RANSAC, and the largest epipolar error of an inlier, in pixels.
        min_matches: the run ends as STALLED with fewer matches.
    """

    needs: ClassVar[Need] = Need.IMAGES

    ratio: float = 0.7
    probability: float = 0.999
    threshold: float = 1.0
    min_matches: int = 20

    def __post_init__(self) -> None:
        if not 0.0 < self.ratio <= 1.0:
            raise ValueError(f"need 0 < ratio <= 1, got {self.ratio}")
        if not 0.0 < self.probability < 1.0:
            raise ValueError(f"need 0 < probability < 1, got {self.probability}")
        if not 0.0 < self.threshold < np.inf:
            raise ValueError(f"need threshold > 0, got {self.threshold}")
        if self.min_matches < FEWEST:
            raise ValueError(f"need min_matches >= {FEWEST}, got {self.min_matches}")

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. OpenCV's RANSAC has no seed to set: it is the same each time."""
        from stereorecal_features._recovered_pose import search

        return search(self, objective, start)
