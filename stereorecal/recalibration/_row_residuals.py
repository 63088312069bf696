"""What a rig leaves of the row differences of the last correspondences, tile by tile.

Within a tile errors go together (windows overlap, a surface is smooth or a texture repeats); and what a tile shows in
one frame it may show in the next (a rig at rest, its own bow), so the tiles at one place of all frames are one unit.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart, differences_at
from stereorecal.scoring import TILES, Correspondences

TILES_OF_A_FRAME = TILES[0] * TILES[1]


@dataclass(frozen=True, eq=False)
class RowErrors:
    """|Row difference| of the correspondences, pixels at full size: the mean over the tiles of a tile's median.

    Attributes:
        before: under the initial calibration.
        after: under the candidate.
        significance: of the gain, in standard errors over the places of tiles in the frames.
    """

    before: float
    after: float
    significance: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RowResiduals:
    """Row differences under a rig, and under the initial one.

    Attributes:
        residual: (m,) pixels at full size.
        start_residual: (m,) the same under the initial calibration.
        tile: (m,) which tile of which frame.
        independent: share of the row differences that carry independent information.
    """

    residual: Float[np.ndarray, "m"]
    start_residual: Float[np.ndarray, "m"]
    tile: Int[np.ndarray, "m"]
    independent: float = 1.0

    @property
    def place(self) -> Int[np.ndarray, "m"]:
        """At which place of its frame each tile lies."""
        return self.tile % TILES_OF_A_FRAME

    @property
    def places(self) -> int:
        """How many places of the frames show something."""
        return len(np.unique(self.place))

    def medians(self, differences: Float[np.ndarray, "m"]) -> Float[np.ndarray, "t"]:
        """The median |difference| in each tile."""
        size = np.abs(differences)
        size = size[np.lexsort((size, self.tile))]
        count = np.unique(self.tile, return_counts=True)[1]
        first = np.cumsum(count) - count
        return 0.5 * (size[first + (count - 1) // 2] + size[first + count // 2])

    def by_place(self, values: Float[np.ndarray, "t"]) -> Float[np.ndarray, "p"]:
        """The mean over the frames of what is said of each tile: at each place that shows something."""
        places, where = np.unique(np.unique(self.tile) % TILES_OF_A_FRAME, return_inverse=True)
        return np.bincount(where, values, len(places)) / np.bincount(where, minlength=len(places))

    @property
    def errors(self) -> RowErrors:
        """The row errors of what each tile shows, before and after."""
        before, after = self.medians(self.start_residual), self.medians(self.residual)
        gain = self.by_place(before - after)
        error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
        return RowErrors(float(np.mean(before)), float(np.mean(after)), float(np.mean(gain)) / max(error, 1e-9))


def places_of(found: Correspondences) -> Int[np.ndarray, "p"]:
    """The places of a frame at which correspondences show something, in any frame."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


def row_residuals(chart: RigChart, found: Correspondences, candidate: StereoRig) -> RowResiduals:
    """Row differences of correspondences, under the initial calibration, which the box is centred on, and a
    candidate."""
    valid, scale, z = np.asarray(found.weight) > 0, float(found.scale), chart.coordinates_of(candidate)
    after, before = (differences_at(found, chart, at)[valid] / scale for at in (z, np.zeros_like(z)))
    return RowResiduals(
        residual=after,
        start_residual=before,
        tile=np.asarray(found.tile)[valid],
        independent=float(found.independent),
    )
