"""What a rig that moves should see, and what it saw: residuals of tracks, and their derivatives.

A point on the ray a of the left camera, of inverse depth ρ, is at a + ρ 0 for the left camera, R a + ρ T for the right
one, and, after a motion (Q, t) of the rig, at p = Q a + ρ t and R p + ρ T: all of them but for a scale, so that a point
may be infinitely far away. Four numbers of a track are data: where the left image shows it later, and, along the
epipolar lines, where the right one shows it at both times. Across these lines rows tell, and they have been asked.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._slopes import lens_parameters
from stereorecal.geometry import Camera, StereoRig, euler_slopes, pixel_slopes, ray_slopes
from stereorecal.objectives import SIDES, RigChart
from stereorecal.scoring import Tracks

SEEN = 4  # numbers of a track: partner at first, column and row later, partner later
MOVES = 6


@dataclass(frozen=True, eq=False)
class Motion:
    """Of the left camera: x later = rotation x + translation.

    Attributes:
        rotation: (3, 3).
        translation: (3,) metres.
    """

    rotation: Float[np.ndarray, "3 3"]
    translation: Float[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class Rays:
    """Tracks as the cameras of one rig read them.

    Attributes:
        left, right: (2, m, 3) rays at depth 1.
        per_ray: (2, 2, m, 2, 2) pixels by ray: of each side at each time.
    """

    left: Float[np.ndarray, "2 m 3"]
    right: Float[np.ndarray, "2 m 3"]
    per_ray: Float[np.ndarray, "2 2 m 2 2"]


@dataclass(frozen=True, eq=False)
class Residuals:
    """Seen less expected, in pixels, and derivatives of that; along the epipolar lines as they are at this rig.

    Attributes:
        value: (m, 4).
        by_nearness: (m, 4), by ρ.
        by_motion: (m, 4, 6), by a rotation vector, applied after the motion [rad], and the translation [m].
        along: (m, 2) unit vectors of the epipolar lines of the second pair, in pixels of the right image.
    """

    value: Float[np.ndarray, "m 4"]
    by_nearness: Float[np.ndarray, "m 4"]
    by_motion: Float[np.ndarray, "m 4 6"]
    along: Float[np.ndarray, "m 2"]


def rays_of(tracks: Tracks, rig: StereoRig) -> Rays:
    """By the cameras of a rig."""
    rays = [_at_1(np.asarray(getattr(rig, side).rays(getattr(tracks, side)), float)) for side in SIDES]
    cameras: list[Camera] = [getattr(rig, side) for side in SIDES]
    return Rays(*rays, np.stack([pixel_slopes(c, seen, ())[0] for c, seen in zip(cameras, rays, strict=True)]))


def residuals(rays: Rays, rig: StereoRig, motion: Motion, nearness: Float[np.ndarray, "m"]) -> Residuals:
    """Of points with these inverse depths [1 / m]."""
    (at_first, later, at_right, later_right), shapes = _points(rays, rig, motion, nearness)
    del at_first
    value = np.empty((len(nearness), SEEN))
    by_nearness, by_motion = np.empty_like(value), np.zeros((len(nearness), SEEN, MOVES))
    baseline, moved = np.asarray(rig.translation), np.asarray(motion.translation)
    turned = later - nearness[:, None] * moved
    by_move = np.concatenate([_crossed(turned), nearness[:, None, None] * np.eye(3)], axis=2)  # (m, 3, 6) of `later`
    first, at_later, later_by = shapes
    value[:, 0] = _along(first, rays.right[0] - _at_1(at_right))
    by_nearness[:, 0] = -_along_point(first, at_right, np.broadcast_to(baseline, later.shape))
    value[:, 1:3] = (at_later @ (rays.left[1] - _at_1(later))[:, :2, None])[..., 0]
    by_nearness[:, 1:3] = -(at_later @ _projected(later, np.broadcast_to(moved, later.shape))[..., None])[..., 0]
    by_motion[:, 1:3] = -at_later @ _projected(later[:, None], by_move.swapaxes(1, 2)).swapaxes(1, 2)
    value[:, 3] = _along(later_by, rays.right[1] - _at_1(later_right))
    by_nearness[:, 3] = -_along_point(later_by, later_right, rig.rotation @ moved + baseline)
    by_right = np.asarray(rig.rotation) @ by_move
    by_motion[:, 3] = -np.einsum("mk,mvk->mv", later_by, _projected(later_right[:, None], by_right.swapaxes(1, 2)))
    along = np.linalg.solve(rays.per_ray[1, 1].swapaxes(1, 2), later_by[..., None])[..., 0]
    return Residuals(value, by_nearness, by_motion, along)


def by_theta(
    rays: Rays, chart: RigChart, theta: Float[np.ndarray, "n"], motion: Motion, nearness: Float[np.ndarray, "m"]
) -> Float[np.ndarray, "m 4 n"]:
    """Derivatives of the residuals by θ; `rays` are those of the rig there."""
    rig = chart.rig_at(theta)
    (at_first, later, at_right, later_right), (first, at_later, later_by) = _points(rays, rig, motion, nearness)
    found = np.zeros((len(nearness), SEEN, chart.dim))
    outer = [index for index, name in enumerate(chart.names) if "." not in name]
    found[..., outer] = by_extrinsics(rays, chart, theta, motion, nearness, outer)
    # Intrinsics move the rays: those that were seen, and, of the left camera, all that is expected.
    own, names = lens_parameters(chart, SIDES[1])
    slopes = ray_slopes(rig.right, rays.right, names) * chart.half_width[own, None, None, None]
    found[:, 0, own] = np.einsum("mk,pmk->mp", first, slopes[:, 0])
    found[:, 3, own] = np.einsum("mk,pmk->mp", later_by, slopes[:, 1])
    own, names = lens_parameters(chart, SIDES[0])
    slopes = ray_slopes(rig.left, rays.left, names) * chart.half_width[own, None, None, None]
    ray = np.concatenate([slopes[:, 0], np.zeros_like(slopes[:, 0, :, :1])], axis=-1)
    found[:, 0, own] = -np.einsum("mk,pmk->mp", first, _projected(at_right, ray @ rig.rotation.T))
    expected = ray @ motion.rotation.T
    found[:, 1:3, own] = np.einsum("mij,pmj->mip", at_later, slopes[:, 1] - _projected(later, expected))
    found[:, 3, own] = -np.einsum("mk,pmk->mp", later_by, _projected(later_right, expected @ rig.rotation.T))
    return found


def by_extrinsics(
    rays: Rays,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    motion: Motion,
    nearness: Float[np.ndarray, "m"],
    which: Sequence[int],
) -> Float[np.ndarray, "m 4 e"]:
    """Derivatives of the residuals by some extrinsics, by their indices in θ: they move what the right camera sees."""
    (at_first, later, at_right, later_right), (first, _, later_by) = _points(
        rays, chart.rig_at(theta), motion, nearness
    )
    found = np.zeros((len(nearness), SEEN, len(which)))
    by_angles, by_shift = np.split(chart.extrinsic_slopes[which], 2, axis=1)
    turns = np.tensordot(by_angles, euler_slopes(chart.extrinsics(theta)[:3]), 1)
    for row, (direction, point, seen) in {0: (first, at_first, at_right), 3: (later_by, later, later_right)}.items():
        moved = point @ turns.swapaxes(1, 2) + nearness[:, None] * by_shift[:, None]  # (e, m, 3)
        found[:, row] = -np.einsum("mk,emk->me", direction, _projected(seen, moved))
    return found


def _points(rays: Rays, rig: StereoRig, motion: Motion, nearness: Float[np.ndarray, "m"]):
    """What each camera sees, times ρ; and what makes residuals of rays: along the lines, and pixels, where seen."""
    near, baseline = nearness[:, None], np.asarray(rig.translation)
    at_first = rays.left[0]
    later = at_first @ motion.rotation.T + near * motion.translation
    at_right, later_right = (point @ rig.rotation.T + near * baseline for point in (at_first, later))
    lines = [
        _line(rays.per_ray[1, time], point, np.broadcast_to(baseline, point.shape))
        for time, point in enumerate((at_right, later_right))
    ]
    return (at_first, later, at_right, later_right), (lines[0], rays.per_ray[0, 1], lines[1])


def _line(per_ray: Float[np.ndarray, "m 2 2"], point: Float[np.ndarray, "m 3"], by: Float[np.ndarray, "m 3"]):
    """What takes a difference of rays to pixels along the epipolar line, (m, 2): towards greater nearness."""
    along = (per_ray @ _projected(point, by)[..., None])[..., 0]
    unit = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-30)
    return (unit[:, None] @ per_ray)[:, 0]


def _along(direction: Float[np.ndarray, "m 2"], rays: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "m"]:
    return np.einsum("mk,mk->m", direction, rays[:, :2])


def _along_point(direction, point, moved) -> Float[np.ndarray, "m"]:
    return np.einsum("mk,mk->m", direction, _projected(point, moved))


def _projected(point: Float[np.ndarray, "*c 3"], moved: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 2"]:
    """How (x/z, y/z) of a point moves with it."""
    at_1 = point / point[..., 2:]
    return (moved[..., :2] - at_1[..., :2] * moved[..., 2:]) / point[..., 2:]


def _at_1(points: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 3"]:
    return points / points[..., 2:]


def _crossed(points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "m 3 3"]:
    """How points move with a rotation vector: w x p."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    return np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=-1).reshape(-1, 3, 3)
