"""Misfit: what the parameters leave of the row differences that stays together over a region.

Noise averages out over a tile of a frame; what does not was in no model: a moved thing, a shutter that rolls in one
image, a stretched image, wrong intrinsics, dirt.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._plain import plain
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence

_FEWEST = 10  # correspondences in a region: below that its median is mostly noise
_OF_A_MEDIAN = 1.2533 * 1.4826  # standard error of a median over the median deviation, times the root of the number


@dataclass(frozen=True, eq=False)
class Misfit:
    """Row differences of regions (tiles of frames that hold enough correspondences), in pixels at full size.

    Attributes:
        frame: (r,) of each region.
        place: (r,) of each region in its frame, numbered by rows of tiles.
        before, after: (r,) median row difference under the initial calibration, and under the candidate.
        error: (r,) standard error of `after`, by the noise of its correspondences.
    """

    frame: Int[np.ndarray, "r"]
    place: Int[np.ndarray, "r"]
    before: Float[np.ndarray, "r"]
    after: Float[np.ndarray, "r"]
    error: Float[np.ndarray, "r"]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return plain({name: getattr(self, name) for name in ("frame", "place", "before", "after", "error")})


def misfit(found: Evidence, independent: float) -> Misfit:
    """The misfit of a solution.

    Args:
        independent: share of the correspondences that carry independent information.
    """
    tiles, counts = np.unique(found.tile, return_counts=True)
    regions = []
    for tile, number in zip(tiles, counts, strict=True):
        if number < _FEWEST:
            continue
        here = found.tile == tile
        before, after = (float(np.median(r[here])) for r in (found.start_residual, found.residual))
        spread = float(np.median(np.abs(found.residual[here] - after)))
        regions.append((*divmod(tile, TILES_OF_A_FRAME), before, after, _OF_A_MEDIAN * spread / (number * independent) ** 0.5))
    columns = np.array(regions, float).reshape(-1, 5).T
    return Misfit(columns[0].astype(int), columns[1].astype(int), *columns[2:])
