"""Row differences, linearised in the coordinates of the box; and the linear least squares of them, for strategies."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, register_pytree
from stereorecal.geometry import (
    StereoRig,
    projection,
    ray_slopes,
    rectifying_rotations,
    rectifying_slopes,
    reread,
    with_unit_baseline,
)
from stereorecal.objectives._charts import RigChart
from stereorecal.objectives._parameters import SIDES
from stereorecal.scoring import Correspondences
from stereorecal.strategies import Budget, Objective, Problem, Traced

_TINY = 1e-30
_COST_OF_A_ROW = 1e-7  # units: some sixty operations, where a matcher run on a full-size frame takes some 10^9


def rectified_at(
    rays: tuple[Any, Any], projection_name: str, chart: RigChart, z: Float[np.ndarray, "n"]
) -> tuple[Float[np.ndarray, "*m"], Float[np.ndarray, "*m"]]:
    """Row differences and disparities in focal lengths, under the rig at a point of the unit box, of rays (*m, 3), left
    and right, that the cameras of the chart's own rig give."""
    rig, of_view, found = chart.rig_at(z), projection(projection_name), []
    for side, some, rotation in zip(SIDES, rays, _rotations(rig), strict=True):
        read = reread(np.asarray(some, float), getattr(chart.rig, side), getattr(rig, side))
        found.append(of_view.project(*np.moveaxis(read @ rotation.T, -1, 0)))
    (x, y), (u, v) = found
    return y - v, x - u


def differences_at(found: Correspondences, chart: RigChart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "k m"]:
    """The row differences at a point of the unit box, in pixels of the scale of `found`."""
    return float(found.focal) * rectified_at((found.left, found.right), found.projection, chart, z)[0]


def linearised(
    rays: tuple[Any, Any], projection_name: str, chart: RigChart, z: Float[np.ndarray, "n"]
) -> tuple[Float[np.ndarray, "*m"], Float[np.ndarray, "n *m"]]:
    """The row differences of `rectified_at`, and their derivatives by each coordinate.

    Extrinsics act through the rectifying rotations, intrinsics through the rays. A row is a function of r₁ · x and
    r₂ · x, with the rows r₁, r₂ of a rotation and a ray x, and its derivatives follow from theirs.
    """
    rig, of_view, shape = chart.rig_at(z), projection(projection_name), np.shape(rays[0])[:-1]
    outer, *by_pose = chart.pose_slopes(rig)
    slopes = rectifying_slopes(np.asarray(rig.rotation), np.asarray(rig.translation), *by_pose)
    rows, jacobian = np.zeros(shape), np.zeros((z.size, *shape))
    for index, (side, rotation, sign) in enumerate(zip(SIDES, _rotations(rig), (1.0, -1.0), strict=True)):
        camera, (own, kinds) = getattr(rig, side), chart.lenses[side]
        read = reread(np.asarray(rays[index], float), getattr(chart.rig, side), camera)
        read = read / read[..., 2:]
        down, ahead = np.moveaxis(read @ rotation[1:].T, -1, 0)
        # Complex steps (Squire & Trapp 1998): derivatives of the row by both, exact.
        by_down = np.imag(of_view.row(down + _TINY * 1j, ahead)) / _TINY
        by_ahead = np.imag(of_view.row(down, ahead + _TINY * 1j)) / _TINY
        down_by, ahead_by = (np.tensordot(slopes[:, index, axis], read, (1, -1)) for axis in (1, 2))
        rows += sign * of_view.row(down, ahead)
        jacobian[outer] += sign * (by_down * down_by + by_ahead * ahead_by)
        if own:
            moved = ray_slopes(camera, read, kinds)
            by_lens = by_down * (moved @ rotation[1, :2]) + by_ahead * (moved @ rotation[2, :2])
            jacobian[own] = sign * by_lens * chart.half_width[own].reshape(-1, *(1,) * len(shape))
    return rows, jacobian


def _rotations(rig: StereoRig) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 3"]]:
    """The rectifying rotations of a rig."""
    left, right = rectifying_rotations(rig.rotation, with_unit_baseline(rig.extrinsics)[3:])
    return np.asarray(left), np.asarray(right)


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


def linear_residuals(
    z: Float[np.ndarray, "n"],
    rows: Float[np.ndarray, "m"],
    jacobian: Float[np.ndarray, "m n"],
    precision: Float[np.ndarray, "m"],
    prior: float,
) -> LinearResiduals:
    """2 n + 1 residuals with the same sum of squares as all weighted (mean) row differences and the prior.

    Args:
        z: the point of the unit box at which rows are linear.
        rows, jacobian: the row differences there [pixels], and their derivatives.
        precision: weight of each squared row difference, 1 / pixels².
        prior: standard deviation of each parameter around the centre of the box, the initial calibration, in half
            widths of the box.
    """
    few = _reduced(np.vstack([jacobian.T, rows]), precision)
    jacobian = np.vstack([few[:, :-1], np.eye(z.size) / prior])
    return LinearResiduals(jacobian, np.concatenate([few[:, -1] - few[:, :-1] @ z, np.zeros(z.size)]))


def epipolar_objective(residuals: LinearResiduals, budget: Budget | None = None) -> Objective:
    """The objective whose value is -½ |residuals|², by default without any limit."""
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
