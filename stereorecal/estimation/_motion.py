"""The rig's own motion as data: windows of two consecutive pairs tell depth, which rows cannot.

As the rig advances, points whose disparity is off move wrongly. In each window the rig's motion and each point's depth
are eliminated, and what is left is a likelihood of θ. Points that move by themselves fit no motion of the rig and have
hardly a say. While the motion is sought, the yaw is free besides: a rig whose depth is wrong fits no motion either, and
all of its tracks would be outliers.

Errors that the tracks of a window have in common make it worse than it believes, how much so all windows say together:
where they contradict each other, or ask for a rig that no calibration leaves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation._calibration_prior import drift_sizes
from stereorecal.estimation._evidence import Normal, marginal
from stereorecal.estimation._groups import PLACES
from stereorecal.estimation._mixture import Mixture
from stereorecal.estimation._motion_residuals import (
    MOVES,
    PER_TRACK,
    Motion,
    Residuals,
    TrackReadings,
    by_extrinsics,
    by_theta,
    consensus,
    residuals,
    track_readings,
)
from stereorecal.estimation._rig_parameters import DRIFTING
from stereorecal.geometry import StereoRig, rotation_from_vector
from stereorecal.objectives import RigChart
from stereorecal.scoring import Tracks

_FEWEST = 30  # tracks: from fewer nothing is to be learnt of motion and depth
# Pixels: errors of the disparities of a track at both times alike (its surface slants), of each of them, and of where
# it is seen later. The tracks themselves say how much larger or smaller all of them are.
_ALIKE, _PARTNER, _LATER = 0.07, 0.07, 0.07
_LEAST_SCALE = 0.5
# What tracks of one place have in common, in standard deviations of their own errors: windows of pixels overlap, and
# a surface, a lens or a shadow is wrong for all of them. Which, the evidence says.
_SHARED = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.5)
_GROWS = 0.03  # of its depth that a point comes nearer: its window is then another one, and all errors are larger
_MEDIAN = 0.888  # of the root mean square of three standard normal numbers
_REDESCENDS = 1.5  # standard deviations
_ROUNDS, _SETTLED = 40, 0.03  # standard deviations of the motion
_CONVEX, _SOME = 4, 300  # rounds in which what is far still has some say, of so many tracks
_EXPECTED = 2.0  # times the errors expected: most tracks fit so well no motion but their own
_YAW = 1.0  # degrees: how far depth may be off, while the motion is sought
# Pixels: where the translation moves most points by less, what depth is known by is how they turn, and that is the
# lenses, whose errors are no smaller.
_LEAST_PARALLAX = 1.0
_LEAST_WAY = 0.1  # baselines: a way that is shorter has hardly a direction, and no share by which it could be off
_TURN, _MOVE = 1.0, 100.0  # rad and baselines: motions of which nothing is known
# Standard deviations of what windows say, in those that their tracks alone would leave: neighbours err together.
_WORSE = (1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0, 15.0)
_OF_OTHER_THINGS = 0.05  # probability that most of what moves is not the rig
_OTHER_WAYS = 0.05  # probability that the ways are of another vehicle, in other units, by another clock
_ANY_LENGTH = 4.6  # logarithm of the range in which those lie
_OWN_YAW = 1.0  # degrees: how far depth seems to be off, then


@dataclass(frozen=True, eq=False)
class Window:
    """What the tracks between two consecutive pairs say of θ.

    Attributes:
        normal: the likelihood of θ; flat where the motion tells nothing: too few tracks, at rest, or turning only.
        with_distance: the likelihood of θ, also given the distance travelled from an odometer, if that is a tenth of
            the baseline or more.
        tracks: number of points that were tracked, and whose rays both cameras have.
        inliers: number of tracks that fit one motion of the rig, and one depth each.
        motion: of the left camera, estimated with the rig at θ; None if there are too few tracks.
        metres: the distance travelled, and its standard deviation if θ were known.
        scale: ratio of the errors of tracks to the expected ones.
    """

    normal: Normal
    with_distance: Normal
    tracks: int
    inliers: int
    motion: Motion | None
    metres: tuple[float, float]
    scale: float

    @property
    def informative(self) -> bool:
        """Whether it tells anything of θ."""
        return bool(self.normal.a.any())


@dataclass(frozen=True, eq=False)
class _Solved:
    """A motion, a yaw besides, and inverse depths."""

    motion: Motion
    yaw: float
    nearness: Float[np.ndarray, "m"]
    scale: float
    weight: Float[np.ndarray, "m"]


def window(
    tracks: Tracks, chart: RigChart, theta: Float[np.ndarray, "n"], way: tuple[float, float] | None = None
) -> Window:
    """The window of tracks, in pixels of the cameras of the chart's rig, linear near θ and the depth that it says
    itself; `way` is the distance travelled from an odometer, and its standard deviation, metres."""
    nothing, readings = Normal.flat(chart.dim), track_readings(tracks, chart.rig_at(theta))
    number = len(readings)
    if number < _FEWEST:
        return Window(nothing, nothing, number, 0, None, (0.0, np.inf), 1.0)
    found = _roughly(readings, chart, theta)
    if len(found.weight) < number:
        found = _motion(readings, chart, theta, found.motion, found.yaw)
    move = found.motion.translation
    inliers, metres = int((found.weight > 0.25).sum()), float(np.linalg.norm(move))
    at = theta + found.yaw * _yaw_axis(chart)
    linear, by = by_theta(readings, chart, at, found.motion, found.nearness)
    # How many pixels of the left camera's later image the translation moves each point, whatever the rotation.
    parallax = np.linalg.norm(linear.by_motion[:, 1:3, 3:] @ move, axis=1)
    if np.median(parallax) < _LEAST_PARALLAX:
        return Window(nothing, nothing, number, inliers, found.motion, (metres, np.inf), found.scale)
    total = _products(linear, by, at, found, readings.place)
    normal, covariance = _normal(total, chart)
    with_distance = normal
    if way is not None and far_enough(way[0], chart.rig):
        with_distance = _normal(total + _of_way(found.motion, way, chart.dim), chart)[0]
    ahead = move / max(metres, 1e-30)
    sigma = float(np.sqrt(max(ahead @ covariance @ ahead, 0.0)))
    return Window(normal, with_distance, number, inliers, found.motion, (metres, sigma), found.scale)


def far_enough(metres: float, rig: StereoRig) -> bool:
    """Whether a way tells something: a tenth of the baseline or more, which a vehicle that stands does not travel."""
    return metres >= _LEAST_WAY * float(rig.baseline)


def _yaw_axis(chart: RigChart) -> Float[np.ndarray, "n"]:
    """One degree of it, in θ."""
    return np.eye(chart.dim)[DRIFTING.index("yaw")]


def _roughly(readings: TrackReadings, chart: RigChart, theta: Float[np.ndarray, "n"]) -> _Solved:
    """A motion and a yaw by some of the tracks, since most of the rounds are far from the end: from what most of them
    agree on, and, if that does not end where they are expected, from rest, too; whichever ends nearer to them."""
    some = readings.of(slice(None, None, max(1, len(readings) // _SOME)))
    found = _motion(some, chart, theta, consensus(some, chart.rig_at(theta)))
    if not found.scale < _EXPECTED:
        at_rest = _motion(some, chart, theta, Motion(np.eye(3), np.zeros(3)), convex=_CONVEX)
        found = min(found, at_rest, key=lambda one: one.scale)
    return found


def _motion(
    readings: TrackReadings,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    motion: Motion,
    yaw: float = 0.0,
    convex: int = 0,
) -> _Solved:
    """Gauss-Newton with redescending weights, from a motion and a yaw; in the first `convex` rounds what is far still
    has some say."""
    number, axis, of_yaw = len(readings), _yaw_axis(chart), DRIFTING.index("yaw")
    nearness, scale, weight = np.zeros(number), 1.0, np.ones(number)
    prior, start_rig = np.diag(np.r_[_wide(chart), _YAW**-2.0]), chart.rig_at(theta)
    for round_ in range(_ROUNDS):
        rig = start_rig.with_extrinsics(chart.extrinsics(theta + yaw * axis))
        linear = residuals(readings, rig, motion, nearness)
        if not round_:  # the first pair alone
            nearness = nearness - linear.value[:, 0] / linear.by_nearness[:, 0]
            continue
        by_yaw = by_extrinsics(linear, chart, rig, nearness)[1][..., [of_yaw]]
        columns = np.concatenate([linear.value[..., None], linear.by_motion, by_yaw], axis=2)
        depth_eliminated, pulls, _ = _without_depth(linear, motion, nearness, columns)
        ahead = linear.ahead
        if not ahead.any():
            break
        depth_eliminated[~ahead] = 0.0
        track_rms = np.sqrt(np.mean(depth_eliminated[..., 0] ** 2, axis=1))
        scale = max(float(np.median(track_rms[ahead])) / _MEDIAN, _LEAST_SCALE)
        scaled_rms = track_rms / (_REDESCENDS * scale)
        weight = ahead / (1.0 + scaled_rms**2) ** (1 if round_ < convex else 2)
        j, r = depth_eliminated[..., 1:], depth_eliminated[..., 0]
        weighted = weight[:, None, None] * j
        a = np.tensordot(weighted, j, ([0, 1], [0, 1])) / scale**2 + prior
        b = -np.tensordot(weighted, r, ([0, 1], [0, 1])) / scale**2 - prior @ np.r_[np.zeros(MOVES), yaw]
        step = np.linalg.solve(a, b)
        nearness = nearness - (pulls[:, 0] + pulls[:, 1:] @ step)
        turn = np.asarray(rotation_from_vector(step[:3]), float)
        motion = Motion(turn @ motion.rotation, motion.translation + step[3:MOVES])
        yaw = yaw + float(step[MOVES])
        if round_ > convex + 1 and step @ a @ step < _SETTLED**2:
            break
    return _Solved(motion, yaw, nearness, scale, weight)


def _wide(chart: RigChart) -> Float[np.ndarray, "6"]:
    """Precisions of a motion of which nothing is known."""
    return np.repeat([_TURN**-2.0, (_MOVE * float(chart.rig.baseline)) ** -2.0], 3)


def _without_depth(
    linear: Residuals, motion: Motion, nearness: Float[np.ndarray, "m"], columns: Float[np.ndarray, "m 4 c"]
) -> tuple[Float[np.ndarray, "m 4 c"], Float[np.ndarray, "m c"], Float[np.ndarray, "m 4"]]:
    """Columns, whitened, less what a point's depth takes of them; how much of the depth that is; and the directions
    that depth takes, of length 1."""
    error = np.zeros((len(nearness), PER_TRACK, PER_TRACK + 1))
    error[:, 0, 0] = error[:, 3, 0] = _ALIKE
    error[:, 0, 1] = error[:, 3, 4] = _PARTNER
    error[:, 1, 2] = error[:, 2, 3] = _LATER
    error[:, 3, 2:4] = _LATER * linear.along[1]  # a partner later was looked for where the track was seen later
    approach = np.abs(nearness) * float(np.linalg.norm(motion.translation))  # or across, as a share of their depth
    larger = np.hypot(1.0, approach / _GROWS)[:, None, None]
    white = np.linalg.inv(np.linalg.cholesky(error @ error.swapaxes(1, 2))) / larger
    by, columns = (white @ linear.by_nearness[..., None])[..., 0], white @ columns
    size = np.maximum(np.linalg.norm(by, axis=1, keepdims=True), 1e-150)
    by = by / size
    along = np.einsum("mk,mkc->mc", by, columns)
    return columns - by[..., None] * along[:, None], along / size, by


def _products(
    linear: Residuals,
    by: Float[np.ndarray, "m 4 n"],
    theta: Float[np.ndarray, "n"],
    found: _Solved,
    place: Int[np.ndarray, "m"],
) -> Float[np.ndarray, "c c"]:
    """Products of the residuals at θ = 0 and their derivatives by θ and by the motion, linear there."""
    columns = np.concatenate([linear.value[..., None], by, linear.by_motion], axis=2)
    depth_eliminated, _, directions = _without_depth(linear, found.motion, found.nearness, columns)
    depth_eliminated[..., 0] -= depth_eliminated[..., 1 : 1 + len(theta)] @ theta
    depth_eliminated[~linear.ahead] = 0.0
    weight = found.weight * linear.ahead
    return _products_with_shared_errors(depth_eliminated / found.scale, directions, weight, place)


def _normal(total: Float[np.ndarray, "c c"], chart: RigChart) -> tuple[Normal, Float[np.ndarray, "3 3"]]:
    """The likelihood of θ, the motion integrated; and the covariance of the translation were θ known."""
    pull, a, of_motion = total[0, 1:], total[1:, 1:], total[-MOVES:, -MOVES:]
    wide = _wide(chart) ** -0.5
    covariance = np.linalg.inv(of_motion + np.diag(_wide(chart)))[3:, 3:]
    # Of the m numbers of all tracks, those count that θ or the motion change.
    alone = marginal(Normal(a, -pull, _explained_fraction(total)), np.diag(wide))
    log_volume = np.linalg.slogdet(np.eye(MOVES) + wide[:, None] * of_motion * wide)[1]  # of a motion that could be any
    return Normal(alone.a, alone.b, alone.c - float(log_volume)), covariance


def _of_way(motion: Motion, way: tuple[float, float], n: int) -> Float[np.ndarray, "c c"]:
    """Products of the columns of one more row: the length of the translation less the way, in its deviations."""
    metres, sigma = way
    length = float(np.linalg.norm(motion.translation))
    row = np.concatenate([[length - metres], np.zeros(n + 3), motion.translation / max(length, 1e-30)]) / sigma
    return np.outer(row, row)


def _products_with_shared_errors(
    rows: Float[np.ndarray, "m 4 c"],
    depth_directions: Float[np.ndarray, "m 4"],
    weight: Float[np.ndarray, "m"],
    place: Int[np.ndarray, "m"],
) -> Float[np.ndarray, "c c"]:
    """Products of the columns of whitened rows, of which the first are residuals, where tracks of one place have an
    error in common besides their own: as large as the evidence says, and integrated. `depth_directions` are those of
    its residuals that the depth of each track takes, of length 1."""
    own = np.sqrt(weight)[:, None, None] * rows
    plain = np.tensordot(own, own, ([0, 1], [0, 1]))
    places, weight = PLACES[0] * PLACES[1], weight[:, None, None]
    pulls, known = np.zeros((places, *rows.shape[1:])), np.zeros((places, PER_TRACK, PER_TRACK))
    np.add.at(pulls, place, weight * rows)
    np.add.at(known, place, weight * (np.eye(PER_TRACK) - depth_directions[:, :, None] * depth_directions[:, None]))
    found = []
    for shared in _SHARED:
        inner = np.eye(PER_TRACK) + shared**2 * known
        total = plain - shared**2 * np.tensordot(pulls, np.linalg.solve(inner, pulls), ([0, 1], [0, 1]))
        found.append((float(total[0, 0] - _explained_fraction(total) + np.linalg.slogdet(inner)[1].sum()), total))
    return min(found, key=lambda one: one[0])[1]


def _explained_fraction(total: Float[np.ndarray, "c c"]) -> float:
    """The part of the squared residuals, the first of these columns, that the others explain."""
    scale = np.sqrt(np.maximum(np.diag(total)[1:], 1e-300))
    pull = total[0, 1:] / scale
    return float(pull @ np.linalg.lstsq(total[1:, 1:] / scale / scale[:, None], pull, rcond=1e-12)[0])


@dataclass(frozen=True, eq=False)
class Windows:
    """Tracks of some windows of one rig.

    Attributes:
        tracks: of each.
        frames: numbers of the two pairs of each, as correspondences have them; empty where they are not known.
        seconds: from one pair to the other; those of all windows are 1 where times are not known.
        ways: the distance travelled in each from an odometer, and its standard deviation, metres; None where that is
            not known, empty where no odometer was given.
    """

    tracks: tuple[Tracks, ...] = ()
    frames: tuple[tuple[int, int], ...] = ()
    seconds: tuple[float, ...] = ()
    ways: tuple[tuple[float, float] | None, ...] = ()

    def linear_at(self, chart: RigChart, theta: Float[np.ndarray, "*w n"]) -> tuple[Window, ...]:
        """The window of each pair of pairs, linear near θ, or near one of its own."""
        each = zip(self.tracks, np.broadcast_to(theta, (len(self.tracks), chart.dim)), self.all_ways, strict=True)
        return tuple(window(one, chart, near, way) for one, near, way in each)

    @property
    def all_ways(self) -> tuple[tuple[float, float] | None, ...]:
        """One for each window."""
        return self.ways or (None,) * len(self.tracks)

    @property
    def measured(self) -> bool:
        """Whether an odometer measured the distance travelled in any of them."""
        return any(way is not None for way in self.ways)

    def __bool__(self) -> bool:
        return any(len(one) for one in self.tracks)

    def likelihoods(self, chart: RigChart, theta: Float[np.ndarray, "n"], prior: Mixture) -> list[tuple[float, Normal]]:
        """What the windows may tell of θ, near a θ, as `MatchedRanges.likelihoods`: all of it, or all but depth."""
        if not self:
            return [(0.0, Normal.flat(chart.dim))]
        within = root_and_mean(prior)
        windows = self.linear_at(chart, theta)
        # Ways err by themselves, however wrong the tracks are.
        by_ways = reduce(add, (one.with_distance - one.normal for one in windows))
        return self.explained(together([one.normal for one in windows], *within), by_ways, chart)

    def explained(self, alone: Normal, by_ways: Normal, chart: RigChart) -> list[tuple[float, Normal]]:
        """What they may tell together, each with the logarithm of its probability: alone, with what ways add, if those
        are of this rig (less than a tenth of its baseline does not count); without; and nothing of depth."""
        of_rig, of_others = float(np.log1p(-_OF_OTHER_THINGS)), float(np.log(_OF_OTHER_THINGS))
        explanations = [(of_rig, alone), (of_others, without_depth(alone))]
        ways = [way for way in self.ways if way is not None and far_enough(way[0], chart.rig)]
        if not ways:
            return explanations
        # Ways of anything else have any length: against that, their density counts, once, as all err alike.
        sigma = float(np.median([way[1] / way[0] for way in ways])) / np.sqrt(len(ways))
        narrower = float(np.log(_ANY_LENGTH / (sigma * np.sqrt(2.0 * np.pi))))
        own = float(np.log1p(-_OF_OTHER_THINGS) + np.log1p(-_OTHER_WAYS)) + narrower
        return [(own, alone + by_ways), *((float(log + np.log(_OTHER_WAYS)), normal) for log, normal in explanations)]


NO_WINDOWS = Windows()


def root_and_mean(prior: Mixture) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
    """All calibrations and drifts as one normal distribution of θ: a root of its covariance, and its mean."""
    drifts, weights = drift_sizes()
    covariance = np.einsum("m,mij->ij", prior.weights, prior.covariances)
    covariance[: len(DRIFTING), : len(DRIFTING)] += np.diag(weights @ drifts**2)
    return np.linalg.cholesky(covariance + 1e-18 * np.eye(len(covariance))), prior.mean


def together(several: Sequence[Normal], root: Float[np.ndarray, "n n"], mean: Float[np.ndarray, "n"]) -> Normal:
    """The likelihood of all windows, their errors as much larger as the evidence says; `root` and `mean` are those of
    what they tell of, before."""
    total, n = reduce(add, several), len(mean)
    counted = [one for one in several if one.a.any()]
    found = []
    for worse in _WORSE:
        scaled = Normal(
            total.a / worse**2, total.b / worse**2, total.c / worse**2 + 2.0 * n * len(counted) * np.log(worse)
        )
        found.append((marginal(scaled.around(mean), root).c, scaled))
    return min(found, key=lambda one: one[0])[1]


def without_depth(normal: Normal) -> Normal:
    """The likelihood if the depth in all windows is not that of the rig: with a yaw of its own."""
    axes = np.eye(len(normal.b))
    both = normal.of_parameters(np.column_stack([axes, axes[DRIFTING.index("yaw")]]))
    return marginal(both, np.array([[_OWN_YAW]]))
