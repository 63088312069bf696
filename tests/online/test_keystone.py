"""What a calibration leaves of the yaw: more by rows than by depth, and nothing where the intrinsics are right."""

import numpy as np

import stereorecal as sr
from stereorecal.estimation import rig_parameters
from stereorecal.online import Config
from stereorecal.online._keystone import left_of_yaw


def test_boards_leave_rows_bent_and_depth_right():
    rig = sr.synthetic.default_rig()
    left = left_of_yaw(rig, Config())
    assert left is not None
    yaw, keystone = left
    assert 0.01 < yaw < 0.1 < keystone < 0.6
    assert left_of_yaw(rig, Config(prior="exact")) is None


def test_it_does_not_depend_on_where_the_rig_has_turned():
    rig = sr.synthetic.default_rig()
    chart = rig_parameters(rig)
    turned = chart.rig_at(np.r_[0.3, -0.4, 0.2, 0.0, 0.0, np.zeros(chart.dim - 5)])
    np.testing.assert_allclose(left_of_yaw(turned, Config()), left_of_yaw(rig, Config()), rtol=0.2)
