"""Row differences and their derivatives by the coordinates of the box: what a solver and the evidence rest on."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import rectifying_rotations, rotation_from_euler, with_unit_baseline
from stereorecal.objectives._chart import Chart
from stereorecal.scoring import Correspondences, row_differences

_STEP = 1e-4  # of the box, for derivatives of rotations in float64


@dataclass(frozen=True, eq=False)
class LinearRows:
    """The row differences of correspondences near a point of the unit box; float64, in pixels of their scale.

    Attributes:
        z: (n,) the point.
        differences: (k, m) there.
        jacobian: (n, k, m) their derivatives by each coordinate, there or near by.
    """

    z: Float[np.ndarray, "n"]
    differences: Float[np.ndarray, "k m"]
    jacobian: Float[np.ndarray, "n k m"]

    def moved(self, found: Correspondences, chart: Chart, z: Float[np.ndarray, "n"]) -> "LinearRows":
        """The same derivatives with the differences at another point, near enough for them."""
        return replace(self, z=z, differences=differences_at(found, chart, z))


def differences_at(found: Correspondences, chart: Chart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "k m"]:
    """The row differences at a point of the unit box, in pixels of the scale of `found`."""
    return np.asarray(row_differences(found, with_unit_baseline(chart.extrinsics(z))))


def linearised(found: Correspondences, chart: Chart, z: Float[np.ndarray, "n"]) -> LinearRows:
    """The row differences and their derivatives at z.

    Only the rectifying rotations depend on z, whose derivatives are central differences of 3x3 matrices. A row is
    f (r₁ · x) / (r₂ · x), with the rows r₁, r₂ of a rotation and a ray x, and its derivatives follow from theirs.
    """
    here, steps = _rotations(chart, z), _STEP * np.eye(z.size)
    slopes = np.stack([(_rotations(chart, z + h) - _rotations(chart, z - h)) / (2 * _STEP) for h in steps])
    sides = [
        _rows(np.asarray(rays, float), here[side], slopes[:, side])
        for side, rays in enumerate((found.left, found.right))
    ]
    rows, jacobian = (float(found.focal) * (left - right) for left, right in zip(*sides, strict=True))
    return LinearRows(z, rows, jacobian)


def _rotations(chart: Chart, z: Float[np.ndarray, "n"]) -> Float[np.ndarray, "2 3 3"]:
    """The rectifying rotations, left and right, at a point of the box."""
    extrinsics = with_unit_baseline(chart.extrinsics(z))
    return np.stack(rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:]))


def _rows(
    rays: Float[np.ndarray, "k m 3"], rotation: Float[np.ndarray, "3 3"], slopes: Float[np.ndarray, "n 3 3"]
) -> tuple[Float[np.ndarray, "k m"], Float[np.ndarray, "n k m"]]:
    """Rectified rows, in focal lengths, and their derivatives."""
    planes = np.concatenate([rotation[1:], slopes[:, 1], slopes[:, 2]])
    (across, along), moved = np.split(planes @ rays.reshape(-1, 3).T, [2])
    rows, (across_by, along_by) = across / along, np.split(moved, 2)
    shape = rays.shape[:2]
    return rows.reshape(shape), ((across_by - rows * along_by) / along).reshape(-1, *shape)
