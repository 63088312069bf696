"""CameraInfo against OpenCV and against the geometry of projected points."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from hypothesis import given, strategies as st
from stereorecal_ros import CameraInfo, corrected, rig_of, view_of
from stereorecal_ros._quaternion import quaternion

from stereorecal import Camera, InputError, StereoRig, UnsupportedModelError
from stereorecal.synthetic import default_rig

LENSES = {
    "plumb_bob": ("radtan", [-0.2, 0.1, 1e-3, -5e-4, 0.01]),
    "rational_polynomial": ("radtan", [0.3, -0.2, 1e-3, 2e-4, 0.02, 0.5, -0.1, 0.01]),
    "equidistant": ("equidistant", [0.02, -0.01, 0.003, -0.001]),
}


def rig_with(model: str, turn=(0.01, -0.02, 0.015)) -> StereoRig:
    kind, lens = LENSES[model]
    cameras = [
        Camera((640, 480), np.array([[focal, 0, 322.0], [0, focal, 236.0], [0, 0, 1]]), np.array(lens), model=kind)
        for focal in (410.0, 405.0)
    ]
    return StereoRig(cameras[0], cameras[1], np.array([*turn, -0.12, 2e-3, -1e-3]))


def message_of(info: CameraInfo, **changes) -> SimpleNamespace:
    """As rclpy has it."""
    whole = {"x_offset": 0, "y_offset": 0, "width": 0, "height": 0}
    content = {**vars(info), "binning_x": 0, "binning_y": 0, "roi": SimpleNamespace(**whole)}
    content |= {name: np.array(content[name]) for name in "krp"}
    return SimpleNamespace(**{**content, **changes})


@pytest.mark.parametrize("model", LENSES)
def test_points_meet_in_one_row_at_their_depth(model: str):
    """By what a user of image_proc does: undistort with K and D, turn by R, project by P."""
    rig = rig_with(model)
    points = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 8], (50, 3))
    seen = [points, points @ np.asarray(rig.rotation).T + np.asarray(rig.translation)]
    rows, columns = [], []
    for info, camera, there in zip(corrected(rig), (rig.left, rig.right), seen, strict=True):
        assert info.distortion_model == model
        pixels = np.asarray(camera.project(there))
        K, R, P, D = (
            np.reshape(info.k, (3, 3)),
            np.reshape(info.r, (3, 3)),
            np.reshape(info.p, (3, 4)),
            np.array(info.d),
        )
        undistort = cv2.fisheye.undistortPoints if model == "equidistant" else cv2.undistortPoints
        found = undistort(pixels[:, None], K, D, R=R, P=P[:, :3].copy())[:, 0]
        columns.append(found[:, 0])
        rows.append(found[:, 1])
    np.testing.assert_allclose(rows[0], rows[1], atol=1e-3)
    left, right = (np.reshape(info.p, (3, 4)) for info in corrected(rig))
    assert left[0, 3] == 0.0
    assert right[0, 3] == pytest.approx(-right[0, 0] * float(rig.baseline))
    depth = -right[0, 3] / (columns[0] - columns[1] - (left[0, 2] - right[0, 2]))
    turned = points @ np.reshape(corrected(rig)[0].r, (3, 3)).T
    np.testing.assert_allclose(depth, turned[:, 2], rtol=1e-4)


def test_rotations_are_opencvs():
    rig = rig_with("plumb_bob")
    left, right = rig.left, rig.right
    R1, R2, *_ = cv2.stereoRectify(
        left.matrix, left.distortion, right.matrix, right.distortion, (640, 480), rig.rotation, rig.translation[:, None]
    )
    for info, rotation in zip(corrected(rig), (R1, R2), strict=True):
        np.testing.assert_allclose(np.reshape(info.r, (3, 3)), rotation, atol=1e-9)


@pytest.mark.parametrize("model", LENSES)
@given(turn=st.tuples(*[st.floats(-0.05, 0.05)] * 3), shift=st.tuples(*[st.floats(-0.02, 0.02)] * 2))
def test_there_and_back(model: str, turn, shift):
    rig = rig_with(model).with_extrinsics(np.array([*turn, -0.12, *shift]))
    infos = corrected(rig)
    again = rig_of(*(CameraInfo.of(message_of(info)) for info in infos))
    np.testing.assert_allclose(again.extrinsics, rig.extrinsics, atol=1e-9)
    assert again.left.model == rig.left.model
    np.testing.assert_array_equal(again.right.matrix, rig.right.matrix)
    shown = view_of(*infos)
    assert shown is not None
    assert all(a.is_like(b) for a, b in zip(corrected(again, shown), infos, strict=True))


def test_the_view_stays_that_of_the_given_calibration():
    """What users have tuned to the rectified images holds on: only R and the baseline change."""
    rig = rig_with("plumb_bob")
    infos = corrected(rig)
    moved = rig.with_extrinsics(rig.extrinsics + np.array([0.005, 0.003, -0.002, 0, 0, 0]))
    for before, after in zip(infos, corrected(moved, view_of(*infos)), strict=True):
        np.testing.assert_allclose(np.reshape(after.p, (3, 4))[:, :3], np.reshape(before.p, (3, 4))[:, :3])
        assert not before.is_like(after)


def test_projections_that_no_view_has():
    left, right = corrected(default_rig())
    for place in (0, 5, 6):
        odd = list(right.p)
        odd[place] *= 1.01
        assert view_of(left, CameraInfo(**{**vars(right), "p": tuple(odd)})) is None


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"k": (0.0,) * 9}, "not calibrated"),
        ({"p": (0.0,) * 12}, "no projection matrix"),
        ({"distortion_model": "ftheta"}, "distortion model 'ftheta' is not supported"),
        ({"d": (0.1, 0.2, 0.3)}, "3 coefficients; this lens model takes others"),
        ({"r": (float("nan"),) * 9}, "NaN"),
        ({"k": (float("nan"),) * 9}, "NaN"),
        ({"width": 0}, "image size"),
    ],
)
def test_what_is_none_is_refused(changes, said):
    left, right = corrected(rig_with("plumb_bob"))
    with pytest.raises(InputError, match=said):
        rig_of(CameraInfo(**{**vars(left), **changes}), right)


def test_exchanged_or_without_baseline():
    left, right = corrected(rig_with("plumb_bob"))
    with pytest.raises(InputError, match="exchanged"):
        rig_of(right, left)
    with pytest.raises(InputError, match="no baseline"):
        rig_of(left, left)


def test_the_whole_fourth_column():
    """Cameras that are placed against a third one, as KITTI's, are read; one above the other is refused."""
    rig, infos = rig_with("plumb_bob"), corrected(rig_with("plumb_bob"))
    common, place = np.array([0.06, 4e-4, 2.7e-3]), np.array([-0.12, 4e-3, 2e-3])

    def placed(info: CameraInfo, t: np.ndarray) -> CameraInfo:
        projection = np.reshape(info.p, (3, 4)).copy()
        projection[:, 3] = projection[:, :3] @ t
        return CameraInfo(**{**vars(info), "p": tuple(projection.ravel().tolist())})

    found = rig_of(placed(infos[0], common), placed(infos[1], common + place))
    np.testing.assert_allclose(found.translation, np.reshape(infos[1].r, (3, 3)).T @ place, atol=1e-9)
    np.testing.assert_allclose(found.rotation, rig.rotation, atol=1e-9)
    with pytest.raises(InputError, match="one camera is above the other"):
        rig_of(infos[0], placed(infos[1], np.array([1e-3, -0.12, 0.0])))


