"""Ranges: distances that something else measured, of what single pixels show. They fix what rows cannot see: the length
of the baseline, and the one offset of disparity that yaw, centres and focal lengths share."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, rectifying_rotations
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, RigChart
from stereorecal.recordings import Pair, Range, refers_to
from stereorecal.scoring import ScoringData, host

_MATCHING = 0.1  # pixels: standard deviation of a disparity of a single pixel
_FAR = 3.0  # standard deviations: beyond, a range is more likely another thing's
_STEP = 1e-4  # of the box, for derivatives


@dataclass(frozen=True, eq=False)
class Beams:
    """Ranges whose pixels were found in the right image.

    Attributes:
        left, right: (b, 2) pixels as the cameras took them, at full size.
        metres, sigma: (b,).
    """

    left: Float[np.ndarray, "b 2"]
    right: Float[np.ndarray, "b 2"]
    metres: Float[np.ndarray, "b"]
    sigma: Float[np.ndarray, "b"]

    def residuals(self, rig: StereoRig) -> Float[np.ndarray, "b"]:
        """Disparity that the distance asks for less the one that was found, in standard deviations."""
        _, to_right = rectifying_rotations(rig.rotation, rig.translation)
        ray = np.asarray(rig.left.rays(self.left))
        direction = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
        finite = np.isfinite(self.metres)
        near = np.where(finite, 1.0 / np.where(finite, self.metres, 1.0), 0.0)
        asked = (direction @ rig.rotation.T + near[:, None] * rig.translation) @ to_right.T
        seen = np.asarray(rig.right.rays(self.right)) @ to_right.T
        focal = float(rig.right.matrix[0, 0])
        apart = focal * (seen[:, 0] / seen[:, 2] - asked[:, 0] / asked[:, 2])
        by_range = focal * float(rig.baseline) * np.where(finite, self.sigma, 0.0) * near**2
        return apart / np.hypot(_MATCHING, by_range)

    def normal_and_pull(
        self, chart: RigChart, z: Float[np.ndarray, "n"]
    ) -> tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]]:
        """Of the least-squares problem near z; a range far from the others has hardly a vote (Cauchy)."""
        if not len(self.metres):
            return np.zeros((z.size, z.size)), np.zeros(z.size)
        here = self.residuals(chart.rig_at(z))
        steps = _STEP * np.eye(z.size)
        ends = [(self.residuals(chart.rig_at(z + h)), self.residuals(chart.rig_at(z - h))) for h in steps]
        jacobian = np.stack([(more - less) / (2 * _STEP) for more, less in ends], axis=-1)
        vote = self.votes(here)
        return jacobian.T @ (vote[:, None] * jacobian), jacobian.T @ (vote * here)

    @staticmethod
    def votes(residuals: Float[np.ndarray, "b"]) -> Float[np.ndarray, "b"]:
        """Of each range, 1 at most; from afar, where all are wrong, those that agree with each other keep theirs."""
        scale = max(_FAR, 2.0 * float(np.median(np.abs(residuals))))
        return 1.0 / (1.0 + (residuals / scale) ** 2)


NONE = Beams(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0))


def beams(
    data: ScoringData, rig: StereoRig, matcher: AbstractMatcher, pairs: Sequence[Pair], ranges: Sequence[Range]
) -> Beams:
    """The ranges of these pairs, matched under `rig`; those without a sure match are left out.

    Raises:
        InputError: if a pixel lies outside of the image.
    """
    width, height = rig.left.size
    by_frame: list[list[Range]] = [[one for one in ranges if refers_to(one, pair, i)] for i, pair in enumerate(pairs)]
    for one in (one for some in by_frame for one in some):
        if not (0 <= one.left_pixel[0] <= width - 1 and 0 <= one.left_pixel[1] <= height - 1):
            raise InputError(f"the range at pixel {one.left_pixel} lies outside of the {width}x{height} image.")
    pixels = [np.array([one.left_pixel for one in some], float).reshape(-1, 2) for some in by_frame]
    right = np.concatenate([np.zeros((0, 2)), *host.partners(data, rig, matcher, pixels)])
    metres = np.array([one.metres for some in by_frame for one in some], float)
    sigma = np.array([0.01 * r.metres if r.sigma is None else r.sigma for some in by_frame for r in some], float)
    found = np.isfinite(right).all(axis=-1)
    return Beams(np.concatenate([np.zeros((0, 2)), *pixels])[found], right[found], metres[found], sigma[found])


def check_ranges(ranges: Sequence[Range], pairs: Sequence[Pair]) -> tuple[Range, ...]:
    """The ranges, if each belongs to a pair.

    Raises:
        InputError: names one that does not.
    """
    for one in ranges:
        if not isinstance(one, Range):
            raise InputError(f"a range is {one!r}; make it with sr.Range(pair, (column, row), metres, sigma).")
        if not any(refers_to(one, pair, index) for index, pair in enumerate(pairs)):
            what = one.pair.name if isinstance(one.pair, Pair) else one.pair
            raise InputError(f"a range is of the pair {what!r}, which is not among those given; name one of them.")
    return tuple(ranges)


def with_ranges(free: Parameters, ranges: Sequence[Range]) -> Parameters:
    """What is free where there are ranges: the length of the baseline as well."""
    return free.also(BASELINE) if len(ranges) else free
