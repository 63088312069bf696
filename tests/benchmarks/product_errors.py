"""A product's rig by rows of its own scenes and of those that were not looked at. Depth is not judged."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal.comparison.judges import ROWS_WORSE, row_error_px
from stereorecal.geometry import StereoRig
from stereorecal.recordings import Scene


@dataclass(frozen=True)
class ByProduct:
    """Median |row difference| of followed corners of each scene [px], under a rig and under the stored one."""

    judged_px: tuple[float, ...]
    stored_px: tuple[float, ...]

    @property
    def against_stored_px(self) -> np.ndarray:
        """How much farther apart rows are than under the stored rig, scene by scene."""
        return np.subtract(self.judged_px, self.stored_px)


def by_product(judged: StereoRig, stored: StereoRig, scenes: Sequence[Scene]) -> ByProduct:
    """Judge a rig by scenes."""
    return ByProduct(*(tuple(row_error_px(rig, stored, scene) for scene in scenes) for rig in (judged, stored)))


def product_is_worse(change: np.ndarray, unseen: slice) -> bool:
    """Whether rows of the first scene, or of those that took no part in the middle, are farther apart than before."""
    return bool(change[0] > ROWS_WORSE or np.median(change[unseen]) > ROWS_WORSE)
