"""Derivatives by θ, in closed form: of the extrinsics, and of the pixels in which both cameras see points."""

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import Camera, StereoRig, euler_slopes, pixel_slopes
from stereorecal.objectives import SIDES, RigChart


def pixels_of(rig: StereoRig, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 4"]:
    """Of points in the frame of the left camera, in the left and the right image."""
    right = points @ rig.rotation.T + rig.translation
    return np.concatenate([rig.left.project(points), rig.right.project(right)], axis=-1)


def slopes_of(
    chart: RigChart, theta: Float[np.ndarray, "n"], points: Float[np.ndarray, "*c 3"]
) -> Float[np.ndarray, "n *c 4"]:
    """Derivatives of `pixels_of` the rig at θ, by θ."""
    rig, found = chart.rig_at(theta), np.zeros((chart.dim, *points.shape[:-1], 4))
    right = points @ rig.rotation.T + rig.translation
    for side, camera_points in zip(range(len(SIDES)), (points, right), strict=True):
        own, names = lens_parameters(chart, SIDES[side])
        _, by_lens = pixel_slopes(getattr(rig, SIDES[side]), camera_points, names)
        by_unit = chart.half_width[own].reshape(-1, *[1] * points.ndim)
        found[own, ..., 2 * side : 2 * side + 2] = by_unit * by_lens
    outer, moved = moved_by_extrinsics(chart, theta, points)
    found[outer, ..., 2:] = (_by_point(rig.right, right) @ moved[..., None])[..., 0]
    return found


def slopes_by_point(rig: StereoRig, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 4 3"]:
    """Derivatives of `pixels_of` by the points."""
    right = points @ rig.rotation.T + rig.translation
    return np.concatenate([_by_point(rig.left, points), _by_point(rig.right, right) @ rig.rotation], axis=-2)


def lens_parameters(chart: RigChart, side: str) -> tuple[list[int], list[str]]:
    """Where the intrinsics of a camera are in θ, and their names there."""
    own = [index for index, name in enumerate(chart.names) if name.startswith(f"{side}.")]
    return own, [chart.names[index].split(".")[1] for index in own]


def moved_by_extrinsics(
    chart: RigChart, theta: Float[np.ndarray, "n"], points: Float[np.ndarray, "*c 3"]
) -> tuple[list[int], Float[np.ndarray, "m *c 3"]]:
    """Where the m extrinsics are in θ, and the derivatives by them of points that the right camera sees: R x + T."""
    outer, extrinsics = [index for index, name in enumerate(chart.names) if "." not in name], chart.extrinsics(theta)
    by_angles, by_shift = np.split(chart.extrinsic_slopes[outer], 2, axis=1)
    turns = np.tensordot(by_angles, euler_slopes(extrinsics[:3]), 1)
    flat = points.reshape(-1, 3) @ turns.swapaxes(1, 2) + by_shift[:, None]
    return outer, flat.reshape(len(outer), *points.shape)


def _by_point(camera: Camera, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 2 3"]:
    """Of the pixels of points in the camera's frame."""
    by_ray, _ = pixel_slopes(camera, points, ())
    rays = points[..., :2] / points[..., 2:]
    return (
        by_ray
        @ np.concatenate([np.broadcast_to(np.eye(2), by_ray.shape), -rays[..., None]], axis=-1)
        / points[..., 2, None, None]
    )
