"""The length of the baseline alone, from ranges."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal._arrays import refuse_tracers
from stereorecal._errors import InputError
from stereorecal.estimation import MatchedRanges
from stereorecal.geometry import StereoRig, checked_rig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, Reach, row_chart
from stereorecal.recalibration._match_ranges import match_ranges, resolved_ranges
from stereorecal.recalibration._schedule import finest_scale
from stereorecal.recalibration._uncertainty import NORMAL_95
from stereorecal.recordings import Pairs, Range
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import with_measured_range

_ROUNDS = 8
# Degrees: what repairs leave of yaw, which ranges see too. Single ones of real rigs scatter by 0.02 to 0.09 degrees
# between recordings, several together by half of that (docs/accuracy.md).
_YAW = 0.05
_LONGER = 10.0  # percent: standard deviation of the length, far wider than any drift: the ranges decide


@dataclass(frozen=True, eq=False)
class Rescaled:
    """A rig with another length of its baseline.

    Attributes:
        rig: the same rotation and direction of the baseline.
        change: of the length, percent.
        interval: half width of its 95 % interval, percent.
        used: how many ranges had a sure match and did not contradict the others.
    """

    rig: StereoRig
    change: float
    interval: float
    used: int


def rescale_baseline(
    rig: StereoRig,
    pairs: Pairs,
    ranges: Sequence[Range],
    *,
    matcher: AbstractMatcher | str | None = None,
    yaw_sigma: float = _YAW,
) -> Rescaled:
    """The length of the baseline under which depths agree with ranges; everything else is held (paper, section 3.3:
    images alone cannot tell it). A rig that has drifted is repaired first.

    Args:
        rig, pairs, matcher: as `recalibrate` has them.
        ranges: near ones and far ones: only together they tell a longer baseline from a wrong yaw.
        yaw_sigma: standard deviation of what the repair left of yaw, in degrees: the interval admits it.

    Raises:
        InputError: if images and calibration do not fit, no range has a match, fewer than half agree with one length,
            or yaw_sigma is not positive.
    """
    refuse_tracers("sr.rescale_baseline", "it before tracing", rig)
    rig = checked_rig(rig)
    images = pyramid(rig, pairs)
    ranges = resolved_ranges(ranges, [("", images.pairs)])
    data = images.at(finest_scale(rig.left.size))
    found = match_ranges(data, rig, with_measured_range(matcher, images), images.pairs, ranges)
    if not found:
        raise InputError(
            "no range lies on a pixel with a reliable match; give some on surfaces with texture, off edges."
        )
    change, deviation, used = _solved_baseline(found, rig, yaw_sigma)
    if 2 * used < len(found.metres):
        raise InputError(
            f"only {used} of {len(found.metres)} matched ranges agree with one length of the baseline; check their "
            "unit, and whether they are along the ray or along the axis."
        )
    extrinsics = np.array(rig.extrinsics, float)
    extrinsics[3:] *= 1.0 + change / 100.0
    return Rescaled(rig.with_extrinsics(extrinsics), change, NORMAL_95 * deviation, used)


def _solved_baseline(found: MatchedRanges, rig: StereoRig, yaw_sigma: float) -> tuple[float, float, int]:
    """The change of the length and its standard deviation, in percent, and how many ranges agree with it. Yaw is solved
    for beside it, and left as it was: rows know it better."""
    chart = row_chart(rig, Reach(), Parameters(("yaw", BASELINE), {"yaw": yaw_sigma, BASELINE: _LONGER}))
    z, covariance = np.zeros(2), chart.prior**2 * np.eye(2)
    for _ in range(_ROUNDS):
        normal = found.normal(chart, z)
        covariance = np.linalg.inv(normal.a + np.eye(2) / chart.prior**2)
        z = covariance @ normal.b
    unit, used = float(chart.units[1]), ~found.contradict(chart.rig_at(z))
    return unit * float(z[1]), unit * float(np.sqrt(covariance[1, 1])), int(used.sum())
