"""Least-squares problems summed over tiles: what solutions, jackknives and cross-validation need of the rows."""

from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence

# Pixels at full size: standard deviation of what the rows of a tile share. Rigs with perfect intrinsics leave 0.02 to
# 0.04, real ones more; solutions differ little from 0.03 to 0.1.
_TOGETHER = 0.05


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

    @property
    def calmed(self) -> "Sums":
        """Each tile's vote bounded: its rows err together, by some hundredths of a pixel whatever their number.

        With a common error of standard deviation s, the information of a tile of weight w is w / (1 + s² w). Without
        it, what windows do on slants and lenses do beyond the model would be bought with focal lengths percents away.
        """
        bound = 1.0 / (1.0 + _TOGETHER**2 * self.weight)
        fewer = {
            name: getattr(self, name) * bound.reshape(-1, *[1] * (getattr(self, name).ndim - 1))
            for name in ("normal", "bent", "pull", "offset", "weight")
        }
        return replace(self, **fewer)


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
