"""Row differences tile by tile: the epipolar errors of two rigs, and the misfit, which stays together over regions.

What a tile shows in one frame it may show in the next (a rig at rest, its own bow).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import group_medians, json_data
from stereorecal.scoring import TILES, Correspondences

TILES_OF_A_FRAME = TILES[0] * TILES[1]
_FEWEST = 10  # correspondences in a region: below that its median is mostly noise
_OF_A_MEDIAN = 1.2533 * 1.4826  # standard error of a median over the median deviation, times the root of the number
WORTH_SAYING = 0.2  # pixels, of `Misfit.high`


@dataclass(frozen=True, eq=False)
class RowErrors:
    """|Row difference| of the correspondences, pixels at full size: the mean over the tiles of a tile's median.

    Attributes:
        before: under the initial calibration.
        after: under the candidate.
    """

    before: float
    after: float


def tile_medians(differences: Float[np.ndarray, "m"], tile: Int[np.ndarray, "m"]) -> Float[np.ndarray, "t"]:
    """The median |difference| in each tile."""
    _, number, counts = np.unique(tile, return_inverse=True, return_counts=True)
    return group_medians(np.abs(differences), number, counts)


def places_of(found: Correspondences) -> Int[np.ndarray, "p"]:
    """The places of a frame at which correspondences show something, in any frame."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


@dataclass(frozen=True, eq=False)
class Misfit:
    """Row differences of regions (tiles of frames that hold enough correspondences), in pixels at full size.

    Attributes:
        frame: (r,) of each region.
        place: (r,) of each region in its frame, numbered by rows of 8 by 6 tiles.
        before, after: (r,) median row difference under the initial calibration, and under the candidate.
        error: (r,) standard error of `after`, by the noise of its correspondences.
        late: the two images of a pair are not taken at the same time.
    """

    frame: Int[np.ndarray, "r"]
    place: Int[np.ndarray, "r"]
    before: Float[np.ndarray, "r"]
    after: Float[np.ndarray, "r"]
    error: Float[np.ndarray, "r"]
    late: bool

    @property
    def rms(self) -> float:
        """Root mean square of `after`, less what noise explains."""
        return _beyond_noise(self.after, self.error)

    @property
    def rms_before(self) -> float:
        """Root mean square of `before`, less what noise explains."""
        return _beyond_noise(self.before, self.error)

    @property
    def alike(self) -> float:
        """Root mean product of `after` of regions side by side: the part of the misfit that neighbours share. Where
        regions err each for itself, as windows on slants do, it is near 0."""
        grids = np.full((int(self.frame.max(initial=-1)) + 1, TILES[1], TILES[0]), np.nan)
        grids[self.frame, self.place // TILES[0], self.place % TILES[0]] = self.after
        neighbour_products = [grids[:, 1:] * grids[:, :-1], grids[:, :, 1:] * grids[:, :, :-1]]
        products = np.concatenate([product[np.isfinite(product)] for product in neighbour_products])
        shared = float(np.sqrt(max(float(products.mean()), 0.0))) if products.size else self.rms
        return min(shared, self.rms)

    @property
    def high(self) -> float:
        """The 90th percentile of |after|, less a standard error each."""
        excess = np.maximum(np.abs(self.after) - self.error, 0.0)
        return float(np.quantile(excess, 0.9)) if excess.size else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        names = ("frame", "place", "before", "after", "error", "rms", "rms_before", "alike", "high")
        return json_data({**{name: getattr(self, name) for name in names}, "cause": "late" if self.late else "regions"})


def _beyond_noise(medians: Float[np.ndarray, "r"], error: Float[np.ndarray, "r"]) -> float:
    return float(np.sqrt(max(np.mean(medians**2 - error**2), 0.0))) if medians.size else 0.0


def row_errors_and_misfit(
    before: Float[np.ndarray, "m"],
    after: Float[np.ndarray, "m"],
    tile: Int[np.ndarray, "m"],
    independent: float = 1.0,
    *,
    late: bool = False,
) -> tuple[RowErrors, Misfit]:
    """What row differences show.

    Args:
        before, after: under the initial calibration and under the candidate, pixels at full size.
        tile: which tile of which frame.
        independent: share of the row differences that carry independent information.
        late: whether a shutter is late.
    """
    tiles, number, counts = np.unique(tile, return_inverse=True, return_counts=True)
    errors = RowErrors(*(float(group_medians(np.abs(rows), number, counts).mean()) for rows in (before, after)))
    of_before, of_after = (group_medians(rows, number, counts) for rows in (before, after))
    spread = group_medians(np.abs(after - of_after[number]), number, counts)
    error = _OF_A_MEDIAN * spread / np.sqrt(counts * independent)
    enough = counts >= _FEWEST
    frame, place = np.divmod(tiles[enough], TILES_OF_A_FRAME)
    return errors, Misfit(frame, place, of_before[enough], of_after[enough], error[enough], late)
