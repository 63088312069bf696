"""What all strategies of this plug-in check of their options."""

from typing import Protocol, runtime_checkable

import numpy as np

FEWEST = 8  # our choice: fewer matches hardly overdetermine five parameters


@runtime_checkable
class Options(Protocol):
    """Of a fit to matches.

    Attributes:
        features: the most features per image.
        subpixel: whether matches are refined to parts of a pixel.
        threshold: the largest epipolar error of an inlier, in pixels.
        loss_scale: Sampson error in pixels beyond which a match counts less than quadratically.
        min_matches: with fewer matches or inliers the run ends.
    """

    @property
    def features(self) -> int: ...
    @property
    def subpixel(self) -> bool: ...
    @property
    def threshold(self) -> float: ...
    @property
    def loss_scale(self) -> float: ...
    @property
    def min_matches(self) -> int: ...


def check_options(options: Options, *positive: str) -> None:
    """Args: positive: names of further options that are finite and above 0.

    Raises:
        ValueError: if one makes no sense.
    """
    for name in (*positive, "threshold", "loss_scale"):
        if not 0.0 < getattr(options, name) < np.inf:
            raise ValueError(f"need {name} > 0, got {getattr(options, name)}")
    if not FEWEST <= options.min_matches <= options.features:
        raise ValueError(
            f"need {FEWEST} <= min_matches <= features, got {options.min_matches} and {options.features} features"
        )
