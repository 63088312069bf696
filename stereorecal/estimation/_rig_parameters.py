"""The parameters of a rig that are always in the model: extrinsics, the baseline's length, intrinsics of both cameras;
and derivatives by them, in closed form.

A vector θ holds their changes from a given rig, in the units of people: degrees for angles, percent of the baseline for
y, z and its length, percent for focal lengths and aspects, pixels for principal points, and coefficients as they are.

Lens terms that a calibration did not fit are in the model too: a lens whose radial term does not end at k2, or whose
decentering does not grow as p1 and p2 say, is read wrongly towards the corners, and there a yaw would pay for it.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import OF_MATRIX, Camera, StereoRig, pixel_slopes, ray_slopes
from stereorecal.objectives import EXTRINSICS, SIDES, Parameters, Reach, RigChart
from stereorecal.scoring import Correspondences, with_rays_of

DRIFTING = EXTRINSICS  # what moves after a calibration; they are the first of θ
_HALVINGS = 20


def rig_parameters(rig: StereoRig) -> RigChart:
    """The map from θ (n,) to rigs around `rig`, which is θ = 0; the extrinsics come first."""
    lenses = [f"{side}.{name}" for side in SIDES for name in (*OF_MATRIX, *getattr(rig, side).lens.CALIBRATED)]
    every = Parameters(("extrinsics", "baseline", *lenses)).of(rig, Reach())
    return RigChart(rig, tuple(replace(parameter, sigma=1.0) for parameter in every), wide=1.0)


def pixels_of(rig: StereoRig, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 4"]:
    """Pixels of points in the frame of the left camera, in the left and the right image."""
    right = points @ rig.rotation.T + rig.translation
    return np.concatenate([rig.left.project(points), rig.right.project(right)], axis=-1)


def slopes_of(
    chart: RigChart, theta: Float[np.ndarray, "n"], points: Float[np.ndarray, "*c 3"]
) -> Float[np.ndarray, "n *c 4"]:
    """Derivatives of `pixels_of` the rig at θ, by θ."""
    rig, found = chart.rig_at(theta), np.zeros((chart.dim, *points.shape[:-1], 4))
    right = points @ rig.rotation.T + rig.translation
    for side, camera_points, in_image in zip(SIDES, (points, right), (slice(2), slice(2, 4)), strict=True):
        own, moved = pixels_by_lens(chart, rig, side, camera_points)
        found[own, ..., in_image] = moved
    outer, moved = moved_by_extrinsics(chart, rig, points)
    found[outer, ..., 2:] = (_by_point(rig.right, right) @ moved[..., None])[..., 0]
    return found


def slopes_by_point(rig: StereoRig, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 4 3"]:
    """Derivatives of `pixels_of` by the points."""
    right = points @ rig.rotation.T + rig.translation
    return np.concatenate([_by_point(rig.left, points), _by_point(rig.right, right) @ rig.rotation], axis=-2)


def pixels_by_lens(
    chart: RigChart, rig: StereoRig, side: str, points: Float[np.ndarray, "*c 3"]
) -> tuple[list[int], Float[np.ndarray, "p *c 2"]]:
    """Where the p intrinsics of a camera are in θ, and the derivatives by them of pixels of points in its frame."""
    own, kinds = chart.lenses[side]
    moved = pixel_slopes(getattr(rig, side), points, kinds)[1]
    return own, chart.half_width[own].reshape(-1, *[1] * points.ndim) * moved


def rays_by_lens(
    chart: RigChart, rig: StereoRig, side: str, points: Float[np.ndarray, "*c 3"]
) -> tuple[list[int], Float[np.ndarray, "p *c 3"]]:
    """The same of the rays at depth 1 that a camera gives to pixels which stay."""
    own, kinds = chart.lenses[side]
    moved = chart.half_width[own].reshape(-1, *[1] * points.ndim) * ray_slopes(getattr(rig, side), points, kinds)
    return own, np.concatenate([moved, np.zeros_like(moved[..., :1])], axis=-1)


def moved_by_extrinsics(
    chart: RigChart, rig: StereoRig, points: Float[np.ndarray, "*c 3"], share: Float[np.ndarray, "_"] | float = 1.0
) -> tuple[list[int], Float[np.ndarray, "m *c 3"]]:
    """Where the m extrinsics are in θ, and the derivatives by them of where the right camera of a rig of the chart has
    points: at R x + share T."""
    outer, turns, shifts = chart.pose_slopes(rig)
    turned = (points.reshape(-1, 3) @ turns.swapaxes(1, 2)).reshape(len(outer), *points.shape)
    shares = np.broadcast_to(share, points.shape[:-1])[..., None]
    return outer, turned + shares * shifts.reshape(-1, *[1] * (points.ndim - 1), 3)


def _by_point(camera: Camera, points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 2 3"]:
    return by_point(pixel_slopes(camera, points, ())[0], points)


def by_point(by_ray: Float[np.ndarray, "*c 2 2"], points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 2 3"]:
    """Derivatives by points, in the frame of a camera, of what has these by their rays at depth 1."""
    depth = points[..., 2, None, None]
    return np.concatenate([by_ray, -(by_ray @ points[..., :2, None]) / depth], axis=-1) / depth


def within_field(
    found: Correspondences, chart: RigChart, theta: Float[np.ndarray, "n"], move: Float[np.ndarray, "n"]
) -> Float[np.ndarray, "n"]:
    """The move from θ, halved until the lenses there have rays for all that was found; 0 if none does. Lenses that are
    not wide have no such end."""
    if not chart.rig.is_wide:
        return move
    counts = np.asarray(found.weight) > 0
    for _ in range(_HALVINGS):
        if chart.stands_at(theta + move):
            read = with_rays_of(chart.rig_at(theta + move), found, matched_rig=chart.rig)
            if all(np.isfinite(np.asarray(rays)[counts]).all() for rays in (read.left, read.right)):
                return move
        move = 0.5 * move
    return np.zeros_like(move)
