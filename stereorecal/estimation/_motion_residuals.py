"""What a rig that moves should see, and what it saw: residuals of tracks, their derivatives, and where a search begins.

A point on the ray a of the left camera, of inverse depth ρ, is at a + ρ 0 for the left camera, R a + ρ T for the right
one, and, after a motion (Q, t) of the rig, at p = Q a + ρ t and R p + ρ T: all of them but for a scale, so that a point
may be infinitely far away. A rolling shutter shows it after a little more or less of an even motion, as it shows it in
a lower or a higher row than at first. Four numbers of a track are data: where the left image shows it later, and, along
the epipolar lines, where the right one shows it at both times. Across these lines rows tell, and they have been asked.

What moves as a whole beside the rig, such as a boat that fills a third of the view, is no outlier of least squares that
begin at rest: they end between its motion and the rig's. The motion of a few tracks that most of the others agree with,
by least median of squares (Rousseeuw 1984), is not drawn to it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.estimation._groups import places_of
from stereorecal.estimation._rig_parameters import by_point, moved_by_extrinsics, pixels_by_lens, rays_by_lens
from stereorecal.geometry import StereoRig, pixel_slopes, rotation_from_vector, vector_from_rotation
from stereorecal.objectives import SIDES, RigChart
from stereorecal.scoring import Tracks

PER_TRACK = 4  # numbers that are data: partner at first, column and row later, partner later
MOVES = 6  # numbers of a motion: a rotation vector, applied after it [rad], and a translation [m]
_LATER, _PARTNERS = [1, 2], [0, 3]  # which of those are of the left image, and of the right one
_VIEW = [1, 0, 0, 2]  # of each: 0 is the left image later, 1 and 2 are the right one at first and later
_DRAWS, _OF = 200, 4  # sets of tracks, and how many each; three would do for exact ones
_SEED = 0
_TURN, _MOVE = 0.3, 10.0  # rad, baselines: standard deviations, for sets that tell nothing of one of them
_ERROR = 0.5  # pixels
_NEAREST = 0.1  # of the distance at which a point was seen first, and, of its own, ahead of the camera


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of the left camera: x later = rotation x + translation, in metres."""

    rotation: Float[np.ndarray, "3 3"]
    translation: Float[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class TrackReadings:
    """Tracks as the cameras of a rig read them.

    Attributes:
        rays: (m, 3) of the left camera, at first, at depth 1.
        place: (m,) of the left image, at first.
        pixels: (3, m, 2) of the left image later, of the right one at first and later.
        by_ray: (3, m, 2, 2) derivatives of those by the rays at depth 1 that are seen there.
        after: (3, m) shares of the motion, since the left camera saw it at first, after which they are seen.
    """

    rays: Float[np.ndarray, "m 3"]
    place: Int[np.ndarray, "m"]
    pixels: Float[np.ndarray, "3 m 2"]
    by_ray: Float[np.ndarray, "3 m 2 2"]
    after: Float[np.ndarray, "3 m"]

    def __len__(self) -> int:
        return len(self.rays)

    def of(self, which: Any) -> "TrackReadings":
        """Some of them."""
        several = (part[:, which] for part in (self.pixels, self.by_ray, self.after))
        return TrackReadings(self.rays[which], self.place[which], *several)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Seen less expected, in pixels, and derivatives of that.

    Attributes:
        value: (m, 4).
        by_nearness: (m, 4), by ρ.
        by_motion: (m, 4, 6).
        by_point: (m, 4, 3) of what is expected, by where its camera has the point, times ρ; with the slopes that the
            lenses have in the pixels that were seen.
        points: (3, m, 3) where the left camera has the points when the pixels are seen, times ρ.
        turned: (3, m, 3) the same of points that are infinitely far away.
        along: (2, m, 2) unit vectors of the epipolar lines in the right image, towards nearer points.
        ahead: (m,) which points lie in front of both cameras at both times: where one passes a camera, its pixels are
            anywhere, and their derivatives without end.
    """

    value: Float[np.ndarray, "m 4"]
    by_nearness: Float[np.ndarray, "m 4"]
    by_motion: Float[np.ndarray, "m 4 6"]
    by_point: Float[np.ndarray, "m 4 3"]
    points: Float[np.ndarray, "3 m 3"]
    turned: Float[np.ndarray, "3 m 3"]
    along: Float[np.ndarray, "2 m 2"]
    ahead: Bool[np.ndarray, "m"]


def track_readings(tracks: Tracks, rig: StereoRig) -> TrackReadings:
    """The tracks that the cameras of a rig see in front of them: a wide lens has no rays 90 degrees off its axis."""
    rays = np.stack([np.asarray(getattr(rig, side).rays(getattr(tracks, side)), float) for side in SIDES])
    some = np.isfinite(rays).all(axis=(0, 1, 3))
    tracks, ((first, later), right) = tracks.of(some), rays[:, :, some]
    slopes = [pixel_slopes(rig.left, later, ())[0], *pixel_slopes(rig.right, right, ())[0]]
    pixels = np.stack([tracks.left[1], *tracks.right])
    down = tracks.readout / rig.left.size[1]
    after = np.array([[1.0], [0.0], [1.0]]) + down * (pixels[..., 1] - tracks.left[0, :, 1])
    place = places_of(tracks.left[0], rig.left.size)
    return TrackReadings(first / first[:, 2:], place, pixels, np.stack(slopes), after)


def residuals(readings: TrackReadings, rig: StereoRig, motion: Motion, nearness: Float[np.ndarray, "m"]) -> Residuals:
    """Residuals of the tracks of points with these inverse depths [1 / m]."""
    inverse_depth, baseline = nearness[:, None], np.asarray(rig.translation)
    turned = np.stack([_turned(readings.rays, motion, share) for share in readings.after])
    moves = readings.after[..., None] * motion.translation
    points = turned + inverse_depth * moves
    seen_at = np.concatenate([points[:1], points[1:] @ rig.rotation.T + inverse_depth * baseline])
    slopes = by_point(readings.by_ray, seen_at)
    along = slopes[1:] @ baseline
    along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-30)
    expected = np.stack([rig.left.project(seen_at[0]), *rig.right.project(seen_at[1:])])
    value, of_camera = _data(along, (readings.pixels - expected)[..., None])[..., 0], _data(along, slopes)
    by = _by_left(of_camera, rig)
    by_nearness = -_dot(by, moves[_VIEW].swapaxes(0, 1))
    by_nearness[:, _PARTNERS] -= of_camera[:, _PARTNERS] @ baseline
    by_turn = np.cross(turned[_VIEW].swapaxes(0, 1), by)
    by_motion = np.concatenate([by_turn, inverse_depth[:, None] * by], axis=2)
    by_motion *= -readings.after[_VIEW].T[..., None]
    first, away = np.linalg.norm(readings.rays, axis=-1), np.linalg.norm(seen_at, axis=-1)
    ahead = np.all((away > _NEAREST * first) & (seen_at[..., 2] > _NEAREST * away), axis=0)
    return Residuals(value, by_nearness, by_motion, of_camera, points, turned, along, ahead)


def _data(along: Float[np.ndarray, "2 m 2"], of_pixels: Float[np.ndarray, "3 m 2 k"]) -> Float[np.ndarray, "m 4 k"]:
    """What is data of something of the pixels."""
    first, later = (along[..., None, :] @ of_pixels[1:])[..., 0, :]
    return np.stack([first, of_pixels[0, :, 0], of_pixels[0, :, 1], later], axis=1)


def _by_left(of_camera: Float[np.ndarray, "m 4 3"], rig: StereoRig) -> Float[np.ndarray, "m 4 3"]:
    """Derivatives by where the left camera has the points."""
    found = of_camera.copy()
    found[:, _PARTNERS] = of_camera[:, _PARTNERS] @ rig.rotation
    return found


def by_theta(
    readings: TrackReadings,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    motion: Motion,
    nearness: Float[np.ndarray, "m"],
) -> tuple[Residuals, Float[np.ndarray, "m 4 n"]]:
    """The residuals as seen by the cameras of the rig at θ, and their derivatives by θ. Pixels stay pixels: longer
    focal lengths do not make errors smaller."""
    rig, found = chart.rig_at(theta), np.zeros((len(nearness), PER_TRACK, chart.dim))
    linear = residuals(readings, rig, motion, nearness)
    outer, moved = by_extrinsics(linear, chart, rig, nearness)
    found[..., outer] = moved
    # Intrinsics of the left camera move the ray, and with it all that is expected.
    own, rays = rays_by_lens(chart, rig, SIDES[0], readings.rays)
    turned = np.stack([_turned(rays, motion, share) for share in readings.after])
    found[..., own] = -_dot(_by_left(linear.by_point, rig), np.moveaxis(turned[_VIEW], 0, -2)).transpose(1, 2, 0)
    _, moved = pixels_by_lens(chart, rig, SIDES[0], linear.points[0])
    found[:, _LATER[0] : _LATER[-1] + 1, own] -= moved.transpose(1, 2, 0)
    right = linear.points[1:] @ rig.rotation.T + nearness[:, None] * rig.translation
    own, moved = pixels_by_lens(chart, rig, SIDES[1], right)
    found[np.ix_(range(len(nearness)), _PARTNERS, own)] = -_dot(linear.along, moved).transpose(2, 1, 0)
    return linear, found


def by_extrinsics(
    linear: Residuals, chart: RigChart, rig: StereoRig, nearness: Float[np.ndarray, "m"]
) -> tuple[list[int], Float[np.ndarray, "m 4 e"]]:
    """Where the extrinsics are in θ, and the derivatives of the residuals by them: they move what the right camera of
    the rig sees."""
    outer, moved = moved_by_extrinsics(chart, rig, linear.points[1:], nearness)
    found = np.zeros((*linear.value.shape, len(outer)))
    found[:, _PARTNERS] = -_dot(linear.by_point[:, _PARTNERS].swapaxes(0, 1), moved).transpose(2, 1, 0)
    return outer, found


def _turned(
    vectors: Float[np.ndarray, "*k m 3"], motion: Motion, share: Float[np.ndarray, "m"]
) -> Float[np.ndarray, "*k m 3"]:
    """Points turned by a share of a motion's rotation (Rodrigues)."""
    if not share.any():
        return vectors
    if (share == 1.0).all():
        return vectors @ motion.rotation.T
    whole = vector_from_rotation(motion.rotation)
    size = float(np.linalg.norm(whole))
    axis, angle = whole / max(size, 1e-30), (share * size)[:, None]
    across = np.cross(axis, vectors)
    return vectors + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)


