"""What a calibration leaves of the yaw, by depth and by rows: intrinsics that are wrong bend rows like a keystone, as a
yaw does, which is none."""

import numpy as np

from stereorecal.estimation import as_prior, consequences, is_exact, rig_parameters
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS
from stereorecal.online._config import Config

_ROWS_AT, _DEPTH_AT = 10, 30  # baselines
_SHIFTS = np.array([index for index, name in enumerate(EXTRINSICS) if name != "yaw"])
_YAW = EXTRINSICS.index("yaw")


def left_of_yaw(rig: StereoRig, config: Config, view: View | None = None) -> tuple[float, float] | None:
    """Standard deviations in degrees of the yaw with which depth is right, and of that with which rows lie straight
    less that; the mean over the calibrations that are thought possible. None if the intrinsics are right.

    Args:
        view: the view in which rows and depth are read; default the rig's own.
    """
    if is_exact(config.prior):
        return None
    chart = rig_parameters(rig)
    consequences_at_rig = consequences(chart, np.zeros(chart.dim), (_ROWS_AT, _DEPTH_AT), view)
    rows, depth, own = consequences_at_rig.rows[0], consequences_at_rig.mean_nearness[1], len(EXTRINSICS)
    by_rows = np.linalg.lstsq(rows[:, :own], rows, rcond=None)[0]  # (5, n)
    by_depth = (depth - depth[_SHIFTS] @ by_rows[_SHIFTS]) / depth[_YAW]
    prior = as_prior(config.prior, chart)
    both = np.stack([by_depth, by_rows[_YAW] - by_depth])
    yaw, keystone = prior.weights @ np.linalg.norm(both @ prior.roots, axis=-1)
    return float(yaw), float(keystone)