def test_binned_or_cut_images_are_refused():
    info = corrected(rig_with("plumb_bob"))[0]
    cut = SimpleNamespace(x_offset=10, y_offset=0, width=320, height=240)
    whole = SimpleNamespace(x_offset=0, y_offset=0, width=640, height=480)
    for changes in ({"binning_x": 2}, {"roi": cut}):
        with pytest.raises(InputError, match="binned or cut"):
            CameraInfo.of(message_of(info, **changes))
    assert CameraInfo.of(message_of(info, roi=whole, binning_x=1)) == info


def test_lenses_that_ros_does_not_have():
    camera = Camera((640, 480), np.array([[400.0, 0, 320], [0, 400, 240], [0, 0, 1]]), np.array([0.1, 0.6]), model="ds")
    with pytest.raises(UnsupportedModelError, match="no lens of the model 'ds'"):
        corrected(StereoRig(camera, camera, np.array([0, 0, 0, -0.1, 0, 0])))


@given(st.tuples(*[st.floats(-1.5, 1.5)] * 3))
def test_quaternions_turn_as_the_matrix_does(vector):
    matrix = cv2.Rodrigues(np.array(vector))[0]
    x, y, z, w = quaternion(matrix)
    assert x * x + y * y + z * z + w * w == pytest.approx(1.0)
    back = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    np.testing.assert_allclose(back, matrix, atol=1e-9)
