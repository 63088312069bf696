"""The objective of epipolar residuals: linear least squares with fixed correspondences and weights."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, register_pytree
from stereorecal.objectives._linear_rows import LinearRows
from stereorecal.strategies import Budget, Objective, Problem, Traced

_COST_OF_A_ROW = 1e-7  # units: some sixty operations, where a matcher run on a full-size frame takes some 10^9


@register_pytree
@dataclass(frozen=True, eq=False)
class LinearResiduals:
    """Residuals as a function of a point of the unit box, NumPy or traced: (2 n + 1,).

    First n + 1 residuals with the same normal equations as all (mean) row differences over their standard deviations,
    then the distance from the centre of the box (the initial calibration) over the standard deviation of the drift.

    Attributes:
        jacobian: (2 n + 1, n).
        at_centre: (2 n + 1,) the residuals at z = 0.
    """

    jacobian: Float[AnyArray, "m n"]
    at_centre: Float[AnyArray, "m"]

    def __call__(self, z: Float[AnyArray, "n"]) -> Float[AnyArray, "m"]:
        return (self.jacobian * z).sum(-1) + self.at_centre  # a GPU would multiply matrices with ten bits

    @property
    def least(self) -> Float[np.ndarray, "n"]:
        """The point with the least sum of squares in all of space, clipped to the box."""
        return np.clip(np.linalg.lstsq(self.jacobian, -np.asarray(self.at_centre), rcond=None)[0], -1.0, 1.0)


def linear_residuals(rows: LinearRows, precision: Float[np.ndarray, "k m"], prior: float) -> LinearResiduals:
    """2 n + 1 residuals with the same sum of squares as all weighted row differences and the prior.

    Args:
        rows: the row differences, linear around the start of the run.
        precision: weight of each squared row difference, 1 / pixels².
        prior: standard deviation of each parameter around the centre of the box, the initial calibration, in half
            widths of the box.
    """
    dim = rows.z.size
    few = _reduced(np.vstack([rows.jacobian.reshape(dim, -1), rows.differences.reshape(-1)]), precision.reshape(-1))
    jacobian = np.vstack([few[:, :-1], np.eye(dim) / prior])
    return LinearResiduals(jacobian, np.concatenate([few[:, -1] - few[:, :-1] @ rows.z, np.zeros(dim)]))


def epipolar_objective(residuals: LinearResiduals, budget: Budget | None = None) -> Objective:
    """The objective whose value is -½ |residuals|².

    Args:
        budget: default unlimited.
    """
    jacobian, at_centre = np.asarray(residuals.jacobian), np.asarray(residuals.at_centre)

    def values(points: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "k"]:
        return -0.5 * np.sum((points @ jacobian.T + at_centre) ** 2, axis=-1)

    cost = len(at_centre) * _COST_OF_A_ROW
    return Objective(Problem(jacobian.shape[1], values, cost, Traced(residuals=residuals)), budget)


def _reduced(columns: Float[np.ndarray, "c m"], precision: Float[np.ndarray, "m"]) -> Float[np.ndarray, "c c"]:
    """A square matrix with the same normal equations as all m weighted rows, and so with the same sums of squares. It
    is made from the normal matrix, which is accurate enough in float64."""
    spread, axes = np.linalg.eigh((columns * precision) @ columns.T)
    return np.sqrt(np.maximum(spread, 0.0))[:, None] * axes.T
