"""Misfit: what the parameters leave of the row differences that stays together over a region.

Noise averages out over a tile of a frame; what does not was in no model: a moved thing, a shutter that rolls in one
image, a stretched image, wrong intrinsics, dirt.
"""

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from stereorecal._plain import plain
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence
from stereorecal.scoring import TILES

_FEWEST = 10  # correspondences in a region: below that its median is mostly noise
_OF_A_MEDIAN = 1.2533 * 1.4826  # standard error of a median over the median deviation, times the root of the number
_REACH = 0.25  # of the image: how far misfit stays alike; a lens, a ship
_EXPLAINS = 0.5  # share of the misfit's square that one more effect must explain to be its likely cause
_NEARLY = 0.8  # of what a lens explains
_IMHOF = (-12.0, 25.0, 4000)  # log of the variable of an integral: from where to where, in how many steps
_MATCHED = 0.3  # of the count of the tile that shows most: a tile that shows something
_KEPT = 0.6  # of its count: below that, a tile has lost its matches
WORTH_SAYING = 0.2  # pixels, of `Misfit.high`
EFFECT = 1.0  # pixels at the edge of the image: standard deviation of an effect that is in no model


class Cause(enum.Enum):
    """What the misfit looks like; the value is the words for it."""

    ROWS = "it grows with the row: a shutter that rolls in one image, or focal lengths that do not fit"
    RADIAL = "it is radial: the lens distortion does not fit"
    REGIONS = "regions lie apart: something moved between the two exposures, or the intrinsics do not fit"


