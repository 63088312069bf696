"""What the last correspondences say about a solution: what it leaves of the rows, and its covariance.

Everything rests on one linearisation at the solution, cut into tiles. Within a tile errors go together (windows
overlap, a surface is smooth or a texture repeats), so the formal least-squares covariance is too small; and what a tile
shows in one frame it may show in the next (a rig at rest, its own bow), so the tiles at one place of all frames are one
unit of resampling.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from jaxtyping import Float, Int

from stereorecal.objectives import LinearRows, RigChart, differences_at, linearised
from stereorecal.scoring import TILES, Correspondences, Loss, curvatures, precisions

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
    def places(self) -> int:
        """How many places of the frames show something."""
        return len(np.unique(self.tile % TILES_OF_A_FRAME))

    def medians(self, differences: Float[np.ndarray, "m"]) -> Float[np.ndarray, "t"]:
        """The median |difference| in each tile."""
        size = np.abs(differences)
        size = size[np.lexsort((size, self.tile))]
        count = np.unique(self.tile, return_counts=True)[1]
        first = np.cumsum(count) - count
        return 0.5 * (size[first + (count - 1) // 2] + size[first + count // 2])

    def by_place(self, values: Float[np.ndarray, "t"]) -> Float[np.ndarray, "p"]:
        """The mean over the frames of what is said of each tile: at each place that shows something."""
        return mean_by(np.unique(self.tile) % TILES_OF_A_FRAME, values)


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


def evidence(chart: RigChart, found: Correspondences, z: Float[np.ndarray, "n"]) -> Evidence:
    """The evidence of correspondences at a solution z of the box."""
    start = differences_at(found, chart, np.zeros_like(z))
    return evidence_of(found, linearised(found, chart, z), start, chart.prior)


def evidence_of(found: Correspondences, rows: LinearRows, start: Float[np.ndarray, "k m"], prior: float) -> Evidence:
    """The same of rows that are linear already.

    Args:
        start: row differences under the initial calibration.
    """
    valid, scale = np.asarray(found.weight) > 0, float(found.scale)
    weight = precisions(found, rows.differences, Loss.WELSCH)[valid] * scale**2
    return Evidence(
        z=rows.z,
        jacobian=rows.jacobian[:, valid].T / scale,
        residual=rows.differences[valid] / scale,
        start_residual=start[valid] / scale,
        weight=weight,
        curvature=curvatures(found, rows.differences)[valid] * scale**2,
        tile=np.asarray(found.tile)[valid],
        prior=prior,
        scale=scale,
        independent=float(found.independent),
    )
