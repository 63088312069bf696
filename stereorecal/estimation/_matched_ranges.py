"""Matched ranges: distances measured by another sensor, of pixels that were found in both images.

They determine what epipolar errors do not: the length of the baseline, and the one offset of disparity that yaw,
principal points and focal lengths share.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._rig_parameters import moved_by_extrinsics, rays_by_lens
from stereorecal.geometry import StereoRig, rectifying_rotations, rectifying_slopes
from stereorecal.objectives import BASELINE, SIDES, RigChart

_FAR = 3.0  # standard deviations: beyond, a range is more likely another thing's
_OF_OTHER_THINGS = 0.05  # probability that all are: in other units, of another pair, of other pixels
_LONGEST = 10.0  # percent, of a baseline's error: what asks for more is in other units, and agrees on nothing
_NEAR = 1e-6  # standard deviations by a percent of the baseline: a range of less is of the horizon
_ANYWHERE = 0.1  # of the image's width, within which the disparities of other things lie


@dataclass(frozen=True, eq=False)
class MatchedRanges:
    """Measured distances of pixels of the left image, with their matches in the right one.

    Attributes:
        left, right: (b, 2) pixels as the cameras took them, at full size.
        metres, sigma: (b,) distance from the left camera, and its standard deviation.
        matching: (b,) standard deviations of their disparities, pixels of the right camera.
    """

    left: Float[np.ndarray, "b 2"]
    right: Float[np.ndarray, "b 2"]
    metres: Float[np.ndarray, "b"]
    sigma: Float[np.ndarray, "b"]
    matching: Float[np.ndarray, "b"]

    def residuals(self, rig: StereoRig) -> Float[np.ndarray, "b"]:
        """Disparity that the distance asks for less the one that was found, in standard deviations."""
        _, to_right = rectifying_rotations(rig.rotation, rig.translation)
        direction, right, _ = self._rays(rig)
        seen = direction @ rig.rotation.T + self._nearness[:, None] * rig.translation
        (observed, _, depth), (x, _, z) = to_right @ right.T, to_right @ seen.T
        return float(rig.right.focal[0]) * (observed / depth - x / z) / self.deviations(rig)

    def _rays(
        self, rig: StereoRig
    ) -> tuple[Float[np.ndarray, "b 3"], Float[np.ndarray, "b 3"], Float[np.ndarray, "b"]]:
        """Directions from the left camera, rays of the right one, and how long the rays of the left one are."""
        left, right = np.asarray(rig.left.rays(self.left)), np.asarray(rig.right.rays(self.right))
        length = np.linalg.norm(left, axis=-1)
        return left / length[:, None], right, length

    def _jacobian(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "b n"]:
        """Derivatives of the residuals by θ; the deviations stay as they are."""
        rig, found = chart.rig_at(theta), np.zeros((chart.dim, len(self.metres)))
        (direction, right, length), near = self._rays(rig), self._nearness
        seen = direction @ rig.rotation.T + near[:, None] * rig.translation
        _, to_right = rectifying_rotations(rig.rotation, rig.translation)
        outer, *by_pose = chart.pose_slopes(rig)
        turned = rectifying_slopes(np.asarray(rig.rotation), np.asarray(rig.translation), *by_pose)[:, 1].swapaxes(1, 2)

        def column(points: Float[np.ndarray, "b 3"], moved: Float[np.ndarray, "m b 3"]) -> Float[np.ndarray, "m b"]:
            """Derivatives of rectified columns, in focal lengths, of points whose rectified ones have these."""
            x, _, z = to_right @ points.T
            return (moved[..., 0] - x / z * moved[..., 2]) / z

        _, moved = moved_by_extrinsics(chart, rig, direction, near)
        found[outer] = column(right, right @ turned) - column(seen, seen @ turned + moved @ to_right.T)
        own, by = rays_by_lens(chart, rig, SIDES[0], direction)
        by = (by - direction * np.sum(direction * by, axis=-1, keepdims=True)) / length[:, None]
        found[own] = -column(seen, by @ (to_right @ rig.rotation).T)
        own, by = rays_by_lens(chart, rig, SIDES[1], right)
        found[own] = column(right, by @ to_right.T)
        return (float(rig.right.focal[0]) * found / self.deviations(rig)).T

    def deviations(self, rig: StereoRig) -> Float[np.ndarray, "b"]:
        """Standard deviations of the disparities less those that the distances ask for, pixels of the right camera."""
        pull, finite = float(rig.right.focal[0]) * float(rig.baseline), np.isfinite(self.metres)
        return np.hypot(self.matching, pull * np.where(finite, self.sigma, 0.0) * self._nearness**2)

    @property
    def _nearness(self) -> Float[np.ndarray, "b"]:
        return 1.0 / self.metres  # 0 of the horizon

    def normal(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Normal:
        """The likelihood of θ, linear near a θ, against that of ranges of other things, which is 1; one that is far
        from the others, under a baseline as long as most of them ask for, has no say (Geman & McClure)."""
        rig = chart.rig_at(theta)
        residuals, jacobian = self.residuals(rig), self._jacobian(chart, theta)
        apart = _of_likely_length(residuals, jacobian[:, chart.names.index(BASELINE)])
        # From afar, where all are wrong, those that agree keep their say.
        grown = 1.0 + (apart / max(_FAR, 2.0 * float(np.median(np.abs(apart))))) ** 2
        at_zero, jacobian = (residuals - jacobian @ theta) / grown, jacobian / grown[:, None]
        density = grown * self.deviations(rig) * np.sqrt(2.0 * np.pi) / (_ANYWHERE * rig.right.size[0])
        c = float(at_zero @ at_zero + 2.0 * np.log(density).sum())
        return Normal(jacobian.T @ jacobian, -jacobian.T @ at_zero, c)

    def likelihoods(self, chart: RigChart, theta: Float[np.ndarray, "n"]) -> list[tuple[float, Normal]]:
        """What they may tell of θ, near a θ: that, or nothing, since they are of other things; each with the logarithm
        of its probability. Nothing where there are none."""
        nothing = Normal.flat(chart.dim)
        if not self:
            return [(0.0, nothing)]
        own = float(np.log1p(-_OF_OTHER_THINGS)), self.normal(chart, theta)
        return [own, (float(np.log(_OF_OTHER_THINGS)), nothing)]

    def __bool__(self) -> bool:
        return len(self.metres) > 0

    def contradict(self, rig: StereoRig) -> Bool[np.ndarray, "b"]:
        """Which of them a rig does not explain."""
        return ~(np.abs(self.residuals(rig)) < _FAR)

    def agree(self, rig: StereoRig) -> bool:
        """Whether most of them fit a rig."""
        return bool(self) and bool(np.mean(self.contradict(rig)) < 0.5)

    def fit_better(self, before: StereoRig, after: StereoRig) -> bool:
        """Whether most of them agree with a rig, and much better than with another one."""
        bounded = [float(np.minimum(self.residuals(rig) ** 2, _FAR**2).sum()) for rig in (before, after)]
        return bounded[0] - bounded[1] > _FAR**2 and self.agree(after)


def _of_likely_length(residuals: Float[np.ndarray, "b"], slopes: Float[np.ndarray, "b"]) -> Float[np.ndarray, "b"]:
    """The residuals under a baseline as long as most of them ask for, where their sizes sum up to least: a weighted
    median of what each asks for; the slopes are those by its length. As they are, where no baseline is as long."""
    near = np.abs(slopes) > _NEAR
    if not near.any():
        return residuals
    asked, weights = -residuals[near] / slopes[near], np.abs(slopes[near])
    order = np.argsort(asked)
    middle = order[np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())]
    return residuals + asked[middle] * slopes if abs(asked[middle]) < _LONGEST else residuals


NO_RANGES = MatchedRanges(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))
