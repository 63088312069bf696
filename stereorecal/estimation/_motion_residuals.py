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

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._rig_parameters import lens_parameters
from stereorecal.geometry import (
    StereoRig,
    euler_slopes,
    pixel_slopes,
    ray_slopes,
    rotation_from_vector,
    vector_from_rotation,
)
from stereorecal.objectives import SIDES, RigChart
from stereorecal.scoring import Tracks

PER_TRACK = 4  # numbers that are data: partner at first, column and row later, partner later
MOVES = 6  # numbers of a motion: a rotation vector, applied after it [rad], and a translation [m]
_PARTNERS = (0, 3)
_DRAWS, _OF = 200, 4  # sets of tracks, and how many each; three would do for exact ones
_SEED = 0
_TURN, _MOVE = 0.3, 10.0  # rad, baselines: standard deviations, for sets that tell nothing of one of them
_ERROR = 0.5  # pixels
_NEAREST = 0.1  # of the distance at which a point was seen first, and, of its own, ahead of the camera


@dataclass(frozen=True, eq=False)
class Motion:
    """Of the left camera: x later = rotation x + translation, in metres."""

    rotation: Float[np.ndarray, "3 3"]
    translation: Float[np.ndarray, "3"]


@dataclass(frozen=True, eq=False)
class TrackReadings:
    """Tracks, with the rays that the cameras of a rig give to their pixels.

    Attributes:
        tracks: their pixels.
        size: of the images, width and height.
        rays: (m, 3) of the left camera, at first, at depth 1.
        later: (m, 2, 2) pixels by ray of the left camera, later.
        partners: (2, m, 2, 2) the same of the right camera at both times.
        after: (3, m) shares of the motion, since the left camera saw it at first, after which the left one sees it
            later, and the right one at both times.
    """

    tracks: Tracks
    size: tuple[int, int]
    rays: Float[np.ndarray, "m 3"]
    later: Float[np.ndarray, "m 2 2"]
    partners: Float[np.ndarray, "2 m 2 2"]
    after: Float[np.ndarray, "3 m"]


@dataclass(frozen=True, eq=False)
class Expected:
    """Where a rig that moves has the points of tracks, times ρ.

    Attributes:
        later: (m, 3) for the left camera.
        at_partner_times: (2, m, 3) for the left camera at the times when the right one sees them.
        right: (2, m, 3) for the right camera at both times.
        by_later, by_right: (m, 2, 3), (2, m, 2, 3) derivatives of their pixels by where they are, with the slopes that
            the lenses have in the pixels that were seen.
        along: (2, m, 2) unit vectors of the epipolar lines in the right image, towards nearer points.
        ahead: (m,) which points lie in front of both cameras at both times: where one passes a camera, its pixels are
            anywhere, and their derivatives without end.
    """

    later: Float[np.ndarray, "m 3"]
    at_partner_times: Float[np.ndarray, "2 m 3"]
    right: Float[np.ndarray, "2 m 3"]
    by_later: Float[np.ndarray, "m 2 3"]
    by_right: Float[np.ndarray, "2 m 2 3"]
    along: Float[np.ndarray, "2 m 2"]
    ahead: Bool[np.ndarray, "m"]


@dataclass(frozen=True, eq=False)
class Residuals:
    """Seen less expected, in pixels, and derivatives of that.

    Attributes:
        value: (m, 4).
        by_nearness: (m, 4), by ρ.
        by_motion: (m, 4, 6).
        expected: where the points should be.
    """

    value: Float[np.ndarray, "m 4"]
    by_nearness: Float[np.ndarray, "m 4"]
    by_motion: Float[np.ndarray, "m 4 6"]
    expected: Expected


def track_readings(tracks: Tracks, rig: StereoRig) -> TrackReadings:
    """Tracks as the cameras of a rig read them."""
    left, right = (np.asarray(getattr(rig, side).rays(getattr(tracks, side)), float) for side in SIDES)
    later, partners = pixel_slopes(rig.left, left[1], ())[0], pixel_slopes(rig.right, right, ())[0]
    down = tracks.readout / rig.left.size[1]
    rows = np.stack([tracks.left[1], *tracks.right])[..., 1] - tracks.left[0, :, 1]
    after = np.array([[1.0], [0.0], [1.0]]) + down * rows
    return TrackReadings(tracks, rig.left.size, left[0] / left[0, :, 2:], later, partners, after)


def with_rays(tracks: Tracks, rig: StereoRig) -> Tracks:
    """The tracks that the cameras of a rig see in front of them: a wide lens has no rays 90 degrees off its axis."""
    rays = np.stack([np.asarray(getattr(rig, side).rays(getattr(tracks, side)), float) for side in SIDES])
    return tracks.of(np.isfinite(rays).all(axis=(0, 1, 3)))


