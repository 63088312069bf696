"""Ranges as users give them: which pairs they mean, their pixels in the right images, and what became of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereorecal._errors import InputError
from stereorecal.decision import Reason
from stereorecal.estimation import MatchedRanges
from stereorecal.geometry import StereoRig, turned_pixels, turned_size
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters
from stereorecal.recordings import Odometer, Pair, Range
from stereorecal.scoring import ScoringData, host


@dataclass(frozen=True)
class RangesSeen:
    """What became of the ranges that were given.

    Attributes:
        given: how many there were.
        matched: how many of them have a reliable match.
        contradict: how many matched ranges disagree with the rig in use.
        refused: why the candidate estimated with the ranges was rejected; None if it was accepted, or there is none.
    """

    given: int
    matched: int
    contradict: int
    refused: Reason | None = None

    @classmethod
    def of(
        cls, given: int, matched: MatchedRanges, initial: StereoRig, candidate: StereoRig, reason: Reason
    ) -> "RangesSeen | None":
        """What became of so many ranges; None if there were none."""
        if not given:
            return None
        used = candidate if reason.accepted else initial
        refused = None if reason.accepted or not matched.fit_better(initial, candidate) else reason
        return cls(given, len(matched.metres), int(matched.contradict(used).sum()), refused)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        refused = self.refused and self.refused.name.lower()
        return {"given": self.given, "matched": self.matched, "contradict": self.contradict, "refused": refused}

    def __str__(self) -> str:
        if not self.matched:
            return (
                f"{self.given} given, 0 matched; give some on surfaces with texture, off edges, in frames that are used"
            )
        text = f"{self.matched - self.contradict} of {self.matched} agree ({self.given} given)"
        if 2 * self.contradict >= self.matched:
            text += (
                "; most do not fit this calibration; check their units, pixels and pairs, and whether they are along "
                "the ray or the optical axis"
            )
        return text + (f"; what was found with them is not used, since {self.refused.value}" if self.refused else "")


def match_ranges(
    data: ScoringData, rig: StereoRig, matcher: AbstractMatcher, pairs: Sequence[Pair], ranges: Sequence[Range]
) -> MatchedRanges:
    """The resolved ranges of these pairs, matched under `rig`; those without a sure match are left out."""
    by_frame = [[one for one in ranges if one.pair is pair] for pair in pairs]
    as_taken = [np.array([one.left_pixel for one in some], float).reshape(-1, 2) for some in by_frame]
    pixels = [turned_pixels(some, rig.sizes_taken[0], rig.turns[0]) for some in as_taken]
    partners = host.match_pixels(data, rig, matcher, pixels)
    left = np.concatenate(pixels)
    right = np.concatenate([some.pixels for some in partners])
    every = [one for some in by_frame for one in some]
    rays = np.asarray(rig.left.rays(left))
    along_axis = np.array([one.along == "axis" for one in every], bool)
    slant = np.ones(len(rays))  # metres of a ray per metre given
    np.divide(np.linalg.norm(rays, axis=1), rays[:, 2], out=slant, where=along_axis)
    metres = slant * np.array([one.metres for one in every], float)
    sigma = slant * np.array([0.01 * one.metres if one.sigma is None else one.sigma for one in every], float)
    matching = np.concatenate([some.deviation for some in partners])
    found = np.isfinite(right).all(axis=-1)
    return MatchedRanges(*(part[found] for part in (left, right, metres, sigma, matching)))


def resolved_ranges(ranges: Sequence[Range], recordings: Sequence[tuple[str, Sequence[Pair]]]) -> tuple[Range, ...]:
    """The ranges, each with the pair that it means, of recordings with names and pairs.

    Raises:
        InputError: names a range that belongs to no pair, to several, or to no pixel of it.
    """
    return tuple(_resolved(one, recordings) for one in ranges)


def as_ranges(ranges: Range | Sequence[Range] | None) -> tuple[Range, ...]:
    """One range or several; None: none.

    Raises:
        InputError: if there is something else among them.
    """
    several = (ranges,) if isinstance(ranges, Range) else tuple(() if ranges is None else ranges)
    for one in several:
        if not isinstance(one, Range):
            raise InputError(
                f"a range is a {type(one).__name__}; make it with sr.Range(pair, (column, row), metres, sigma)."
            )
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
        which = f"{len(found)} pairs have that name" if found else "no such pair was given"
        such_as = named[0][0].removeprefix("/")
        numbers = f", or a number from 0 to {len(named) - 1}" if len(recordings) == 1 else ""
        raise InputError(f'a range of pair {what!r}: {which}; name one, such as "{such_as}"{numbers}.')
    (pair,) = found
    taken = turned_size(pair.size, pair.turns[0])
    if not all(0.0 <= at <= length - 1 for at, length in zip(one.left_pixel, taken, strict=True)):
        size = "x".join(map(str, taken))
        raise InputError(f"the range at pixel {one.left_pixel} lies outside of the {size} image.")
    return replace(one, pair=pair)


def with_ranges(free: Parameters, ranges: Sequence[Range], odometer: Odometer | None) -> Parameters:
    """What is free where there are ranges, or distances travelled: the length of the baseline as well."""
    return free.also(BASELINE) if ranges or odometer is not None else free
