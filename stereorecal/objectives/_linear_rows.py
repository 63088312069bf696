"""Row differences, linearised: their values and their Jacobian with respect to the coordinates of the box."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import (
    Projection,
    euler_slopes,
    projection,
    ray_slopes,
    rectifying_rotations,
    rectifying_slopes,
    with_unit_baseline,
)
from stereorecal.objectives._parameter_names import SIDES
from stereorecal.objectives._rig_chart import RigChart
from stereorecal.scoring import Correspondences, with_rays_of


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Row differences near a point of the unit box; float64: of correspondences, in pixels of their scale, or their
    means in groups, in pixels of the images.

    Attributes:
        z: (n,) the point.
        differences: (k, m) there.
        jacobian: (n, k, m) their derivatives by each coordinate, there or near by.
    """

    z: Float[np.ndarray, "n"]
    differences: Float[np.ndarray, "k m"]
    jacobian: Float[np.ndarray, "n k m"]


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


def linearised(found: Correspondences, chart: RigChart, z: Float[np.ndarray, "n"]) -> LinearRows:
    """The row differences and their derivatives at z.

    Args:
        found: with the rays that the cameras of the chart's own rig give.

    Extrinsics act through the rectifying rotations, intrinsics through the rays. A row is a function of r₁ · x and
    r₂ · x, with the rows r₁, r₂ of a rotation and a ray x, and its derivatives follow from theirs.
    """
    rig = chart.rig_at(z)
    found = with_rays_of(rig, found, matched_rig=chart.rig)
    outer = [index for index, name in enumerate(chart.names) if "." not in name]
    rotations = np.stack(rectifying_rotations(rig.rotation, with_unit_baseline(rig.extrinsics)[3:]))
    by_angles, by_shift = np.split(chart.extrinsic_slopes[outer], 2, axis=1)
    by_rotation = np.tensordot(by_angles, euler_slopes(np.asarray(rig.extrinsics[:3])), 1)
    slopes = rectifying_slopes(np.asarray(rig.rotation), np.asarray(rig.translation), by_rotation, by_shift)
    shape = np.shape(found.weight)
    jacobian, rows, of_view = np.zeros((z.size, *shape)), np.zeros(shape), projection(found.projection)
    for side, sign in enumerate((1.0, -1.0)):
        rays, camera = np.asarray(getattr(found, SIDES[side]), float), getattr(rig, SIDES[side])
        row, by_rotation = _rectified_rows(of_view, rays, rotations[side], slopes[:, side])
        rows += sign * row
        jacobian[outer] += sign * by_rotation
        own = [index for index, name in enumerate(chart.names) if name.startswith(SIDES[side])]
        if own:
            moved = ray_slopes(camera, rays, [chart.names[index].split(".")[1] for index in own])
            jacobian[own] = sign * _by_rays(of_view, rays, rotations[side], moved) * chart.half_width[own, None, None]
    focal = float(found.focal)
    return LinearRows(z, focal * rows, focal * jacobian)


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
