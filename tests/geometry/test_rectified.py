"""R1 R2 P1 P2 Q and maps, against OpenCV in the same view."""

from functools import partial

import cv2
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import View

SIZE = (160, 120)
K1 = np.array([[150.0, 0, 79.5], [0, 149.0, 60.5], [0, 0, 1]])
K2 = np.array([[151.0, 0, 81.0], [0, 150.5, 58.5], [0, 0, 1]])
D = np.array([-0.2, 0.05, 0.001, -0.0005, 0.0])
R = cv2.Rodrigues(np.array([0.01, -0.02, 0.015]))[0]
T = np.array([[-0.12], [0.002], [-0.003]])
RIG = sr.StereoRig.from_matrices(K1, None, K1, None, np.eye(3), T, SIZE)
MADE = sr.rectification(RIG)


def test_from_matrices():
    rig = sr.StereoRig.from_matrices(K1, D[None], K2, None, R, T, SIZE)
    np.testing.assert_allclose(rig.R, R, atol=1e-12)
    np.testing.assert_array_equal(rig.T, T[:, 0])
    np.testing.assert_array_equal(rig.left.distortion, D)
    assert rig.right.distortion.size == 0
    for bad in ((R, T[:2]), (2 * R, T), (R, -T)):
        with pytest.raises(sr.InputError):
            sr.StereoRig.from_matrices(K1, D, K2, D, *bad, SIZE)


def test_the_unit_of_from_matrices(recwarn: pytest.WarningsRecorder):
    in_metres = sr.StereoRig.from_matrices(K1, D, K2, D, R, T, SIZE)
    in_millimetres = sr.StereoRig.from_matrices(K1, D, K2, D, R, T * 1000, SIZE, unit="mm")
    np.testing.assert_allclose(in_millimetres.T, in_metres.T, rtol=1e-15)
    assert not recwarn.list
    for scale, unit, said in ((1000.0, "m", "120 m long; .* in metres"), (1.0, "mm", "0.00012 m long; .* in millimet")):
        with pytest.warns(sr.CalibrationWarning, match=said) as warned:
            rig = sr.StereoRig.from_matrices(K1, D, K2, D, R, T * scale, SIZE, unit=unit)
        assert len(warned) == 1
        rig.with_extrinsics(rig.extrinsics * 2)
    assert not recwarn.list  # a rig that exists is not doubted again


def test_matrices_in_another_order():
    with pytest.raises(sr.InputError, match=r"K1 has the shape \(1, 5\).* K1, D1, K2, D2, R, T, size in this order"):
        sr.StereoRig.from_matrices(D[None], K1, D[None], K2, R, T, SIZE)
    with pytest.raises(sr.InputError, match="unknown unit 'km'"):
        sr.StereoRig.from_matrices(K1, D, K2, D, R, T, SIZE, unit="km")


@pytest.mark.parametrize("flags", [cv2.CALIB_ZERO_DISPARITY, 0])
def test_as_opencv(flags: int):
    rig = sr.StereoRig.from_matrices(K1, D, K2, D, R, T, SIZE)
    R1, R2, P1, P2, Q, _, _ = cv2.stereoRectify(K1, D, K2, D, SIZE, R, T, flags=flags, alpha=0.0)
    made = sr.rectification(rig, View(SIZE, P1[0, 0], P1[0, 2], P2[0, 2], P1[1, 2]))
    for ours, theirs in ((made.R1, R1), (made.R2, R2), (made.P1, P1), (made.P2, P2), (made.Q, Q)):
        np.testing.assert_allclose(ours, theirs, atol=1e-6)
    for (x, y), K, rotation, projection in ((made.maps[0], K1, R1, P1), (made.maps[1], K2, R2, P2)):
        expected = cv2.initUndistortRectifyMap(K, D, rotation, projection, SIZE, cv2.CV_32FC1)
        np.testing.assert_allclose(x, expected[0], atol=0.01)
        np.testing.assert_allclose(y, expected[1], atol=0.01)
    disparity = np.random.default_rng(0).uniform(5.0, 30.0, SIZE[::-1]).astype(np.float32)
    disparity[0, 0] = np.nan
    points = cv2.reprojectImageTo3D(disparity, Q)
    np.testing.assert_allclose(made.depth(disparity), points[..., 2], rtol=1e-5)
    np.testing.assert_allclose(made.points(disparity), points @ R1, rtol=1e-4, atol=1e-5)


def test_depth_where_there_is_none():
    depth = MADE.depth(np.array([0.0, -1.0, np.nan, 10.0]))
    np.testing.assert_array_equal(depth[:2], np.inf)
    assert np.isnan(depth[2])
    assert depth[3] > 0
    assert np.isnan(MADE.points(np.zeros(SIZE[::-1]))).all()


def test_of_a_disparity_what_is_not_valid_is_nowhere():
    values = np.full(SIZE[::-1], 10.0, np.float32)
    valid = np.arange(values.size).reshape(values.shape) % 2 == 0
    found = sr.Disparity(values, valid)
    for read in (MADE.depth, MADE.points):
        np.testing.assert_array_equal(read(found)[valid], read(values)[valid])
        assert np.isnan(read(found)[~valid]).all()


@pytest.mark.usefixtures("unchecked")
def test_what_is_no_rig_is_said_and_where_it_is():
    stepped = sr.online.init(RIG)
    save = partial(sr.io.save_rig, path="a.json")
    for ask in (sr.rectification, sr.view, partial(sr.difference, RIG), save):
        with pytest.raises(sr.InputError, match=r"is a State; give its \.rig, or an sr\.StereoRig"):
            ask(stepped)
        with pytest.raises(sr.InputError, match=r"is a NoneType; give an sr\.StereoRig"):
            ask(None)


@pytest.mark.usefixtures("unchecked")
def test_a_rotation_vector_is_no_matrix():
    with pytest.raises(sr.InputError, match=r"cv2\.Rodrigues"):
        sr.StereoRig.from_rotation(RIG.left, RIG.right, np.zeros(3), RIG.translation)


def test_disparities_that_are_none():
    sixteenths = np.full(SIZE[::-1], 160, np.int16)
    for find in (MADE.depth, MADE.points):
        with pytest.raises(sr.InputError, match="sixteenths of a pixel"):
            find(sixteenths)
    with pytest.raises(sr.InputError, match=r"the shape \(160, 120\), and the rectified images \(120, 160\)"):
        MADE.points(np.ones(SIZE))