def _dot(one: Float[np.ndarray, "*#c k"], other: Float[np.ndarray, "*#c k"]) -> Float[np.ndarray, "*c"]:
    return np.sum(one * other, axis=-1)


def consensus(readings: TrackReadings, rig: StereoRig) -> Motion:
    """The motion, to first order of its rotation, from whose flow the tracks' median distance is least; their depths
    are those of the first pair."""
    number, at_rest = len(readings), Motion(np.eye(3), np.zeros(3))
    first = residuals(readings, rig, at_rest, np.zeros(number))
    linear = residuals(readings, rig, at_rest, -first.value[:, 0] / first.by_nearness[:, 0])
    unit = np.repeat([_TURN, _MOVE * float(rig.baseline)], MOVES // 2)
    offsets, flow = linear.value[:, _LATER], -linear.by_motion[:, _LATER] * unit
    draws = np.random.default_rng(_SEED).integers(number, size=(_DRAWS, _OF))
    some = flow[draws].reshape(_DRAWS, -1, MOVES)
    known = some.swapaxes(1, 2) @ some + _ERROR**2 * np.eye(MOVES)
    moves = np.linalg.solve(known, some.swapaxes(1, 2) @ offsets[draws].reshape(_DRAWS, -1, 1))[..., 0]
    squared_errors = np.sum((offsets[..., None] - flow @ moves.T) ** 2, axis=1)  # (tracks, draws)
    turn, move = np.split(unit * moves[np.argmin(np.median(squared_errors, axis=0))], 2)
    return Motion(np.asarray(rotation_from_vector(turn), float), move)
