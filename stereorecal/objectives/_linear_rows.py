"""Row differences, linearised in the coordinates of the box; and the linear least squares of them, for strategies."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray, register_pytree
from stereorecal.geometry import (
    Projection,
    projection,
    ray_slopes,
    rectifying_rotations,
    rectifying_slopes,
    with_unit_baseline,
)
from stereorecal.objectives._charts import RigChart
from stereorecal.objectives._parameters import SIDES
from stereorecal.scoring import Correspondences, with_rays_of
from stereorecal.strategies import Budget, Objective, Problem, Traced

_COST_OF_A_ROW = 1e-7  # units: some sixty operations, where a matcher run on a full-size frame takes some 10^9


def differences_at(found: Correspondences, chart: RigChart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "k m"]:
    """The row differences at a point of the unit box, in pixels of the scale of `found`; those of `linearised`."""
    rig = chart.rig_at(z)
    found = with_rays_of(rig, found, matched_rig=chart.rig)
    rotations = rectifying_rotations(rig.rotation, with_unit_baseline(rig.extrinsics)[3:])
    of_view = projection(found.projection)
    left, right = (
        of_view.row(*np.moveaxis(np.asarray(rays, float) @ np.asarray(rotation[1:]).T, -1, 0))
        for rays, rotation in zip((found.left, found.right), rotations, strict=True)
    )
    return float(found.focal) * (left - right)


def linearised(
    found: Correspondences, chart: RigChart, z: Float[np.ndarray, "n"]
) -> tuple[Float[np.ndarray, "k m"], Float[np.ndarray, "n k m"]]:
    """The row differences at a point of the unit box, and their derivatives by each coordinate.

    Args:
        found: with the rays that the cameras of the chart's own rig give.

    Extrinsics act through the rectifying rotations, intrinsics through the rays. A row is a function of r₁ · x and
    r₂ · x, with the rows r₁, r₂ of a rotation and a ray x, and its derivatives follow from theirs.
    """
    rig = chart.rig_at(z)
    found = with_rays_of(rig, found, matched_rig=chart.rig)
    outer, *by_pose = chart.pose_slopes(rig)
    rotations = np.stack(rectifying_rotations(rig.rotation, with_unit_baseline(rig.extrinsics)[3:]))
    slopes = rectifying_slopes(np.asarray(rig.rotation), np.asarray(rig.translation), *by_pose)
    shape = np.shape(found.weight)
    jacobian, rows, of_view = np.zeros((z.size, *shape)), np.zeros(shape), projection(found.projection)
    for side, sign in enumerate((1.0, -1.0)):
        rays, camera = np.asarray(getattr(found, SIDES[side]), float), getattr(rig, SIDES[side])
        row, by_rotation = _rectified_rows(of_view, rays, rotations[side], slopes[:, side])
        rows += sign * row
        jacobian[outer] += sign * by_rotation
        own, kinds = chart.lenses[SIDES[side]]
        if own:
            moved = ray_slopes(camera, rays, kinds)
            jacobian[own] = sign * _by_rays(of_view, rays, rotations[side], moved) * chart.half_width[own, None, None]
    focal = float(found.focal)
    return focal * rows, focal * jacobian


def _rectified_rows(
    of_view: Projection,
    rays: Float[np.ndarray, "k m 3"],
    rotation: Float[np.ndarray, "3 3"],
    slopes: Float[np.ndarray, "n 3 3"],
) -> tuple[Float[np.ndarray, "k m"], Float[np.ndarray, "n k m"]]:
    """Rectified rows, in focal lengths, and their derivatives."""
    planes = np.concatenate([rotation[1:], slopes[:, 1], slopes[:, 2]])
    (y, z), moved = np.split(planes @ rays.reshape(-1, 3).T, [2])
    (by_y, by_z), (y_by, z_by), shape = of_view.row_slopes(y, z), np.split(moved, 2), rays.shape[:2]
    return of_view.row(y, z).reshape(shape), (by_y * y_by + by_z * z_by).reshape(-1, *shape)


def _by_rays(
    of_view: Projection,
    rays: Float[np.ndarray, "k m 3"],
    rotation: Float[np.ndarray, "3 3"],
    moved: Float[np.ndarray, "p k m 2"],
) -> Float[np.ndarray, "p k m"]:
    """Derivatives of rectified rows, in focal lengths, of rays (x, y, 1) that move."""
    points = rays / rays[..., 2:]
    by_y, by_z = of_view.row_slopes(points @ rotation[1], points @ rotation[2])
    return by_y * (moved @ rotation[1, :2]) + by_z * (moved @ rotation[2, :2])


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
