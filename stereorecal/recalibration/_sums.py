"""Least-squares problems summed over tiles: what solutions, jackknives and cross-validation need of the rows."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence

# Pixels at full size: standard deviation of what the rows of a tile share. Rigs with perfect intrinsics leave 0.02 to
# 0.04, real ones more; solutions differ little from 0.03 to 0.1.
_OF_A_TILE = 0.05
# The same of what the tiles at one place share in all frames: ground slants there always, a lens bows there always.
_OF_A_PLACE = 0.02


@dataclass(frozen=True, eq=False)
class Sums:
    """Of the rows of a least-squares problem, for each tile of each frame that shows something.

    Attributes:
        normal: (t, n, n) of their weights.
        bent: (t, n, n) of the curvatures of their losses.
        pull: (t, n) of their residuals.
        offset: (t, n) of an offset that all share, by the curvatures.
        weight: (t,).
        frame, place: (t,) of each tile.
    """

    normal: Float[np.ndarray, "t n n"]
    bent: Float[np.ndarray, "t n n"]
    pull: Float[np.ndarray, "t n"]
    offset: Float[np.ndarray, "t n"]
    weight: Float[np.ndarray, "t"]
    frame: Int[np.ndarray, "t"]
    place: Int[np.ndarray, "t"]

    def of(self, tiles: Bool[np.ndarray, "t"]) -> "Sums":
        """Some of the tiles alone."""
        return Sums(*(getattr(self, part.name)[tiles] for part in fields(self)))

    def scaled(self, by: Float[np.ndarray, "t"]) -> "Sums":
        """Each tile's sums times a factor."""
        names = ("normal", "bent", "pull", "offset", "weight")
        sums = {name: getattr(self, name) for name in names}
        return replace(self, **{name: by.reshape(-1, *[1] * (s.ndim - 1)) * s for name, s in sums.items()})


def calmed(parts: Sequence[Sums]) -> tuple[Sums, ...]:
    """Votes bounded, of each tile and of each place: rows that err together, by some hundredths of a pixel whatever
    their number, tell no more for being many.

    With a common error of standard deviation s, the information of weight w is w / (1 + s² w). Without it, what windows
    do on slants and lenses do beyond the model would be bought with focal lengths percents away.
    """
    tiles = [part.scaled(1.0 / (1.0 + _OF_A_TILE**2 * part.weight)) for part in parts]
    places = np.sum([np.bincount(part.place, part.weight, TILES_OF_A_FRAME) for part in tiles], axis=0)
    return tuple(part.scaled(1.0 / (1.0 + _OF_A_PLACE**2 * places[part.place])) for part in tiles)


def sums(found: Evidence) -> Sums:
    """The sums of all rows of the evidence."""
    order = np.argsort(found.tile, kind="stable")
    tiles, first = np.unique(found.tile[order], return_index=True)
    bounds = [*first.tolist(), len(order)]
    parts = [order[here:end] for here, end in pairwise(bounds)]
    jacobian, weight, curvature = found.jacobian, found.weight, found.curvature

    def products(of: Float[np.ndarray, "m"]) -> Float[np.ndarray, "t n n"]:
        return np.stack([jacobian[p].T @ (of[p, None] * jacobian[p]) for p in parts])

    def pulls(of: Float[np.ndarray, "m"]) -> Float[np.ndarray, "t n"]:
        return np.stack([jacobian[p].T @ of[p] for p in parts])

    return Sums(
        normal=products(weight),
        bent=products(curvature),
        pull=pulls(weight * found.residual),
        offset=pulls(curvature),
        weight=np.array([weight[p].sum() for p in parts]),
        frame=tiles // TILES_OF_A_FRAME,
        place=tiles % TILES_OF_A_FRAME,
    )
