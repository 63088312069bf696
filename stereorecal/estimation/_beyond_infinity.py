"""Nothing lies beyond infinity: what the farthest matches tell of the yaw, of which epipolar errors tell little."""

import numpy as np

from stereorecal.estimation._consequences import consequences, signed_nearness
from stereorecal.estimation._groups import Groups
from stereorecal.estimation._mixture import Mixture
from stereorecal.geometry import View, reread
from stereorecal.objectives import RigChart

_FARTHEST = 0.05  # of the matches: so many are not all false
_WRONG = 0.5  # pixels of disparity that these may be off, and once more as a standard deviation
_AWAY = 100.0  # baselines: how disparities follow a rig hardly depends on the distance there


def nothing_beyond_infinity(posterior: Mixture, groups: Groups, chart: RigChart, view: View | None) -> Mixture:
    """The posterior of a rig, where the farthest of what groups show is known to lie no farther than at infinity."""
    theta, count = posterior.mean, groups.count.astype(float)
    rig = chart.rig_at(theta)
    left, right = (
        reread(rays / rays[:, 2:], getattr(chart.rig, side), getattr(rig, side))
        for side, rays in (("left", groups.left), ("right", groups.right))
    )
    nearness = signed_nearness(rig, left, right, view)
    order = np.argsort(nearness)
    some = order[: 1 + int(np.searchsorted(np.cumsum(count[order]), _FARTHEST * count.sum()))]
    weights = count[some] / count[some].sum()
    points = left[some] * (_AWAY * float(rig.baseline))
    (relative,) = consequences(chart, theta, (), view, [points]).nearness
    farthest, slopes = groups.focal * (weights @ nearness[some]), groups.focal * (weights @ relative) / _AWAY
    return posterior.not_negative(float(farthest) + _WRONG, slopes, _WRONG)
