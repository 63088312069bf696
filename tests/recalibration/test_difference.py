"""What one calibration changes against another: invariants, and rows against OpenCV's projection."""

import cv2
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import Difference, InputError, difference
from stereorecal.geometry import Camera, StereoRig, axis_errors, view
from stereorecal.recalibration import ROW_DISTANCES

MATRIX = np.array([[500.0, 0, 322], [0, 505.0, 237], [0, 0, 1]])
LENS = np.array([-0.21, 0.06, 0.001, -0.002, 0.01])
BAND = {"pitch": 0.7, "yaw": -0.4, "roll": 0.5, "y": 0.002, "z": -0.003}


def camera(focal=1.0, column=0.0, row=0.0, lens=LENS) -> Camera:
    matrix = MATRIX * [[focal], [focal], [1]] + [[0, 0, column], [0, 0, row], [0, 0, 0]]
    return Camera((640, 480), matrix, lens)


LEFT, RIGHT = camera(), camera(1.01, 5.0, -3.0, 0.9 * LENS)


def rig(pitch=0.0, yaw=0.0, roll=0.0, x=-0.4, y=0.0, z=0.0, left=LEFT, right=RIGHT) -> StereoRig:
    return StereoRig(left, right, np.array([*np.radians([pitch, yaw, roll]), x, y, z]))


angle, part = st.floats(-3, 3), st.floats(-0.02, 0.02)
rigs = st.builds(rig, angle, angle, angle, st.floats(-2, -0.05), part, part)


def numbers(found: Difference) -> np.ndarray:
    return np.array([*found.rotation_deg.values(), *found.translation_percent.values()])


@given(rigs)
def test_nothing_between_a_rig_and_itself(given_rig):
    found = difference(given_rig, given_rig)
    assert (numbers(found) == 0).all()
    assert found.baseline_percent == 0.0
    assert found.angle_deg < 1e-9
    assert found.same_intrinsics
    assert found.row_error_worst < 1e-9
    np.testing.assert_allclose(list(found.depth_error_percent.values()), 0.0, atol=1e-6)


@given(rigs, rigs)
def test_there_and_back(one, other):
    there, back = difference(one, other), difference(other, one)
    np.testing.assert_array_equal(numbers(there), -numbers(back))
    assert there.angle_deg == pytest.approx(back.angle_deg, abs=1e-9)
    assert (1 + there.baseline_percent / 100) * (1 + back.baseline_percent / 100) == pytest.approx(1)
    errors = axis_errors(other, one)
    np.testing.assert_allclose(np.abs(numbers(there)), [errors[name] for name in ("pitch", "yaw", "roll", "y", "z")])


def pixels_by_opencv(points: np.ndarray, given_camera: Camera, vector=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    turned = np.array(vector, float), np.array(shift, float)
    return cv2.projectPoints(points, *turned, given_camera.matrix, given_camera.distortion)[0].reshape(-1, 2)


def ideal_by_opencv(pixels: np.ndarray, given_camera: Camera, rotation=None, matrix=None) -> np.ndarray:
    exact = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-12)
    return cv2.undistortPoints(
        pixels[:, None],
        given_camera.matrix,
        given_camera.distortion,
        R=np.eye(3) if rotation is None else rotation,
        P=np.eye(3) if matrix is None else matrix,
        criteria=exact,
    ).reshape(-1, 2)


@pytest.mark.parametrize(
    "better",
    [
        rig(**BAND),
        rig(-0.5, 0.8, 0.1, y=0.004),
        rig(left=camera(1.02, -4.0, 2.0, 1.1 * LENS)),
        rig(**BAND, left=camera(0.99), right=camera(1.0, 3.0, 4.0, LENS[:4])),
    ],
    ids=["axes", "more axes", "left lens", "everything"],
)
def test_rows_by_opencv(better: StereoRig):
    """Pixels of the view, through `used` into the left image, into the world and the right image through `better`, and
    rectified by `used`."""
    used = rig(0.2, 0.3, -0.4, y=-0.003)
    found, seen = difference(used, better), view(used)
    r1, r2, *_ = cv2.stereoRectify(
        used.left.matrix,
        used.left.distortion,
        used.right.matrix,
        used.right.distortion,
        (640, 480),
        used.rotation,
        used.translation.reshape(3, 1),
    )
    x, y = (grid.ravel() for grid in np.meshgrid(found.columns, found.rows))
    rays = np.stack([(x - seen.centre_left) / seen.focal, (y - seen.centre_row) / seen.focal, np.ones_like(x)], 1)
    left = pixels_by_opencv(rays @ r1, used.left)
    world = np.column_stack([ideal_by_opencv(left, better.left), np.ones_like(x)])
    for plane, distance in zip(found.row_differences, ROW_DISTANCES, strict=True):
        points = world * min(distance, 1e9) * better.baseline
        right = pixels_by_opencv(points, better.right, cv2.Rodrigues(better.rotation)[0], better.translation)
        row = ideal_by_opencv(right, used.right, r2, seen.matrix_right)[:, 1]
        inside = ((left >= 0) & (left <= (639, 479)) & (right >= 0) & (right <= (639, 479))).all(axis=1)
        np.testing.assert_array_equal(np.isfinite(plane).ravel(), inside)
        assert 0.5 < inside.mean() < 1.0
        np.testing.assert_allclose(plane.ravel()[inside], (y - row)[inside], atol=1e-6)


