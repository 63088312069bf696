"""The length of the baseline alone, from ranges."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal._arrays import refuse_tracers
from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, Reach, row_chart
from stereorecal.recalibration._ranges import beams, resolved_ranges
from stereorecal.recalibration._schedule import finest_scale
from stereorecal.recalibration._uncertainty import NORMAL_95
from stereorecal.recordings import Pairs, Range
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import ranged

_ROUNDS = 8
_YAW = 0.005  # degrees: what a repair leaves of yaw, which the ranges see too
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
    rig: StereoRig, pairs: Pairs, ranges: Sequence[Range], *, matcher: AbstractMatcher | str | None = None
) -> Rescaled:
    """The length of the baseline under which depths agree with ranges; everything else is held (paper, section 3.3:
    images alone cannot tell it). A rig that has drifted is repaired first.

    Raises:
        InputError: if images and calibration do not fit, or no range has a match.
    """
    refuse_tracers("sr.rescale_baseline", "it before tracing", rig)
    images = pyramid(rig, pairs)
    ranges = resolved_ranges(ranges, [("", images.pairs)])
    data = images.at(finest_scale(rig.left.size))
    found = beams(data, rig, ranged(matcher, images), images.pairs, ranges)
    if not len(found.metres):
        raise InputError("no range lies on a pixel with a sure match; give some on surfaces with texture, off edges.")
    chart = row_chart(rig, Reach(), Parameters(("yaw", BASELINE), {"yaw": _YAW, BASELINE: _LONGER}))
    z, normal = np.zeros(2), np.eye(2)
    for _ in range(_ROUNDS):
        normal, pull = found.normal_and_pull(chart, z)
        normal = normal + np.eye(2) / chart.prior**2
        z = z - np.linalg.solve(normal, pull + z / chart.prior**2)
    votes = found.votes(found.residuals(chart.rig_at(z)))
    change = float(chart.units[1] * z[1])
    deviation = float(chart.units[1] * np.sqrt(np.linalg.inv(normal)[1, 1]))
    extrinsics = np.array(rig.extrinsics, float)
    extrinsics[3:] *= 1.0 + change / 100.0
    return Rescaled(rig.with_extrinsics(extrinsics), change, NORMAL_95 * deviation, int((votes > 0.5).sum()))
