"""The strategy: match features, estimate an essential matrix, refine the extrinsics."""

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import least_squares

from stereorecal.geometry import euler_from_rotation, rotation_from_euler
from stereorecal.objectives import Chart, Images
from stereorecal.strategies import AbstractStrategy, Need, Objective, Outcome, Status
from stereorecal_features._matches import Seen, matched_pixels, seen_by_both

_ROUNDS = 10  # our choice: a set of inliers that still changes then is taken to be unstable
_FEWEST = 8  # our choice: fewer matches hardly overdetermine five parameters


@dataclass(frozen=True)
class Features(AbstractStrategy):
    """SIFT features, an essential matrix (USAC-MAGSAC) and robust least squares on the images; no score is evaluated.

    The matches of all frames are pooled, since the rig is the same. The inliers of an essential matrix have their
    Sampson errors minimised over all free parameters within the box, once from the start and once from the pose of the
    essential matrix; the result with the lower cost is kept. The inliers are then selected anew and the errors
    minimised again, until the set of inliers does not change.

    It spends no units of the budget: a unit is one run of the stereo matcher, and it runs none. A limit in seconds is
    checked between frames.

    Attributes:
        features: the most features per image; matching them takes about 8 features² bytes.
        contrast: the least contrast of a feature (OpenCV's `contrastThreshold`); lower it where texture is weak.
        ratio: Lowe's ratio test, in (0, 1]; 1 turns it off.
        threshold: the largest epipolar error of an inlier, in pixels.
        loss_scale: Sampson error in pixels beyond which a match counts less than quadratically (soft L1).
        min_matches: the run ends as STALLED with fewer matches or fewer inliers.
    """

    needs: ClassVar[Need] = Need.IMAGES

    features: int = 5000
    contrast: float = 0.04
    ratio: float = 0.8
    threshold: float = 1.0
    loss_scale: float = 0.25
    min_matches: int = 20

    def __post_init__(self) -> None:
        for name in ("contrast", "threshold", "loss_scale"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"need {name} > 0, got {getattr(self, name)}")
        if not 0.0 < self.ratio <= 1.0:
            raise ValueError(f"need 0 < ratio <= 1, got {self.ratio}")
        if not _FEWEST <= self.min_matches <= self.features:
            raise ValueError(
                f"need {_FEWEST} <= min_matches <= features, got {self.min_matches} and {self.features} features"
            )

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        """See `AbstractStrategy.run`. `seed` is that of the random samples for the essential matrix."""
        images: Images = objective.images  # there, since the core checks `needs`
        pixels = []
        for pair in images.pairs:
            if objective.remaining <= 0:
                return Outcome(start, Status.BUDGET)
            pixels.append(matched_pixels(pair, self.features, self.contrast, self.ratio))
        left, right = seen_by_both(images.rig, pixels)
        if len(left) < self.min_matches:
            return Outcome(start, Status.STALLED, f"only {len(left)} matches; {self.min_matches} are needed")
        return self._fit(images, left, right, start, seed)

    def _fit(self, images: Images, left: Seen, right: Seen, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        pose, agree = _five_point_pose(images, left, right, self.threshold, seed)
        starts, message = [start, pose], ""
        for _ in range(_ROUNDS):
            message = f"{agree.sum()} of {len(left)} matches agree"
            if agree.sum() < self.min_matches:
                return Outcome(start, Status.STALLED, f"only {message} on a pose; {self.min_matches} are needed")
            ends = [_refined(images.chart, left[agree], right[agree], begin, self.loss_scale) for begin in starts]
            fit = min(ends, key=lambda end: end.cost)
            errors, before = np.abs(_sampson(images.chart, fit.x, left, right)), agree
            starts, agree = [fit.x], errors < self.threshold
            if np.array_equal(agree, before):
                message = f"{message}, to {np.median(errors[agree]):.2f} px"
                return Outcome(fit.x, Status.CONVERGED if fit.success else Status.STALLED, message)
        return Outcome(starts[0], Status.STALLED, f"{message}, and not the same ones for {_ROUNDS} rounds")


def _five_point_pose(
    images: Images, left: Seen, right: Seen, threshold: float, seed: int
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
    how.threshold = threshold / float(np.mean([np.diag(camera.matrix)[:2] for camera in (rig.left, rig.right)]))
    plain, straight = np.eye(3), np.zeros(4)  # rays instead of pixels
    points = [np.ascontiguousarray(seen.rays[:, :2]) for seen in (left, right)]
    essential, agree = cv2.findEssentialMat(points[0], points[1], plain, plain, straight, straight, how)
    if essential is None or np.shape(essential) != (3, 3):
        return np.zeros(chart.dim), np.zeros(len(left), bool)
    first, second, direction = cv2.decomposeEssentialMat(essential)
    rotation = max(first, second, key=lambda turn: np.trace(turn.T @ rig.rotation))
    translation = direction.ravel() * rig.translation[0] / (direction[0, 0] or 1.0)  # the scale is free, and x is known
    extrinsics = np.concatenate([euler_from_rotation(rotation), translation])
    return np.clip(chart.coordinates(extrinsics), -1.0, 1.0), agree.ravel() > 0


def _refined(chart: Chart, left: Seen, right: Seen, start: Float[np.ndarray, "n"], loss_scale: float):
    """SciPy's result of minimising the robust sum of squared Sampson errors over the box, from `start`."""
    return least_squares(
        lambda z: _sampson(chart, z, left, right), start, bounds=(-1, 1), loss="soft_l1", f_scale=loss_scale
    )


def _sampson(chart: Chart, z: Float[np.ndarray, "n"], left: Seen, right: Seen) -> Float[np.ndarray, "m"]:
    """The Sampson error of each match, in pixels: to first order, its distance from satisfying the epipolar constraint
    over both images."""
    extrinsics = np.asarray(chart.extrinsics(z))
    tx, ty, tz = extrinsics[3:]
    essential = np.array([[0.0, -tz, ty], [tz, 0.0, -tx], [-ty, tx, 0.0]]) @ rotation_from_euler(extrinsics[:3])
    right_lines, left_lines = left.rays @ essential.T, right.rays @ essential
    sides = (right_lines, right), (left_lines, left)
    slopes = [np.einsum("mi,mij->mj", lines[:, :2], seen.per_px) for lines, seen in sides]
    return (right.rays * right_lines).sum(1) / np.linalg.norm(np.concatenate(slopes, axis=1), axis=1)
