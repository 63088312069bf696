"""What a calibration leaves of the yaw: more by rows than by depth, and nothing where the intrinsics are right."""

import numpy as np

import stereorecal as sr
from stereorecal.estimation import rig_parameters
from stereorecal.online import Config, init


def left_of_yaw(rig: sr.StereoRig, config: Config) -> tuple[float, float]:
    """Standard deviations at the start: of the yaw by depth, and of what bends rows as a yaw does."""
    spread = np.sqrt(np.diag(init(rig, config).estimate.covariance))
    return spread[1], spread[9]


def test_boards_leave_rows_bent_and_depth_right():
    rig = sr.synthetic.default_rig()
    yaw, keystone = left_of_yaw(rig, Config())
    assert 0.01 < yaw < 0.1 < keystone < 0.6
    drift, none = left_of_yaw(rig, Config(prior="exact"))
    assert none == 0.0
    assert drift > yaw  # that a rig of this kind has turned, nothing else shows


def test_it_does_not_depend_on_where_the_rig_has_turned():
    rig = sr.synthetic.default_rig()
    chart = rig_parameters(rig)
    turned = chart.rig_at(np.r_[0.3, -0.4, 0.2, 0.0, 0.0, np.zeros(chart.dim - 5)])
    np.testing.assert_allclose(left_of_yaw(turned, Config()), left_of_yaw(rig, Config()), rtol=0.2)
