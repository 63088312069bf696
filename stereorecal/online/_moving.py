"""Depth from the rig's own motion while it drives: corners are followed until the rig has moved, and then tell the yaw
that rows alone do not. And how the rig turns between two consecutive left images, which a late shutter would take for
an offset."""

from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from stereorecal.estimation import Normal, window
from stereorecal.geometry import Camera, vector_from_rotation
from stereorecal.online._calibration_kinds import squared_error
from stereorecal.online._filter import Measurement
from stereorecal.online._state import State
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences
from stereorecal.scoring.host import Matches, corner_tracks, corners, match_radius

_MOST = 400  # corners
_FEWEST = 30  # of them that are seen again
AHEAD = 0.5  # baselines: in less, depth is hardly told
_LEFT = 0.4  # of the corners that were found: if fewer are seen again, sooner
# Pairs, where their times are not known, and seconds, after which nothing is the same.
_LONGEST, _SECONDS = 16, 2.0
# Windows of one place show the same things, and err together: standard deviations in those that each believes.
_WORSE = 3.0
# Probabilities that most of what moves is not the rig: of a window after one of its own motion, and after another one,
# since a boat stays in view for a while. What such windows say is then off by any yaw.
_COME, _STAY, _OWN_YAW = 0.05, 0.9, 1.0
_FITS = 1e-3  # chance: two windows that fit less are not of the same yaw
# Of the turn between two images:
_WIDTH = 320  # pixels, at which corners are followed
_OF_TURN, _FEWEST_OF_TURN = 200, 20  # corners
_BESIDE = 10  # pixels, the half width of the windows in which they are followed
_ROUNDS, _LOST = 5, 5.0  # pixels that corners are off after them: of another place

Small = UInt8[np.ndarray, "h w"]


def anchored(state: State, pair: Pair, found: Correspondences) -> State:
    """The state with the corners of a pair, where none are followed."""
    if not state.config.motion or state.corners is not None:
        return state
    seen = corners(pair, Matches.of(found, state.rig), match_radius(found, state.rig), _MOST)
    if len(seen.left) < _FEWEST:
        return state
    return state.replace(corners=seen, corners_frame=state.frame, corners_time=pair.time)


