"""What a wrong calibration does to depth, against formulas and against triangulation by OpenCV."""

import cv2
import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from stereorecal.geometry import Camera, StereoRig
from stereorecal.recalibration import DISTANCES, depth_errors

CAMERA = Camera((640, 480), np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]))


def rig(pitch=0.0, yaw=0.0, roll=0.0, x=-0.4, y=0.0, z=0.0) -> StereoRig:
    return StereoRig(CAMERA, CAMERA, np.array([*np.radians([pitch, yaw, roll]), x, y, z]))


angle, part = st.floats(-3, 3), st.floats(-0.02, 0.02)
rigs = st.builds(rig, angle, angle, angle, st.floats(-2, -0.05), part, part)


@given(st.floats(-2.0, 1.5))
@example(0.0)
@example(-2.0)
@example(0.2)
@example(-0.2)
def test_yaw(degrees):
    """The right camera believed to look more to the left than it does moves every disparity by the same: things are too
    near, or too far and at last beyond infinity."""
    error = np.radians(degrees)
    assert tuple(depth_errors(rig(yaw=degrees), rig())) == DISTANCES == (5, 10, 30, 100)
    for distance, percent in depth_errors(rig(yaw=degrees), rig()).items():
        expected = 100 * (1 / (np.cos(error) + distance * np.sin(error)) - 1)
        assert percent == pytest.approx(expected if np.cos(error) + distance * np.sin(error) > 0 else np.inf)
        # In the words of a stereo user: Z = f B / d, and d is off by f tan(error).
        if abs(degrees) < 0.3 and distance <= 10:
            assert percent == pytest.approx(100 * (1 / (1 + distance * np.tan(error)) - 1), abs=0.2)


@given(rigs, st.floats(0.5, 3.0))
def test_a_longer_baseline_scales_depth(given_rig, factor):
    """Distances are those of the right rig, in its baselines."""
    used = given_rig.with_extrinsics(given_rig.extrinsics * [1, 1, 1, factor, factor, factor])
    np.testing.assert_allclose(list(depth_errors(used, given_rig).values()), 100 * (factor - 1), rtol=1e-5, atol=1e-6)


@given(st.tuples(*[st.floats(-0.1, 0.1)] * 3))
def test_triangulation_by_opencv(degrees):
    """Any small rotation, at five baselines. OpenCV's linear method minimises another error: equal to first order."""
    better, used = rig(0.3, -0.2, 0.1, y=0.002, z=-0.003), rig(0.3, -0.2, 0.1, y=0.002, z=-0.003)
    used = used.with_extrinsics(used.extrinsics + np.array([*np.radians(degrees), 0, 0, 0]))
    point = np.array([0, 0, 5 * better.baseline])
    seen = better.rotation @ point + better.translation
    poses = [np.eye(3, 4), np.column_stack([used.rotation, used.translation])]
    found = cv2.triangulatePoints(*poses, np.zeros((2, 1)), (seen[:2] / seen[2])[:, None])[:, 0]
    expected = 100 * (found[2] / found[3] / point[2] - 1)
    assert depth_errors(used, better)[5] == pytest.approx(expected, abs=0.05)