@dataclass(frozen=True, eq=False)
class Misfit:
    """Row differences of regions (tiles of frames that hold enough correspondences), in pixels at full size.

    Attributes:
        frame: (r,) of each region.
        place: (r,) of each region in its frame, numbered by rows of 8 by 6 tiles.
        before, after: (r,) median row difference under the initial calibration, and under the candidate.
        error: (r,) standard error of `after`, by the noise of its correspondences.
        sway: root mean square, over the regions, of the rows by which the solution would move if row differences that
            grow with the row, or are radial, were a possibility: what the data ascribe to the rig but could as well
            ascribe to a shutter or a lens.
        chance: share of drifts in random directions (in units of the prior) that would move the rows as little as this
            one does. A shutter or a moved thing that poses as a drift needs a strange one.
        lost: share of the tiles that matched under the initial calibration and no longer do.
        cause: what it looks like.
    """

    frame: Int[np.ndarray, "r"]
    place: Int[np.ndarray, "r"]
    before: Float[np.ndarray, "r"]
    after: Float[np.ndarray, "r"]
    error: Float[np.ndarray, "r"]
    sway: float
    chance: float
    lost: float
    cause: Cause

    @property
    def rms(self) -> float:
        """Root mean square of `after`, less what noise explains."""
        return _beyond_noise(self.after, self.error)

    @property
    def rms_before(self) -> float:
        """The same of `before`."""
        return _beyond_noise(self.before, self.error)

    @property
    def alike(self) -> float:
        """Root mean product of `after` of regions side by side: the part of the misfit that neighbours share. Where
        regions err each for itself, as windows on slants do, it is near 0, and the resampling of places knows the
        scatter already."""
        grids = np.full((int(self.frame.max(initial=-1)) + 1, TILES[1], TILES[0]), np.nan)
        grids[self.frame, self.place // TILES[0], self.place % TILES[0]] = self.after
        beside = [grids[:, 1:] * grids[:, :-1], grids[:, :, 1:] * grids[:, :, :-1]]
        products = np.concatenate([product[np.isfinite(product)] for product in beside])
        shared = float(np.sqrt(max(float(products.mean()), 0.0))) if products.size else self.rms
        return min(shared, self.rms)

    @property
    def high(self) -> float:
        """The 90th percentile of |after|, less a standard error each."""
        apart = np.maximum(np.abs(self.after) - self.error, 0.0)
        return float(np.quantile(apart, 0.9)) if apart.size else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        names = (
            "frame",
            "place",
            "before",
            "after",
            "error",
            "rms",
            "rms_before",
            "alike",
            "high",
            "sway",
            "chance",
            "lost",
        )
        return plain({**{name: getattr(self, name) for name in names}, "cause": self.cause.name.lower()})


def _beyond_noise(medians: Float[np.ndarray, "r"], error: Float[np.ndarray, "r"]) -> float:
    return float(np.sqrt(max(np.mean(medians**2 - error**2), 0.0))) if medians.size else 0.0


def misfit(
    found: Evidence,
    counts_before: Int[np.ndarray, "k tiles"] | None = None,
    counts_after: Int[np.ndarray, "k tiles"] | None = None,
) -> Misfit:
    """The misfit of a solution.

    Args:
        counts_before, counts_after: of the tiles, under the initial calibration and the candidate, if they are known.
    """
    tiles, counts = np.unique(found.tile, return_counts=True)
    regions = []
    for tile, number in zip(tiles, counts, strict=True):
        if number >= _FEWEST:
            here = found.tile == tile
            before, after = (float(np.median(r[here])) for r in (found.start_residual, found.residual))
            spread = float(np.median(np.abs(found.residual[here] - after)))
            error = _OF_A_MEDIAN * spread / float(number * found.independent) ** 0.5
            regions.append((*divmod(int(tile), TILES_OF_A_FRAME), before, after, error))
    frame, place, *medians = np.array(regions, float).reshape(-1, 5).T
    frame, place = frame.astype(int), place.astype(int)
    return Misfit(
        frame,
        place,
        *medians,
        sway=_sway(found),
        chance=chance(found),
        lost=_lost(counts_before, counts_after),
        cause=_cause(place, medians[1]),
    )


def chance(found: Evidence) -> float:
    """See `Misfit.chance`; of all parameters of the evidence."""
    rows = found.jacobian.T @ (found.weight[:, None] * found.jacobian)
    length2 = float(found.z @ found.z)
    if length2 == 0.0 or not rows.any():
        return 1.0
    return share_below(np.linalg.eigvalsh(rows), float(found.z @ rows @ found.z) / length2)


def share_below(stretches: Float[np.ndarray, "n"], limit: float) -> float:
    """The share of directions u, evenly spread, for which the sum of stretches u² stays below the limit.

    It is the chance that a sum of (stretch - limit) chi² falls below zero, by the integral of Imhof (1961, eq. 3.2).
    """
    apart = (stretches - limit) / max(float(np.abs(stretches - limit).max()), 1e-300)
    t = np.exp(np.linspace(*_IMHOF))[:, None]
    angle = 0.5 * np.arctan(apart * t).sum(axis=1)
    heights = np.sin(angle) / np.prod((1.0 + (apart * t) ** 2) ** 0.25, axis=1)  # over t, times dt = t d(log t)
    step = (_IMHOF[1] - _IMHOF[0]) / (_IMHOF[2] - 1)
    return float(np.clip(0.5 - np.sum(heights) * step / np.pi, 0.0, 1.0))


def _lost(before: Int[np.ndarray, "k tiles"] | None, after: Int[np.ndarray, "k tiles"] | None) -> float:
    """See `Misfit.lost`."""
    if before is None or after is None:
        return 0.0
    matched = before > _MATCHED * max(1, before.max())
    return float(np.mean(after[matched] < _KEPT * before[matched])) if matched.any() else 0.0


def _sway(found: Evidence) -> float:
    """See `Misfit.sway`: the solution is compared with that of a problem with the two effects beside the rig's axes."""
    x, y = _centres(found.tile % TILES_OF_A_FRAME)
    effects = np.stack([y, (x * x + y * y) * y], axis=-1)
    jacobian = np.concatenate([found.jacobian, effects], axis=-1)
    weighted = jacobian * found.weight[:, None]
    dim = found.z.size
    prior = np.concatenate([np.full(dim, found.prior**-2.0), np.full(2, EFFECT**-2.0)])
    here = np.concatenate([found.z, np.zeros(2)])
    with_effects = -np.linalg.solve(jacobian.T @ weighted + np.diag(prior), weighted.T @ found.residual + prior * here)
    moved = found.jacobian @ (with_effects[:dim] - found.shift)
    return float(np.sqrt(found.weight @ moved**2 / max(float(found.weight.sum()), 1e-12)))


def systematic(found: Evidence, seen: Misfit) -> Float[np.ndarray, "n n"]:
    """What misfit adds to the covariance of the solution, in units of the box.

    Over regions it is alike up to a quarter of the image, and at one place in all frames, as a lens or a rig's own bow
    is; resampling of places takes them for independent.
    """
    pulls = np.stack(
        [
            found.jacobian[here].T @ found.curvature[here]
            for here in (found.tile % TILES_OF_A_FRAME == place for place in range(TILES_OF_A_FRAME))
        ]
    )
    return spread_of_misfit(np.linalg.solve(found.normal, pulls.T), seen.alike)


def spread_of_misfit(moves: Float[np.ndarray, "n places"], pixels: float) -> Float[np.ndarray, "n n"]:
    """The covariance of a solution that moves so much for a pixel at each place of the frames, if so many pixels
    of misfit lie on them."""
    x, y = _centres(np.arange(TILES_OF_A_FRAME))
    distance2 = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2
    return pixels**2 * moves @ np.exp(-0.5 * distance2 / (2 * _REACH) ** 2) @ moves.T


def _centres(place: Int[np.ndarray, "r"]) -> tuple[Float[np.ndarray, "r"], Float[np.ndarray, "r"]]:
    """Of tiles, from -1 to 1 over the image."""
    row, column = np.divmod(place, TILES[0])
    return (2 * column + 1) / TILES[0] - 1, (2 * row + 1) / TILES[1] - 1


def _cause(place: Int[np.ndarray, "r"], after: Float[np.ndarray, "r"]) -> Cause:
    """The effect beside those of a rotation that explains at least half of the misfit, if there is one; the simpler one
    where it does nearly as well."""
    if after.size < TILES_OF_A_FRAME // 4:
        return Cause.REGIONS
    x, y = _centres(place)
    rotations = [np.ones_like(x), x, x * y, y * y]  # pitch, roll, yaw: what they may leave of themselves
    left = max(_unexplained(after, rotations), 1e-12)
    of_rows = 1.0 - _unexplained(after, [*rotations, y]) / left
    of_lens = 1.0 - _unexplained(after, [*rotations, y, (x * x + y * y) * y]) / left
    if of_lens < _EXPLAINS:
        return Cause.REGIONS
    return Cause.ROWS if of_rows >= _NEARLY * of_lens else Cause.RADIAL


def _unexplained(values: Float[np.ndarray, "r"], effects: list[Float[np.ndarray, "r"]]) -> float:
    columns = np.stack(effects, axis=-1)
    return float(np.sum((values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]) ** 2))
