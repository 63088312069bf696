"""What a rig leaves of the row differences of the last correspondences, tile by tile, and the misfit: what of it stays
together over a region.

Within a tile errors go together (windows overlap, a surface is smooth or a texture repeats); and what a tile shows in
one frame it may show in the next (a rig at rest, its own bow), so the tiles at one place of all frames are one unit.
Noise averages out over a tile; what does not was in no model: a moved thing, a shutter that rolls in one image, a
stretched image, wrong intrinsics, dirt.
"""

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._arrays import group_medians, json_data
from stereorecal.geometry import StereoRig
from stereorecal.objectives import RigChart, differences_at
from stereorecal.scoring import TILES, Correspondences

TILES_OF_A_FRAME = TILES[0] * TILES[1]
_FEWEST = 10  # correspondences in a region: below that its median is mostly noise
_OF_A_MEDIAN = 1.2533 * 1.4826  # standard error of a median over the median deviation, times the root of the number
_EXPLAINS = 0.5  # share of the misfit's square that one more effect must explain to be its likely cause
_NEARLY = 0.8  # of what a lens explains
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
    def errors(self) -> RowErrors:
        """The epipolar errors of what each tile shows, before and after."""
        return RowErrors(*(float(tile_medians(of, self.tile).mean()) for of in (self.start_residual, self.residual)))


def tile_medians(differences: Float[np.ndarray, "m"], tile: Int[np.ndarray, "m"]) -> Float[np.ndarray, "t"]:
    """The median |difference| in each tile."""
    _, number, counts = np.unique(tile, return_inverse=True, return_counts=True)
    return group_medians(np.abs(differences), number, counts)


def places_of(found: Correspondences) -> Int[np.ndarray, "p"]:
    """The places of a frame at which correspondences show something, in any frame."""
    return np.unique(np.asarray(found.tile)[np.asarray(found.weight) > 0] % TILES_OF_A_FRAME)


def row_residuals(chart: RigChart, found: Correspondences, candidate: StereoRig) -> RowResiduals:
    """Row differences of correspondences, under the initial calibration, which the box is centred on, and a
    candidate."""
    valid, scale, z = np.asarray(found.weight) > 0, float(found.scale), chart.coordinates_of(candidate)
    after, before = (differences_at(found, chart, at)[valid] / scale for at in (z, np.zeros_like(z)))
    return RowResiduals(
        residual=after, start_residual=before, tile=np.asarray(found.tile)[valid], independent=float(found.independent)
    )


class Cause(enum.Enum):
    """What the misfit looks like; the value is the words for it."""

    ROWS = "it grows with the row: a shutter that rolls in one image, or focal lengths that do not fit"
    RADIAL = "it is radial: the lens distortion does not fit"
    LATE = "the two images of a pair are not taken at the same time"
    REGIONS = (
        "regions differ in epipolar error: something moved between the two exposures, or the intrinsics do not fit"
    )


@dataclass(frozen=True, eq=False)
class Misfit:
    """Row differences of regions (tiles of frames that hold enough correspondences), in pixels at full size.

    Attributes:
        frame: (r,) of each region.
        place: (r,) of each region in its frame, numbered by rows of 8 by 6 tiles.
        before, after: (r,) median row difference under the initial calibration, and under the candidate.
        error: (r,) standard error of `after`, by the noise of its correspondences.
        cause: what it looks like.
    """

    frame: Int[np.ndarray, "r"]
    place: Int[np.ndarray, "r"]
    before: Float[np.ndarray, "r"]
    after: Float[np.ndarray, "r"]
    error: Float[np.ndarray, "r"]
    cause: Cause

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
        return json_data({**{name: getattr(self, name) for name in names}, "cause": self.cause.name.lower()})


def _beyond_noise(medians: Float[np.ndarray, "r"], error: Float[np.ndarray, "r"]) -> float:
    return float(np.sqrt(max(np.mean(medians**2 - error**2), 0.0))) if medians.size else 0.0


def misfit(found: RowResiduals, *, late: bool = False) -> Misfit:
    """The misfit of a solution; a late shutter is its cause, if there is one."""
    tiles, number, counts = np.unique(found.tile, return_inverse=True, return_counts=True)
    before, after = (group_medians(rows, number, counts) for rows in (found.start_residual, found.residual))
    spread = group_medians(np.abs(found.residual - after[number]), number, counts)
    error = _OF_A_MEDIAN * spread / np.sqrt(counts * found.independent)
    enough = counts >= _FEWEST
    frame, place = np.divmod(tiles[enough], TILES_OF_A_FRAME)
    cause = Cause.LATE if late else _cause(place, after[enough])
    return Misfit(frame, place, before[enough], after[enough], error[enough], cause)


def _cause(place: Int[np.ndarray, "r"], after: Float[np.ndarray, "r"]) -> Cause:
    """The effect beside those of a rotation that explains at least half of the misfit, if there is one; the simpler one
    where it does nearly as well."""
    if after.size < TILES_OF_A_FRAME // 4:
        return Cause.REGIONS
    row, column = np.divmod(place, TILES[0])
    x, y = (2 * column + 1) / TILES[0] - 1, (2 * row + 1) / TILES[1] - 1  # centres of tiles, the image being -1 to 1
    rotations = [np.ones_like(x), x, x * y, y * y]  # pitch, roll, yaw: what they may leave of themselves
    unexplained = max(_unexplained(after, rotations), 1e-12)
    of_rows = 1.0 - _unexplained(after, [*rotations, y]) / unexplained
    of_lens = 1.0 - _unexplained(after, [*rotations, y, (x * x + y * y) * y]) / unexplained
    if of_lens < _EXPLAINS:
        return Cause.REGIONS
    return Cause.ROWS if of_rows >= _NEARLY * of_lens else Cause.RADIAL


def _unexplained(values: Float[np.ndarray, "r"], effects: list[Float[np.ndarray, "r"]]) -> float:
    columns = np.stack(effects, axis=-1)
    return float(np.sum((values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]) ** 2))
