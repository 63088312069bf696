"""Least-squares problems summed over tiles: what solutions and jackknives need of the rows."""

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence


@dataclass(frozen=True, eq=False)
class Sums:
    """Of the rows of a least-squares problem, for each tile of each frame that shows something.

    Attributes:
        normal: (t, n, n) of their weights.
        pull: (t, n) of their residuals.
        weight: (t,).
        frame, place: (t,) of each tile.
    """

    normal: Float[np.ndarray, "t n n"]
    pull: Float[np.ndarray, "t n"]
    weight: Float[np.ndarray, "t"]
    frame: Int[np.ndarray, "t"]
    place: Int[np.ndarray, "t"]

    def of(self, tiles: Bool[np.ndarray, "t"]) -> "Sums":
        """Some of the tiles alone."""
        return Sums(*(getattr(self, part.name)[tiles] for part in fields(self)))


def sums(found: Evidence) -> Sums:
    """The sums of all rows of the evidence."""
    order = np.argsort(found.tile, kind="stable")
    tiles, first = np.unique(found.tile[order], return_index=True)
    bounds = [*first.tolist(), len(order)]
    parts = [order[here:end] for here, end in pairwise(bounds)]
    jacobian, weight = found.jacobian, found.weight

    return Sums(
        normal=np.stack([jacobian[p].T @ (weight[p, None] * jacobian[p]) for p in parts]),
        pull=np.stack([jacobian[p].T @ (weight * found.residual)[p] for p in parts]),
        weight=np.array([weight[p].sum() for p in parts]),
        frame=tiles // TILES_OF_A_FRAME,
        place=tiles % TILES_OF_A_FRAME,
    )