def test_rows_in_numbers():
    found = difference(rig(), rig(**BAND))
    assert found.row_differences.shape == (2, len(found.rows), len(found.columns)) == (2, 24, 32)
    assert found.columns[[0, -1]].tolist() == [0, 639]
    assert found.rows[[0, -1]].tolist() == [0, 479]
    assert found.row_map.shape == (24, 32)
    known = np.abs(found.row_differences)
    np.testing.assert_array_equal(np.abs(found.row_map), np.fmax(*known))
    assert found.row_error_worst == np.nanmax(known)
    assert found.row_error_median == np.nanmedian(known)
    assert found.row_error_median < found.row_error_most == np.nanquantile(known, 0.9) < found.row_error_worst
    row, column = np.argwhere(np.abs(found.row_map) == found.row_error_worst)[0]
    assert (
        f"{found.row_error_median:.2f} px (median over the view), within {found.row_error_most:.2f} px in 90 % of it; "
        f"the worst point, ({found.columns[column]:.0f}, {found.rows[row]:.0f}), has {found.row_error_worst:.2f} px"
    ) in str(found)
    # 0.7 degrees of pitch at a focal length of 500 pixels
    assert found.row_error_median == pytest.approx(6.1, abs=1.0)


def test_one_row_of_the_right_camera():
    """Its image one pixel lower: rows one pixel apart, everywhere, and no depth."""
    straight = rig(left=camera(lens=LENS[:0]), right=camera(lens=LENS[:0]))
    lower = rig(left=camera(lens=LENS[:0]), right=camera(row=1.0, lens=LENS[:0]))
    found = difference(straight, lower)
    assert not found.same_intrinsics
    assert (numbers(found) == 0).all()
    scale = view(straight).focal / 505
    seen = np.isfinite(found.row_differences)
    np.testing.assert_allclose(found.row_differences[seen], -scale, atol=1e-6)
    np.testing.assert_allclose(list(found.depth_error_percent.values()), 0.0, atol=0.2)


def test_one_column_of_the_right_camera():
    """Its image one pixel to the right: disparities one pixel smaller."""
    straight = rig(left=camera(lens=LENS[:0]), right=camera(lens=LENS[:0]))
    found = difference(straight, rig(left=camera(lens=LENS[:0]), right=camera(column=1.0, lens=LENS[:0])))
    assert found.row_error_worst < 1e-9
    for distance, percent in found.depth_error_percent.items():
        disparity = 500 / distance
        assert percent == pytest.approx(100 / (disparity - 1))


def test_text():
    lines = str(difference(rig(), rig(yaw=0.25, y=0.004))).splitlines()
    assert lines[0] == "rotation  0.250 deg: pitch +0.000, yaw +0.250, roll +0.000"
    assert lines[1] == "baseline  y +1.00 %, z +0.00 %, length +0.0 %"
    assert lines[2].startswith("epipolar  ")
    assert lines[3].startswith("depth     ")
    assert [part.rpartition(" at ")[2] for part in lines[3].split(", ")] == ["2 m", "4 m", "12 m", "40 m"]
    assert len(lines) == 4
    assert str(difference(rig(), rig(left=RIGHT))).splitlines()[-1] == "cameras   the intrinsics differ too"


def test_nothing_is_seen_by_both():
    text = str(difference(rig(), rig(yaw=120)))
    assert "no point of the view is seen by both cameras" in text
    errors = difference(rig(), rig(yaw=120)).as_dict()["row_error_px"]
    assert errors == {"median": None, "percentile_90": None, "worst": None}


@pytest.mark.parametrize("side", ["left", "right"])
def test_images_of_another_size(side: str):
    smaller = {side: LEFT.resized((320, 240))}
    with pytest.raises(InputError, match=f"{side} images of 640x480 and of 320x240; resize one"):
        difference(rig(), rig(**smaller))
