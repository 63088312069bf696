"""What the filter knows of the rig, as the decision takes it: an estimate around the calibration in use."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import Estimate, Posterior, consequences, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._filter import KEYSTONE, SIZE, FilterEstimate
from stereorecal.online._state import rig_with

_YAW, _DEPTH_AT = EXTRINSICS.index("yaw"), (30,)  # baselines
_UNDOES = "right.cx"


def known(initial: StereoRig, using: tuple[float, ...], filtered: FilterEstimate, view: View) -> Estimate:
    """The posterior of the rig, as changes of the calibration in use.

    Args:
        initial: the rig that was given first.
        using: offset of the calibration in use.
        filtered: the filter's estimate.
        view: in which rows and depth are judged.
    """
    chart, keystone = _around(initial, using, view)
    numbers = [*range(SIZE), KEYSTONE]
    ways = np.column_stack([np.eye(chart.dim)[:, :SIZE], keystone])
    true = rig_with(initial, filtered.offset)
    mean = chart.coordinates(np.asarray(true.extrinsics, float)) + filtered.keystone * keystone
    covariance = ways @ filtered.covariance[np.ix_(numbers, numbers)] @ ways.T
    posterior = Posterior(np.ones(1), mean[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 0, float("nan"), np.diag(covariance), view=view)


@lru_cache(maxsize=2)  # the same until another calibration is in use
def _around(initial: StereoRig, using: tuple[float, ...], view: View) -> tuple[RigChart, Float[np.ndarray, "n"]]:
    """Changes of the calibration in use; and a degree of keystone in their units, a yaw of rows that is none of depth:
    a yaw, and the principal point that undoes it in depth."""
    chart = rig_parameters(rig_with(initial, np.array(using)))
    near = consequences(chart, np.zeros(chart.dim), _DEPTH_AT, view).nearness[0, 0]  # over the view
    principal_point, way = chart.names.index(_UNDOES), np.zeros(chart.dim)
    way[_YAW], way[principal_point] = 1.0, -near[_YAW] / near[principal_point]
    return chart, way
