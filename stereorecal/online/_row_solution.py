"""What the rows of a pair say about the rig that solves them: what it leaves of them, and its covariance.

Everything rests on one linearisation at the solution, cut into tiles. Within a tile errors go together (windows
overlap, a surface is smooth or a texture repeats), so the formal least-squares covariance is too small: tiles are the
units of resampling.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from jaxtyping import Float

from stereorecal.objectives import LinearRows
from stereorecal.recalibration import RowResiduals
from stereorecal.scoring import Correspondences, Loss, curvatures, precisions

# Standard deviation of an offset that all rows share, pixels of the images that were measured: no resampling sees it.
SHARED = 0.005


@dataclass(frozen=True, eq=False, kw_only=True)
class RowSolution(RowResiduals):
    """The least-squares problem at the solution, linear in z, the point of the unit box.

    Attributes:
        z: (n,) the solution.
        jacobian: (m, n) of the row differences, pixels at full size.
        weight: (m,) of the squared row differences.
        curvature: (m,) second derivatives of their losses.
        prior: standard deviation of the drift on each axis, in half widths of the box.
        scale: pixels at which the rows were measured, per pixel at full size.
    """

    z: Float[np.ndarray, "n"]
    jacobian: Float[np.ndarray, "m n"]
    weight: Float[np.ndarray, "m"]
    curvature: Float[np.ndarray, "m"]
    prior: float
    scale: float = 1.0

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
        left_out = [np.flatnonzero(self.place == one) for one in np.unique(self.place)]
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


def jackknife(ends: Float[np.ndarray, "u n"]) -> Float[np.ndarray, "n n"]:
    """The covariance that solutions without one of u units each show (Efron & Stein 1981), wider for few units, so that
    1.96 standard deviations mean 95 % of them too."""
    moves = ends - ends.mean(0)
    scatter = moves.T @ moves * (len(ends) - 1) / len(ends)
    return (_student_975(len(ends) - 1) / NormalDist().inv_cdf(0.975)) ** 2 * scatter


def _student_975(degrees: int) -> float:
    """The quantile of Student's t for two-sided 95 %."""
    from scipy.special import stdtrit  # a third of a second to import, for one number

    return float(stdtrit(degrees, 0.975))


def row_solution(
    found: Correspondences, rows: LinearRows, start: Float[np.ndarray, "k m"], prior: float
) -> RowSolution:
    """The solution of the rows of correspondences.

    Args:
        start: row differences under the initial calibration.
    """
    valid, scale = np.asarray(found.weight) > 0, float(found.scale)
    return RowSolution(
        residual=rows.differences[valid] / scale,
        start_residual=start[valid] / scale,
        tile=np.asarray(found.tile)[valid],
        independent=float(found.independent),
        z=rows.z,
        jacobian=rows.jacobian[:, valid].T / scale,
        weight=precisions(found, rows.differences, Loss.WELSCH)[valid] * scale**2,
        curvature=curvatures(found, rows.differences)[valid] * scale**2,
        prior=prior,
        scale=scale,
    )