def moved(state: State, pair: Pair) -> State:
    """The state after a pair that may show corners again from elsewhere; how the rig stands is said after the look."""
    before, pairs, gap = state.corners, state.frame - state.corners_frame, state.tracked_pairs
    if before is None or pairs < gap:
        return state
    seconds = None if state.corners_time is None or pair.time is None else pair.time - state.corners_time
    state = state.replace(corners=None)
    # A repair in between may have taken many pairs; and of how much of the motion a readout is, times tell.
    if not (pairs <= _LONGEST and not pair.readout if seconds is None else 0.0 < seconds <= _SECONDS):
        return state
    tracks = corner_tracks(before, pair)
    if pair.readout and seconds is not None:
        tracks = replace(tracks, readout=pair.readout / seconds)
    # Near the estimate, lenses included: near the calibration in use, depth of a drive was off by 4 %.
    near = state.estimate.theta if state.chart.stands_at(state.estimate.theta) else state.theta
    tracked = window(tracks, state.chart, near)
    if tracked.motion is None or len(tracks) < _LEFT * len(before.left):
        gap = max(gap // 2, 1)
    elif tracked.metres[0] < AHEAD * float(state.rig.baseline):
        gap = min(2 * gap, max(_LONGEST - _LONGEST % state.config.every, 1))  # pairs to a look that comes soon enough
    state = state.replace(tracked_pairs=gap)
    if tracked.motion is None or not tracked.informative:
        return state
    turned = np.degrees(vector_from_rotation(tracked.motion.rotation)) / pairs
    turned = np.zeros(3) if state.config.synchronous else turned
    return _after_window(state, motion_measurement(tracked.normal, turned))


def motion_measurement(normal: Normal, turned: Float[np.ndarray, "3"]) -> Measurement:
    """What a window says of the rig, where a late shutter would have turned the right image by so much, degrees."""
    return Measurement(normal, turned).weighed(_WORSE**-2.0)


def _after_window(state: State, measured: Measurement) -> State:
    """The state after a window, which counts as much as it is likely to be of the rig's own motion. One that is not
    waits for the next: most that moves may not be the rig, or the rig has turned and rows did not show it."""
    from scipy.special import expit  # a third of a second to import

    estimate = state.estimate
    of_rig, of_others = (one.log_likelihood(measured) for one in (estimate, estimate.widened([0.0, _OWN_YAW])))
    expected = _STAY * state.others + _COME * (1.0 - state.others)
    odds = np.log1p(-expected) - np.log(expected) + of_rig - of_others
    if not np.isfinite(odds):
        return state
    share = float(expit(odds))
    first, state = state.outlier_motion, state.replace(others=1.0 - share, outlier_motion=None)
    state = state.measured(measured.weighed(share))
    if share >= 0.5:
        return state
    state = state.replace(outlier_motion=measured)
    if first is None:
        return state
    turned = state.beside[0].updated(first)
    if turned.chance_of(measured) < _FITS:
        return state
    turned = turned.updated(measured)
    # A boat tells the same yaw twice, too; rows know of none.
    before, after = (squared_error(state.initial, state.config.prior, one) for one in (estimate, turned))
    if after > before:
        return state
    return state.standing_at(turned).replace(outlier_motion=None, others=_COME)


def small(image: Float[np.ndarray, "h w"]) -> Small:
    """The image as it is kept until the next one comes."""
    height, width = image.shape
    size = (min(width, _WIDTH), round(height * min(width, _WIDTH) / width))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def turn(camera: Camera, before: Small, after: Small) -> Float[np.ndarray, "3"] | None:
    """Rotation vector (3,) [rad] of x(now) = Q x(before) in the camera's frame; None if nothing can be followed.

    Corners are followed (Lucas & Kanade 1981) and the rotation solved for with Cauchy's weights, since what is near
    moves more than that when the rig travels.
    """
    starts = cv2.goodFeaturesToTrack(before, _OF_TURN, 0.01, 6)
    if starts is None or len(starts) < _FEWEST_OF_TURN or before.shape != after.shape:
        return None
    ends, followed, _ = cv2.calcOpticalFlowPyrLK(before, after, starts, np.zeros_like(starts))
    tracked = followed.reshape(-1) > 0
    if tracked.sum() < _FEWEST_OF_TURN:
        return None
    zoom = camera.size[0] / before.shape[1]
    first, second = ((zoom * (points.reshape(-1, 2)[tracked] + 0.5) - 0.5).astype(float) for points in (starts, ends))
    design, wanted = _by_turn(camera, first, second)
    if len(wanted) < _FEWEST_OF_TURN:
        return None
    weight, found, spread = np.ones_like(wanted), np.zeros(3), 0.0
    for _ in range(_ROUNDS):
        found = np.linalg.lstsq(design * weight[:, None] ** 0.5, wanted * weight**0.5, rcond=None)[0]
        residuals = wanted - design @ found
        spread = max(1.4826 * float(np.median(np.abs(residuals))), 1e-5)
        weight = 1.0 / (1.0 + (residuals / spread) ** 2)
    return found if spread * float(camera.focal[0]) < _LOST * zoom else None


def _by_turn(
    camera: Camera, first: Float[np.ndarray, "k 2"], second: Float[np.ndarray, "k 2"]
) -> tuple[Float[np.ndarray, "e 3"], Float[np.ndarray, "e"]]:
    """How the directions of pixels move with a small rotation, and how they moved: those far off the axis have no image
    point on a plane."""
    rays, ends = np.asarray(camera.directions(first)), np.asarray(camera.directions(second))
    known = np.isfinite(rays + ends).all(axis=1)
    if camera.lens.WIDE:  # what lies at the edge of a lens' own image does not move with the scene
        around = camera.size[0] / _WIDTH * _BESIDE * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
        known &= np.isfinite(np.asarray(camera.directions(first[:, None] + around))).all(axis=(1, 2))
    rays, flow = rays[known], (ends - rays)[known]
    by_turn = np.cross(np.eye(3)[:, None], rays)  # (axis, k, 3)
    return by_turn.reshape(3, -1).T, flow.reshape(-1)
