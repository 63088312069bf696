"""Epipolar errors and errors of depth of one rig, if another one is right.

Both follow a point of the world: the better rig says in which pixels it appears, and the one that is used reads those
pixels in its own way. Everything is NumPy in float64.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal.estimation import DISTANCES
from stereorecal.geometry import Camera, StereoRig, View, rectifying_rotations, reread, same_camera

ROW_DISTANCES = (10.0, np.inf)  # baselines
STEP = 1e-3  # of the box, for derivatives: some hundredths of a degree


def depth_errors(used: StereoRig, better: StereoRig) -> Mapping[int, float]:
    """By how many percent the depth is wrong that `used` reports, if `better` is right, at some distances.

    For a point straight ahead of the rig at 5, 10, 30 and 100 baselines: projected into both cameras through `better`,
    rectified by `used`, whose disparity gives the depth. Positive: reported too far. Infinite where that disparity is
    not positive; NaN where a lens model ends before the point.
    """
    return {distance: depth_error(_nearness(used, better, distance * float(better.baseline))) for distance in DISTANCES}


def depth_error(nearness: float) -> float:
    """The error of depth in percent, positive: too far; infinite where points seem to lie beyond infinity."""
    return float("inf") if nearness <= 0.0 else 100.0 * (1.0 / nearness - 1.0)


def _nearness(used: StereoRig, better: StereoRig, depth: float) -> float:
    """The true depth over the one that `used` reports: 1 where it is right, 0 and below where it reports infinity and
    beyond."""
    ahead = np.array([0.0, 0.0, 1.0])
    to_left, to_right = rectifying_rotations(used.rotation, used.translation)
    left = _at_depth_1(to_left @ _reread(ahead, better.left, used.left))
    from_right = better.rotation @ (depth * ahead) + better.translation
    right = _at_depth_1(to_right @ _reread(from_right, better.right, used.right))
    point = to_left.T @ left * float(used.baseline)  # over the disparity
    return float(depth * (left[0] - right[0]) / point[2])


def row_errors_of(
    used: StereoRig,
    better: StereoRig,
    view: View,
    columns: Float[np.ndarray, "w"],
    rows: Float[np.ndarray, "h"],
    distances: Sequence[float] = ROW_DISTANCES,
) -> Float[np.ndarray, "distances h w"]:
    """Row of a point in the left image rectified by `used` less its row in the right one, if `better` is right.

    Args:
        view: in which `used` rectifies.
        columns, rows: of the points in the left image of the view, in its pixels.
        distances: of the points from the left camera along its axis, in baselines.

    Returns:
        pixels of the view, at each distance; NaN where not both cameras see the point.
    """
    to_left, to_right = rectifying_rotations(used.rotation, used.translation)
    in_view = np.meshgrid(columns, rows)
    rays = np.asarray(view.directions(*in_view, 0)) @ to_left
    true = _reread(_nan_outside_image(rays, used.left), used.left, better.left)
    row_errors = []
    for distance in distances:
        from_right = true @ better.rotation.T + better.translation / (distance * float(better.baseline))
        read = _reread(_nan_outside_image(from_right, better.right), better.right, used.right) @ to_right.T
        row_errors.append(in_view[1] - view.pixels(_at_depth_1(read), 1)[1])
    return np.stack(row_errors)


def _reread(rays: Float[AnyArray, "*n 3"], true: Camera, read: Camera) -> Float[np.ndarray, "*n 3"]:
    """Where `read` takes points to lie that `true` sees along `rays`: the rays themselves if the cameras are equal."""
    if same_camera(true, read):
        return np.asarray(rays)
    return _within_lens(reread(_at_depth_1(rays), true, read), read)


def _nan_outside_image(rays: Float[AnyArray, "*n 3"], camera: Camera) -> Float[np.ndarray, "*n 3"]:
    """The rays, NaN where they miss the camera's image."""
    rays = _within_lens(_at_depth_1(rays), camera)
    pixels = camera.project(rays)
    inside = (pixels >= 0.0) & (pixels <= np.array(camera.size) - 1.0)
    return np.where(inside.all(axis=-1, keepdims=True), rays, np.nan)


def _at_depth_1(rays: Float[AnyArray, "*n 3"]) -> Float[np.ndarray, "*n 3"]:
    """(x/z, y/z, 1); NaN behind the camera."""
    rays = np.asarray(rays)
    return rays / np.where(rays[..., 2:] > 0.0, rays[..., 2:], np.nan)


def _within_lens(rays: Float[AnyArray, "*n 3"], camera: Camera) -> Float[np.ndarray, "*n 3"]:
    """Rays at depth 1, NaN beyond the radius that the lens model is good for."""
    return np.where(np.hypot(rays[..., :1], rays[..., 1:2]) < float(camera.lens_radius), rays, np.nan)
