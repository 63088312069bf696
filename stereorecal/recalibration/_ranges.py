"""Ranges: distances that something else measured, of what single pixels show. They fix what rows cannot see: the length
of the baseline, and the one offset of disparity that yaw, centres and focal lengths share."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig, rectifying_rotations
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, RigChart
from stereorecal.recalibration._acceptance import Reason
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import ScoringData, host

_FAR = 3.0  # standard deviations: beyond, a range is more likely another thing's
_STEP = 1e-4  # of the box, for derivatives


@dataclass(frozen=True, eq=False)
class Beams:
    """Ranges whose pixels were found in the right image.

    Attributes:
        left, right: (b, 2) pixels as the cameras took them, at full size.
        metres, sigma: (b,).
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
        ray = np.asarray(rig.left.rays(self.left))
        direction = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
        finite = np.isfinite(self.metres)
        near = np.where(finite, 1.0 / np.where(finite, self.metres, 1.0), 0.0)
        asked = (direction @ rig.rotation.T + near[:, None] * rig.translation) @ to_right.T
        seen = np.asarray(rig.right.rays(self.right)) @ to_right.T
        focal = float(rig.right.matrix[0, 0])
        apart = focal * (seen[:, 0] / seen[:, 2] - asked[:, 0] / asked[:, 2])
        by_range = focal * float(rig.baseline) * np.where(finite, self.sigma, 0.0) * near**2
        return apart / np.hypot(self.matching, by_range)

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

    def __bool__(self) -> bool:
        return len(self.metres) > 0

    def contradict(self, rig: StereoRig) -> Bool[np.ndarray, "b"]:
        """Which of them a rig does not explain."""
        return ~(np.abs(self.residuals(rig)) < _FAR)

    def agree(self, rig: StereoRig) -> bool:
        """Whether most of them fit a rig."""
        return bool(np.mean(self.contradict(rig)) < 0.5)

    def fit_better(self, before: StereoRig, after: StereoRig) -> bool:
        """Whether most of them agree with a rig, and much better than with another one."""
        bounded = [float(np.minimum(self.residuals(rig) ** 2, _FAR**2).sum()) for rig in (before, after)]
        return bounded[0] - bounded[1] > _FAR**2 and self.agree(after)

    @staticmethod
    def of_all(several: Sequence["Beams"]) -> "Beams":
        """Those of several recordings."""
        return Beams(*(np.concatenate([getattr(one, part.name) for one in several]) for part in fields(Beams)))

    @staticmethod
    def votes(residuals: Float[np.ndarray, "b"]) -> Float[np.ndarray, "b"]:
        """Of each range, 1 at most; from afar, where all are wrong, those that agree with each other keep theirs."""
        scale = max(_FAR, 2.0 * float(np.median(np.abs(residuals))))
        return 1.0 / (1.0 + (residuals / scale) ** 2)


NONE = Beams(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))


@dataclass(frozen=True)
class RangesSeen:
    """What became of ranges.

    Attributes:
        given: how many there were.
        matched: how many of them lie on a sure match.
        contradict: how many of those the calibration to use does not explain.
        refused: why the calibration that was found with them is not used, where there is one.
    """

    given: int
    matched: int
    contradict: int
    refused: Reason | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        refused = self.refused and self.refused.name.lower()
        return {"given": self.given, "matched": self.matched, "contradict": self.contradict, "refused": refused}

    def __str__(self) -> str:
        said = f"{self.given} given, {self.matched} matched, {self.contradict} contradict"
        if not self.matched:
            return f"{said}: give some on surfaces with texture, off edges, in frames that are used"
        if 2 * self.contradict >= self.matched:
            said += ": most do not fit this calibration; check their units, pixels and pairs"
        return said + (f"; what was found with them is not used: {self.refused.value}" if self.refused else "")


def beams(
    data: ScoringData, rig: StereoRig, matcher: AbstractMatcher, pairs: Sequence[Pair], ranges: Sequence[Range]
) -> Beams:
    """The resolved ranges of these pairs, matched under `rig`; those without a sure match are left out."""
    by_frame = [[one for one in ranges if one.pair is pair] for pair in pairs]
    pixels = [np.array([one.left_pixel for one in some], float).reshape(-1, 2) for some in by_frame]
    partners = host.partners(data, rig, matcher, pixels)
    right = np.concatenate([NONE.right, *(some.pixels for some in partners)])
    metres = np.array([one.metres for some in by_frame for one in some], float)
    sigma = np.array([0.01 * r.metres if r.sigma is None else r.sigma for some in by_frame for r in some], float)
    found = np.isfinite(right).all(axis=-1)
    return Beams(
        np.concatenate([NONE.left, *pixels])[found],
        right[found],
        metres[found],
        sigma[found],
        np.concatenate([NONE.matching, *(some.deviation for some in partners)])[found],
    )


def resolved_ranges(
    ranges: Range | Sequence[Range], recordings: Sequence[tuple[str, Sequence[Pair]]]
) -> tuple[Range, ...]:
    """The ranges, each with the pair that it means.

    Args:
        recordings: names and pairs.

    Raises:
        InputError: names a range that belongs to no pair, to several, or to no pixel of it.
    """
    return tuple(_resolved(one, recordings) for one in as_ranges(ranges))


def as_ranges(ranges: Range | Sequence[Range]) -> tuple[Range, ...]:
    """One range or several.

    Raises:
        InputError: if there is something else among them.
    """
    several = (ranges,) if isinstance(ranges, Range) else tuple(ranges)
    for one in several:
        if not isinstance(one, Range):
            raise InputError(f"a range is {one!r}; make it with sr.Range(pair, (column, row), metres, sigma).")
    return several


def _resolved(one: Range, recordings: Sequence[tuple[str, Sequence[Pair]]]) -> Range:
    named = [(f"{name}/{pair.name}", pair) for name, pairs in recordings for pair in pairs]
    wanted = one.pair
    if isinstance(wanted, Pair):
        found = [pair for _, pair in named if pair is wanted]
    else:
        found = [pair for name, pair in named if wanted in (pair.name, name)]
        if not found and len(recordings) == 1 and str(wanted).isdecimal():
            found = list(recordings[0][1][int(wanted) : int(wanted) + 1])
    if len(found) != 1:
        what = wanted.name if isinstance(wanted, Pair) else wanted
        which = "which is not among those given" if not found else f"and {len(found)} have that name"
        raise InputError(f'a range is of the pair {what!r}, {which}; name one, such as "{named[0][0]}".')
    (pair,) = found
    if not all(0.0 <= at <= length - 1 for at, length in zip(one.left_pixel, pair.size, strict=True)):
        size = "x".join(map(str, pair.size))
        raise InputError(f"the range at pixel {one.left_pixel} lies outside of the {size} image.")
    return replace(one, pair=pair)


def with_ranges(free: Parameters, ranges: Range | Sequence[Range]) -> Parameters:
    """What is free where there are ranges: the length of the baseline as well."""
    return free.also(BASELINE) if as_ranges(ranges) else free