def residuals(readings: TrackReadings, rig: StereoRig, motion: Motion, nearness: Float[np.ndarray, "m"]) -> Residuals:
    """Residuals of the tracks of points with these inverse depths [1 / m]."""
    expected = _expected(readings, rig, motion, nearness)
    rotation, baseline = rig.rotation, np.asarray(rig.translation)
    moves = readings.after[..., None] * motion.translation
    value = np.empty((len(nearness), PER_TRACK))
    by_nearness, by_motion = np.empty_like(value), np.empty((*value.shape, MOVES))

    def by_move(
        by_point: Float[np.ndarray, "m k 3"], point: Float[np.ndarray, "m 3"], number: int
    ) -> Float[np.ndarray, "m k 6"]:
        """Derivatives by the motion, after a share of it, of what has these by a point of the left camera."""
        by_turn = by_point @ _crossed(point - nearness[:, None] * moves[number])
        whole = np.concatenate([by_turn, nearness[:, None, None] * by_point], axis=2)
        return readings.after[number][:, None, None] * whole

    value[:, 1:3] = readings.tracks.left[1] - rig.left.project(expected.later)
    by_nearness[:, 1:3] = -_times(expected.by_later, moves[0])
    by_motion[:, 1:3] = -by_move(expected.by_later, expected.later, 0)
    for time, index in enumerate(_PARTNERS):
        along, point = expected.along[time], expected.at_partner_times[time]
        value[:, index] = _dot(along, readings.tracks.right[time] - rig.right.project(expected.right[time]))
        by_right = along[:, None] @ expected.by_right[time]
        by_nearness[:, index] = -_dot(by_right[:, 0], baseline + moves[1 + time] @ rotation.T)
        by_motion[:, index] = -by_move(by_right @ rotation, point, 1 + time)[:, 0]
    return Residuals(value, by_nearness, by_motion, expected)


def parallax(readings: TrackReadings, motion: Motion, nearness: Float[np.ndarray, "m"]) -> Float[np.ndarray, "m"]:
    """How many pixels of the left camera's later image the translation moves each point, whatever the rotation."""
    move = nearness[:, None] * readings.after[0][:, None] * motion.translation
    turned = _turned(readings.rays, motion, readings.after[0])
    return np.linalg.norm(_times(_by_point(readings.later, turned + move), move), axis=1)


def by_theta(
    readings: TrackReadings,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    motion: Motion,
    nearness: Float[np.ndarray, "m"],
) -> Float[np.ndarray, "m 4 n"]:
    """Derivatives of the residuals by θ; as seen by the cameras of the rig there. Pixels stay pixels: longer focal
    lengths do not make errors smaller."""
    rig, found = chart.rig_at(theta), np.zeros((len(nearness), PER_TRACK, chart.dim))
    expected = _expected(readings, rig, motion, nearness)
    outer = [index for index, name in enumerate(chart.names) if "." not in name]
    found[..., outer] = by_extrinsics(expected, rig, chart.extrinsic_slopes[outer], nearness)
    # Intrinsics of the left camera move the ray, and with it all that is expected.
    own, names = lens_parameters(chart, SIDES[0])
    units = chart.half_width[own, None, None]
    slopes = units * ray_slopes(rig.left, readings.rays, names)
    rays = np.concatenate([slopes, np.zeros_like(slopes[..., :1])], axis=-1)
    turned = [_turned(rays, motion, share) for share in readings.after]
    of_pixels = units * pixel_slopes(rig.left, expected.later, names)[1] + _times(expected.by_later, turned[0])
    found[:, 1:3, own] = -np.moveaxis(of_pixels, 0, -1)
    for time, index in enumerate(_PARTNERS):
        moved = _times(expected.by_right[time], turned[1 + time] @ rig.rotation.T)
        found[:, index, own] = -_dot(expected.along[time], moved).T
    own, names = lens_parameters(chart, SIDES[1])
    units = chart.half_width[own, None, None, None]
    of_pixels = units * pixel_slopes(rig.right, expected.right, names)[1]
    for time, index in enumerate(_PARTNERS):
        found[:, index, own] = -_dot(expected.along[time], of_pixels[:, time]).T
    return found


