"""What the last correspondences say about the solution: its covariance, and how it does on data it has not seen.

Everything rests on one linearisation at the solution, cut into tiles. Within a tile errors go together (windows
overlap, a surface is smooth or a texture repeats), so the formal least-squares covariance is too small; and what a tile
shows in one frame it may show in the next (a rig at rest, its own bow), so the tiles at one place of all frames are one
unit of resampling, and are held out together.
"""

from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.objectives import LinearRows, RigChart, differences_at, linearised
from stereorecal.scoring import TILES, Correspondences, Loss, curvatures, precisions

FOLDS = 4
# Standard deviation of an offset that all rows share, pixels of the images that were measured: no resampling sees it.
SHARED = 0.005
TILES_OF_A_FRAME = TILES[0] * TILES[1]


@dataclass(frozen=True, eq=False)
class Evidence:
    """The least-squares problem at the solution, linear in z, the point of the unit box.

    Attributes:
        z: (n,) the solution.
        jacobian: (m, n) of the row differences, pixels at full size.
        residual: (m,) row differences at the solution, pixels at full size.
        start_residual: (m,) the same under the initial calibration.
        weight: (m,) of the squared row differences.
        curvature: (m,) second derivatives of their losses.
        tile: (m,) which tile of which frame.
        prior: standard deviation of the drift on each axis, in half widths of the box.
        scale: pixels at which the rows were measured, per pixel at full size.
        independent: share of the row differences that carry independent information.
    """

    z: Float[np.ndarray, "n"]
    jacobian: Float[np.ndarray, "m n"]
    residual: Float[np.ndarray, "m"]
    start_residual: Float[np.ndarray, "m"]
    weight: Float[np.ndarray, "m"]
    curvature: Float[np.ndarray, "m"]
    tile: Int[np.ndarray, "m"]
    prior: float
    scale: float = 1.0
    independent: float = 1.0

    def of(self, rows: Bool[np.ndarray, "m"]) -> "Evidence":
        """Some of the rows alone."""
        names = ("jacobian", "residual", "start_residual", "weight", "curvature", "tile")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})

    def only(self, parameters: slice | Bool[np.ndarray, "n"]) -> "Evidence":
        """The problem of some of the parameters alone, the others held."""
        return replace(self, z=self.z[parameters], jacobian=self.jacobian[:, parameters])

    @property
    def shift(self) -> Float[np.ndarray, "n"]:
        """From z to the solution of these rows and the prior."""
        normal, pull = self._normal(slice(None), self.weight), self._pull(slice(None))
        return -np.linalg.solve(normal + self._prior, pull + self._prior @ self.z)

    @property
    def normal(self) -> Float[np.ndarray, "n n"]:
        """The normal matrix with the prior's, of the curvatures of the losses."""
        return self._normal(slice(None), self.curvature) + self._prior

    @property
    def _prior(self) -> Float[np.ndarray, "n n"]:
        return np.eye(len(self.z)) / self.prior**2

    def _normal(self, rows, weight: Float[np.ndarray, "m"]) -> Float[np.ndarray, "n n"]:
        jacobian = self.jacobian[rows]
        return jacobian.T @ (weight[rows, None] * jacobian)

    def _pull(self, rows) -> Float[np.ndarray, "n"]:
        return self.jacobian[rows].T @ (self.weight[rows] * self.residual[rows])

    def covariance(self) -> Float[np.ndarray, "n n"]:
        """Of the solution, in units of the box: the jackknife over places, and the prior.

        Each place is left out in turn; how the solution moves then, to first order, is what the data can say of its
        scatter (Efron & Stein 1981; for clusters in least squares: Bell & McCaffrey 2002). What they cannot say, the
        prior does; and an offset that all rows share (of the interpolation, or of two shutters) is added.
        """
        place = self.tile % TILES_OF_A_FRAME
        left_out = [np.flatnonzero(place == p) for p in np.unique(place)]
        if len(left_out) < 2:
            return np.linalg.inv(self._prior)
        normal = self.normal
        pull = self._pull(slice(None)) + self._prior @ self.z
        moves = np.stack(
            [np.linalg.solve(normal - self._normal(p, self.curvature), pull - self._pull(p)) for p in left_out]
        )
        inverse = np.linalg.inv(normal)
        shared = SHARED / self.scale * inverse @ (self.jacobian.T @ self.curvature)
        return jackknife(moves) + inverse @ self._prior @ inverse + np.outer(shared, shared)

    @property
    def frames(self) -> int:
        """How many frames show something."""
        return len(np.unique(self.tile // TILES_OF_A_FRAME))

    @property
    def places(self) -> int:
        """How many places of the frames show something."""
        return len(np.unique(self.tile % TILES_OF_A_FRAME))

    def held_out(self) -> tuple[Float[np.ndarray, "t"], Float[np.ndarray, "t"]]:
        """Median |row difference| in each tile, pixels: under the initial calibration, and under solutions that
        did not see the tile, nor any at its place in another frame."""
        fold = fold_of(self.tile % TILES_OF_A_FRAME)
        unseen = np.empty_like(self.residual)
        for part in np.unique(fold):
            seen = fold != part
            normal, pull = self._normal(seen, self.weight), self._pull(seen)
            shift = -np.linalg.solve(normal + self._prior, pull + self._prior @ self.z)
            unseen[~seen] = self.residual[~seen] + self.jacobian[~seen] @ shift
        return self.medians(self.start_residual), self.medians(unseen)

    def medians(self, differences: Float[np.ndarray, "m"]) -> Float[np.ndarray, "t"]:
        """The median |difference| in each tile."""
        size = np.abs(differences)
        size = size[np.lexsort((size, self.tile))]
        count = np.unique(self.tile, return_counts=True)[1]
        first = np.cumsum(count) - count
        return 0.5 * (size[first + (count - 1) // 2] + size[first + count // 2])

    def by_place(self, values: Float[np.ndarray, "t"]) -> Float[np.ndarray, "p"]:
        """The mean over the frames of what `held_out` says of each tile: at each place that shows something."""
        return mean_by(np.unique(self.tile) % TILES_OF_A_FRAME, values)


def fold_of(place: Int[np.ndarray, "m"]) -> Int[np.ndarray, "m"]:
    """Places are dealt out to the folds so that no fold is without a region."""
    row, column = np.divmod(place, TILES[0])
    return (column + 2 * row) % FOLDS


def mean_by(place: Int[np.ndarray, "t"], values: Float[np.ndarray, "t"]) -> Float[np.ndarray, "p"]:
    """The mean of the values at each place that occurs."""
    places, where = np.unique(place, return_inverse=True)
    return np.bincount(where, values, len(places)) / np.bincount(where, minlength=len(places))


def scatter(ends: Float[np.ndarray, "u n"]) -> Float[np.ndarray, "n n"]:
    """The covariance that solutions without one of u units each show (Efron & Stein 1981)."""
    moves = ends - ends.mean(0)
    return moves.T @ moves * (len(ends) - 1) / len(ends)


def jackknife(ends: Float[np.ndarray, "u n"]) -> Float[np.ndarray, "n n"]:
    """`scatter`, wider for few units, so that 1.96 standard deviations mean 95 % of them too."""
    return (_student_975(len(ends) - 1) / NormalDist().inv_cdf(0.975)) ** 2 * scatter(ends)


def _student_975(degrees: int) -> float:
    """The quantile of Student's t for two-sided 95 %."""
    from scipy.special import stdtrit  # a third of a second to import, for one number of a repair

    return float(stdtrit(degrees, 0.975))


def evidence(chart: RigChart, found: Correspondences, z: Float[np.ndarray, "n"], loss: Loss = Loss.WELSCH) -> Evidence:
    """The evidence of correspondences at a solution z of the box.

    Args:
        loss: by which rows vote; with SOFT_L1 those that lie far apart have a say as well.
    """
    start = differences_at(found, chart, np.zeros_like(z))
    return evidence_of(found, linearised(found, chart, z), start, chart.prior, loss)


def evidence_of(
    found: Correspondences, rows: LinearRows, start: Float[np.ndarray, "k m"], prior: float, loss: Loss = Loss.WELSCH
) -> Evidence:
    """The same of rows that are linear already.

    Args:
        start: row differences under the initial calibration.
    """
    here, scale = np.asarray(found.weight) > 0, float(found.scale)
    weight = precisions(found, rows.differences, loss)[here] * scale**2
    return Evidence(
        z=rows.z,
        jacobian=rows.jacobian[:, here].T / scale,
        residual=rows.differences[here] / scale,
        start_residual=start[here] / scale,
        weight=weight,
        curvature=curvatures(found, rows.differences)[here] * scale**2 if loss is Loss.WELSCH else weight,
        tile=np.asarray(found.tile)[here],
        prior=prior,
        scale=scale,
        independent=float(found.independent),
    )
