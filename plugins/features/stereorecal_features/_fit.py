"""How it is done: match features, estimate an essential matrix, refine the extrinsics."""

import cv2
import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import least_squares

from stereorecal.geometry import euler_from_rotation, rotation_from_euler
from stereorecal.objectives import RigChart, StereoImages
from stereorecal.strategies import Objective, Outcome, Status
from stereorecal_features._abstract_fit import AbstractFit
from stereorecal_features._matches import Seen, seen_by_both
from stereorecal_features._subpixel import refined

_ROUNDS = 10  # our choice: a set of inliers that still changes then is taken to be unstable


def search(how: AbstractFit, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
    """The matches of all frames, and the pose that fits them; see `Features`."""
    images: StereoImages = objective.images  # there, since the core checks `needs`
    pixels = []
    for pair in images.pairs:
        if objective.remaining <= 0:
            return Outcome(start, Status.BUDGET)
        found = how.matched(pair.left, pair.right)
        pixels.append(refined(pair, *found) if how.subpixel else found)
    left, right = seen_by_both(images.rig, pixels)
    if len(left) < how.min_matches:
        return Outcome(start, Status.STALLED, f"only {len(left)} matches; {how.min_matches} are needed")
    return fitted(how, images, left, right, start, seed)


def fitted(
    how: AbstractFit, images: StereoImages, left: Seen, right: Seen, start: Float[np.ndarray, "n"], seed: int
) -> Outcome:
    """The pose on which the matches agree, as an outcome."""
    pose, agree = _five_point_pose(images, left, right, how.threshold, seed)
    starts, message = [start, pose], ""
    for _ in range(_ROUNDS):
        message = f"{agree.sum()} of {len(left)} matches agree"
        if agree.sum() < how.min_matches:
            return Outcome(start, Status.STALLED, f"only {message} on a pose; {how.min_matches} are needed")
        ends = [_refined(images.chart, left[agree], right[agree], begin, how.loss_scale) for begin in starts]
        fit = min(ends, key=lambda end: end.cost)
        errors, before = np.abs(_sampson(images.chart, fit.x, left, right)), agree
        starts, agree = [fit.x], errors < how.threshold
        if np.array_equal(agree, before):
            message = f"{message}, to {np.median(errors[agree]):.2f} px"
            return Outcome(fit.x, Status.CONVERGED if fit.success else Status.STALLED, message)
    return Outcome(starts[0], Status.STALLED, f"{message}, and not the same ones for {_ROUNDS} rounds")


def _five_point_pose(
    images: StereoImages, left: Seen, right: Seen, threshold: float, seed: int
) -> tuple[Float[np.ndarray, "n"], Bool[np.ndarray, "m"]]:
    """The pose of an essential matrix as a point of the box, and which matches are inliers, within `threshold` [px].

    Where no essential matrix is found, that is the centre of the box, and no inliers. Of the four poses that the matrix
    decomposes into, this is the one nearest to the rig's: `recoverPose` would choose the one with most points in front
    of both cameras, but does not count points farther away than 50 baselines.
    """
    rig, chart = images.rig, images.chart
    how = cv2.UsacParams()  # the parameters behind the flag USAC_MAGSAC, with a seed, which the flag cannot set
    how.score, how.loMethod, how.loIterations, how.loSampleSize = cv2.SCORE_METHOD_MAGSAC, cv2.LOCAL_OPTIM_SIGMA, 10, 50
    how.confidence, how.maxIterations, how.randomGeneratorState = 0.9999, 10_000, int(seed) % 2**31
    how.threshold = threshold
    # Rays, as pixels of one pinhole camera without distortion: MAGSAC's scale of noise is made for pixels.
    focal = float(np.mean([np.diag(camera.matrix)[:2] for camera in (rig.left, rig.right)]))
    pinhole, straight = np.diag([focal, focal, 1.0]), np.zeros(4)
    points = [np.ascontiguousarray(focal * seen.rays[:, :2]) for seen in (left, right)]
    essential, agree = cv2.findEssentialMat(points[0], points[1], pinhole, pinhole, straight, straight, how)
    if essential is None or np.shape(essential) != (3, 3):
        return np.zeros(chart.dim), np.zeros(len(left), bool)
    first, second, direction = cv2.decomposeEssentialMat(essential)
    rotation = max(first, second, key=lambda turn: np.trace(turn.T @ rig.rotation))
    translation = direction.ravel() * rig.translation[0] / (direction[0, 0] or 1.0)  # the scale is free, and x is known
    extrinsics = np.concatenate([euler_from_rotation(rotation), translation])
    return np.clip(chart.coordinates(extrinsics), -1.0, 1.0), agree.ravel() > 0


def _refined(chart: RigChart, left: Seen, right: Seen, start: Float[np.ndarray, "n"], loss_scale: float):
    """SciPy's result of minimising the robust sum of squared Sampson errors over the box, from `start`."""
    return least_squares(
        lambda z: _sampson(chart, z, left, right), start, bounds=(-1, 1), loss="soft_l1", f_scale=loss_scale
    )


def _sampson(chart: RigChart, z: Float[np.ndarray, "n"], left: Seen, right: Seen) -> Float[np.ndarray, "m"]:
    """The Sampson error of each match, in pixels: to first order, its distance from satisfying the epipolar constraint
    over both images."""
    extrinsics = np.asarray(chart.extrinsics(z))
    tx, ty, tz = extrinsics[3:]
    essential = np.array([[0.0, -tz, ty], [tz, 0.0, -tx], [-ty, tx, 0.0]]) @ rotation_from_euler(extrinsics[:3])
    right_lines, left_lines = left.rays @ essential.T, right.rays @ essential
    sides = (right_lines, right), (left_lines, left)
    slopes = [np.einsum("mi,mij->mj", lines[:, :2], seen.per_px) for lines, seen in sides]
    return (right.rays * right_lines).sum(1) / np.linalg.norm(np.concatenate(slopes, axis=1), axis=1)