def by_extrinsics(
    expected: Expected, rig: StereoRig, slopes: Float[np.ndarray, "e 6"], nearness: Float[np.ndarray, "m"]
) -> Float[np.ndarray, "m 4 e"]:
    """Derivatives of the residuals by what moves the extrinsics of a rig, as `RigChart.extrinsic_slopes` has it: they
    move what the right camera sees."""
    found = np.zeros((len(nearness), PER_TRACK, len(slopes)))
    by_angles, by_shift = np.split(slopes, 2, axis=1)
    turns = np.tensordot(by_angles, euler_slopes(np.asarray(rig.extrinsics)[:3]), 1)
    for time, index in enumerate(_PARTNERS):
        moved = expected.at_partner_times[time] @ turns.swapaxes(1, 2) + nearness[:, None] * by_shift[:, None]
        found[:, index] = -_dot(expected.along[time], _times(expected.by_right[time], moved)).T
    return found


def _expected(readings: TrackReadings, rig: StereoRig, motion: Motion, nearness: Float[np.ndarray, "m"]) -> Expected:
    inverse_depth, baseline = nearness[:, None], np.asarray(rig.translation)
    turned = np.stack([_turned(readings.rays, motion, share) for share in readings.after])
    points = turned + inverse_depth * readings.after[..., None] * motion.translation
    later, at_partner_times = points[0], points[1:]
    right = at_partner_times @ rig.rotation.T + inverse_depth * baseline
    by_later, by_right = _by_point(readings.later, later), _by_point(readings.partners, right)
    along = by_right @ baseline
    along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-30)
    seen, first = np.concatenate([points[:1], right]), np.linalg.norm(readings.rays, axis=-1)
    away = np.linalg.norm(seen, axis=-1)
    ahead = np.all((away > _NEAREST * first) & (seen[..., 2] > _NEAREST * away), axis=0)
    return Expected(later, at_partner_times, right, by_later, by_right, along, ahead)


def _turned(
    vectors: Float[np.ndarray, "*k m 3"], motion: Motion, share: Float[np.ndarray, "m"]
) -> Float[np.ndarray, "*k m 3"]:
    """By a share of a motion's rotation (Rodrigues)."""
    if not share.any():
        return vectors
    if (share == 1.0).all():
        return vectors @ motion.rotation.T
    whole = vector_from_rotation(motion.rotation)
    size = float(np.linalg.norm(whole))
    axis, angle = whole / max(size, 1e-30), (share * size)[:, None]
    across = np.cross(axis, vectors)
    return vectors + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)


def _by_point(per_ray: Float[np.ndarray, "*c 2 2"], point: Float[np.ndarray, "*c 3"]) -> Float[np.ndarray, "*c 2 3"]:
    """Derivatives of the pixel of a point by where it is."""
    x, y, z = (point[..., axis, None] for axis in range(3))
    by_x, by_y = per_ray[..., 0], per_ray[..., 1]
    return np.stack([by_x, by_y, -(by_x * (x / z) + by_y * (y / z))], axis=-1) / z[..., None]


def _times(slopes: Float[np.ndarray, "*#c 2 3"], moved: Float[np.ndarray, "*#c 3"]) -> Float[np.ndarray, "*c 2"]:
    """How pixels move with their points."""
    return (slopes @ moved[..., None])[..., 0]


def _dot(one: Float[np.ndarray, "*#c k"], other: Float[np.ndarray, "*#c k"]) -> Float[np.ndarray, "*c"]:
    return np.sum(one * other, axis=-1)


def _crossed(points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "m 3 3"]:
    """How points move with a rotation vector w: w x p."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    return np.stack([zero, z, -y, -z, zero, x, y, -x, zero], axis=-1).reshape(-1, 3, 3)


def consensus(readings: TrackReadings, rig: StereoRig) -> Motion:
    """The motion, to first order of its rotation, from whose flow the tracks' median distance is least; their depths
    are those of the first pair."""
    number, at_rest = len(readings.tracks), Motion(np.eye(3), np.zeros(3))
    first = residuals(readings, rig, at_rest, np.zeros(number))
    linear = residuals(readings, rig, at_rest, -first.value[:, 0] / first.by_nearness[:, 0])
    unit = np.repeat([_TURN, _MOVE * float(rig.baseline)], MOVES // 2)
    offsets, flow = linear.value[:, 1:3], -linear.by_motion[:, 1:3] * unit
    draws = np.random.default_rng(_SEED).integers(number, size=(_DRAWS, _OF))
    some = flow[draws].reshape(_DRAWS, -1, MOVES)
    known = some.swapaxes(1, 2) @ some + _ERROR**2 * np.eye(MOVES)
    moves = np.linalg.solve(known, some.swapaxes(1, 2) @ offsets[draws].reshape(_DRAWS, -1, 1))[..., 0]
    squared_errors = np.sum((offsets[..., None] - flow @ moves.T) ** 2, axis=1)  # (tracks, draws)
    turn, move = np.split(unit * moves[np.argmin(np.median(squared_errors, axis=0))], 2)
    return Motion(np.asarray(rotation_from_vector(turn), float), move)
