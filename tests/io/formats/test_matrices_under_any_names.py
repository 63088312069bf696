"""OpenCV's matrices under other names, nested, in several files and in binary ones: found by shape and side, read the
same in any order, written back in place; two readings are refused with both named."""

import json
import random
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings, strategies as st
from refusals import refused
from scipy.io import savemat

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_rig, save_rig

SIZE = (640, 480)
K1, K2 = (np.array([[500.0 + f, 0, 321 + f], [0, 501 + f, 239 - f], [0, 0, 1]]) for f in (0, 10))
D1, D2 = np.array([-0.3, 0.1, 0.001, -0.002, 0.01]), np.array([-0.31, 0.12, 0.002, -0.001, 0.02])
RVEC, T = np.array([0.01, -0.02, 0.005]), np.array([-0.12, 0.001, 0.002])
R = cv2.Rodrigues(RVEC)[0]
RIG = StereoRig.from_matrices(K1, D1, K2, D2, R, T, SIZE)
USUAL = ("K1", "D1", "K2", "D2", "R", "T")
NAMES = [
    ("M_left", "d_left", "M_right", "d_right", "R", "T"),
    ("kl", "distl", "kr", "distr", "rot", "tvec"),
    ("CameraMatrix0", "DistCoeff0", "CameraMatrix1", "DistCoeff1", "RotationMatrix", "TranslationVector"),
    ("cam0.K", "cam0.D", "cam1.K", "cam1.D", "R_0_1", "t_0_1"),
    ("rightIntr_first", "kc_first", "rightIntr_second", "kc_second", "stereoRotation", "stereoTrans"),
    ("A", "coeffs", "A2", "coeffs2", "r", "t"),
]


def content(names=USUAL, values=(K1, D1, K2, D2, R, T)) -> dict:
    return dict(zip(names, (np.asarray(value).tolist() for value in values), strict=True)) | {"imageSize": [*SIZE]}


def written(path: Path, values: dict) -> Path:
    path.write_text(json.dumps(values) if path.suffix == ".json" else yaml.safe_dump(values))
    return path


def assert_same(found: StereoRig, rig: StereoRig = RIG) -> None:
    np.testing.assert_allclose(found.extrinsics, rig.extrinsics, atol=1e-12)
    for one, other in ((found.left, rig.left), (found.right, rig.right)):
        assert one.size == other.size
        np.testing.assert_array_equal(one.matrix, other.matrix)
        np.testing.assert_array_equal(np.trim_zeros(one.distortion, "b"), np.trim_zeros(other.distortion, "b"))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=24, deadline=None)
@given(
    ending=st.sampled_from([".json", ".yaml"]),
    nested=st.booleans(),
    vector=st.booleans(),
    names=st.sampled_from(NAMES),
    order=st.randoms(use_true_random=False),
)
def test_any_names_in_any_order(tmp_path: Path, ending: str, nested: bool, vector: bool, names, order: random.Random):
    items = list(content(names, (K1, D1, K2, D2, RVEC[:, None] if vector else R, T[:, None])).items())
    order.shuffle(items)
    values = {"version": 3, "stereo": dict(items)} if nested else dict(items)
    path, new = written(tmp_path / f"a{ending}", values), tmp_path / f"b{ending}"
    rig = load_rig(path, unit="m")
    assert_same(rig)
    save_rig(rig, new, overwrite=True)
    assert new.read_bytes() == path.read_bytes()
    moved = rig.with_extrinsics(rig.extrinsics + 0.01)
    save_rig(moved, new, overwrite=True)
    assert_same(load_rig(new, unit="m"), moved)
    again = yaml.safe_load(new.read_text())
    assert np.shape(again["stereo"][names[4]] if nested else again[names[4]]) == ((3, 1) if vector else (3, 3))


@pytest.mark.parametrize("kind", [".xml", ".npy", ".txt"])
def test_a_file_for_each_matrix(tmp_path: Path, kind: str):
    names = ("left_intrinsics", "left_distorted", "right_intrinsics", "right_distorted", "R", "T")
    for name, value in zip(names, (K1, D1, K2, D2, RVEC, T), strict=True):
        path = tmp_path / f"{name}{kind}"
        if kind == ".xml":
            storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
            storage.write("matrix", value)
            storage.release()
        elif kind == ".npy":
            np.save(path, value)
        else:
            np.savetxt(path, value)
    rig = load_rig(tmp_path, unit="m", size=SIZE)
    assert_same(load_rig(sorted(tmp_path.iterdir()), unit="m", size=SIZE))
    assert_same(rig)
    refused(lambda: save_rig(rig, tmp_path / "new.yaml"), "6 files, as it was read")
    save_rig(rig, tmp_path / "new.json", format="stereorecal")
    assert_same(load_rig(tmp_path / "new.json"))


@pytest.mark.parametrize("kind", [".npz", ".mat"])
def test_binary_files(tmp_path: Path, kind: str):
    path, corners = tmp_path / f"a{kind}", np.empty(2, object)
    corners[0], corners[1] = np.zeros((3, 2)), np.zeros((2, 2))
    values = dict(zip(NAMES[0], (K1, D1[None], K2, D2[None], R, T[:, None]), strict=True))
    save = np.savez if kind == ".npz" else lambda place, **named: savemat(place, named)
    save(path, **values, size=np.array(SIZE), corners=corners, remap=np.zeros((48, 64)), rms=0.3)
    rig = load_rig(path, unit="m")
    assert_same(rig)
    refused(lambda: save_rig(rig, path, overwrite=True), "the ending contradicts what is to be written")
    save_rig(rig, tmp_path / "b.json")
    assert_same(load_rig(tmp_path / "b.json", unit="m"))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"PK\x03\x04 and nothing", "truncated"),
        (b"\x93NUMPY\x01\x00", "truncated"),
        (b"\x80\x04K\x01.", "a pickle, which is not opened, since it can run code"),
        (b"\x89HDF\r\n", "save it with '-v7'"),
        (b"MATLAB 5.0 MAT-file" + b" " * 200, "truncated"),
    ],
)
def test_binary_files_that_are_damaged_or_run_code(tmp_path: Path, data: bytes, words: str):
    path = tmp_path / "a.npz"
    path.write_bytes(data)
    refused(lambda: load_rig(path), words)


def test_objects_in_npz_are_not_run(tmp_path: Path):
    np.savez(tmp_path / "a.npz", a=np.array([{"K": 1}], object))
    refused(lambda: load_rig(tmp_path / "a.npz"), "no arrays of a camera")


EYE = np.eye(3).tolist()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"N1": K2.tolist(), "N2": K1.tolist()}, "the camera matrices may be A_1 and A_2 or N1 and N2"),
        ({"rvec": None, "R": None, "R_a": R.tolist(), "rot": EYE}, "the rotation may be R_a or rot"),
        ({"T": None, "tvec": [-1, 0, 0], "trans": T.tolist()}, "the translation may be trans or tvec"),
        (
            {"imageSize": None, "raw_size": [640, 480], "cam_size": [320, 240]},
            "the image size may be cam_size 320x240 or raw_size 640x480",
        ),
        (
            {"A_1": None, "A_2": None, "A_x": K1.tolist(), "A_y": K2.tolist()},
            "no camera matrices (K1 or M1, K2 or M2) are found among A_x (3x3)",
        ),
        ({"R": None, "T": None, "pose": np.eye(4).tolist()}, "no rotation and translation (R, T) are found among"),
        ({"xi_1": 1.2, "xi_2": 1.1}, "xi is a lens of cv2.omnidir"),
        ({"R": None, "R_imu": EYE}, "the key 'R' is missing"),
        ({"R": [20.0, 1.0, 2.0]}, "no rotation vector in radians"),
        ({"imageSize": None, "board_size": [90, 60]}, "the file has no image size"),
    ],
)
def test_two_readings_are_named(tmp_path: Path, change: dict, words: str):
    values = content(("A_1", "D_1", "A_2", "D_2", "R", "T")) | change
    path = written(tmp_path / "a.yaml", {key: value for key, value in values.items() if value is not None})
    kind = UnsupportedModelError if "omnidir" in words else InputError
    refused(lambda: load_rig(path, unit="m"), words, kind=kind)


def test_matrices_of_rectified_images_are_not_taken(tmp_path: Path):
    new = {"A_1_new": K2.tolist(), "A_2_new": K1.tolist(), "R_1": EYE, "R_2": EYE, "T_imu": [1.0, 2.0, 3.0]}
    assert_same(load_rig(written(tmp_path / "a.yaml", content(("A_1", "D_1", "A_2", "D_2", "R", "T")) | new), unit="m"))


def test_extrinsics_that_rectification_implies(tmp_path: Path):
    R1, R2, P1, P2, *_ = cv2.stereoRectify(K1, D1, K2, D2, SIZE, R, T[:, None], alpha=0)
    values = {"LEFT.K": K1, "LEFT.D": D1, "LEFT.R": R1, "LEFT.P": P1, "RIGHT.K": K2, "RIGHT.D": D2, "RIGHT.R": R2,
              "RIGHT.P": P2}  # fmt: skip
    path, new = tmp_path / "a.json", tmp_path / "b.json"
    written(path, {key: value.tolist() for key, value in values.items()} | {"LEFT.width": 640, "LEFT.height": 480})
    rig = load_rig(path, unit="m")
    assert_same(rig)
    moved = rig.with_extrinsics(rig.extrinsics * 1.01)
    save_rig(moved, new)
    assert_same(load_rig(new, unit="m"), moved)


# --- camera matrices a little off ---------------------------------------------------------------------------


def lists(matrix) -> list:
    return np.asarray(matrix).tolist()


@pytest.mark.parametrize(
    "change",
    [
        {"K1": lists(K1 - np.diag([0, 0, 1e-7]))},
        {"K1": lists(K1 + np.array([[0, 1e-5, 0], [0, 0, 0], [0, 1e-8, 0]]))},
        {"K1": lists(np.c_[K1, np.zeros(3)]), "K2": lists(np.c_[K2, np.zeros(3)])},
        {"R": lists(np.round(R, 4))},
    ],
)
def test_matrices_a_little_off_are_read(tmp_path: Path, change: dict):
    path, new = written(tmp_path / "a.json", content() | change), tmp_path / "b.json"
    rig = load_rig(path, unit="m")
    np.testing.assert_allclose(rig.extrinsics, RIG.extrinsics, atol=1e-4)
    np.testing.assert_array_equal(rig.left.matrix, K1)
    wider = StereoRig(Camera(SIZE, K1 + np.diag([1, 1, 0]), D1), rig.right, rig.extrinsics, source=rig.source)
    save_rig(wider, new)
    assert_same(load_rig(new, unit="m"), wider)
    assert np.shape(json.loads(new.read_text())["K1"]) == np.shape((content() | change)["K1"])


def test_one_and_two_coefficients_are_radial(tmp_path: Path):
    path = written(tmp_path / "a.json", content() | {"D1": [-0.3], "D2": [-0.3, 0.1]})
    rig = load_rig(path, unit="m")
    np.testing.assert_array_equal(rig.left.distortion, [-0.3, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(rig.right.distortion, [-0.3, 0.1, 0.0, 0.0])
    written(path, content() | {"D1": [-0.3, 0.1, 0.01]})
    refused(lambda: load_rig(path, unit="m"), "k1 k2 k3 or k1 k2 p1", kind=UnsupportedModelError)


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (K1.T, "the camera matrix is transposed"),
        (2 * K1, "the last number of the camera matrix is 2, and must be 1"),
        (K1 + np.array([[0, 3.0, 0], [0, 0, 0], [0, 0, 0]]), "has skew"),
        (np.c_[K1, [-60.0, 0.0, 0.0]], "is the projection matrix of rectified images"),
        (-K1, "singular or negative"),
    ],
)
def test_matrices_that_are_none_are_refused_by_name(tmp_path: Path, matrix, words: str):
    refused(lambda: load_rig(written(tmp_path / "a.json", content() | {"K1": lists(matrix)}), unit="m"), words)
    if np.shape(matrix) == (3, 3):
        refused(lambda: Camera(SIZE, matrix), words)


def test_a_bracket_without_space_is_opencv_too(tmp_path: Path):
    text = yaml.safe_dump(content(), default_flow_style=None).replace("T: [", "T:[")
    path, new = tmp_path / "a.yaml", tmp_path / "b.yaml"
    path.write_text(text)
    rig = load_rig(path, unit="m")
    assert_same(rig)
    save_rig(rig, new)
    assert new.read_text() == text
    moved = rig.with_extrinsics(rig.extrinsics * 1.01)
    save_rig(moved, new, overwrite=True)
    assert_same(load_rig(new, unit="m"), moved)


# --- forms of others ----------------------------------------------------------------------------------------


def test_a_folder_of_arrays_with_rectification_and_maps_beside(tmp_path: Path):
    """As the Python package StereoVision writes it."""
    R1, R2, P1, P2, Q, *_ = cv2.stereoRectify(K1, D1, K2, D2, SIZE, R, T[:, None])
    values = {"rot_mat": R, "trans_vec": T[:, None], "e_mat": K1 @ R, "f_mat": K1 / 3, "disp_to_depth_mat": Q}
    sides = {"cam_mats": (K1, K2), "dist_coefs": (D1[None], D2[None]), "rect_trans": (R1, R2), "proj_mats": (P1, P2),
             "valid_boxes": ((1, 2, 630, 470), (3, 4, 620, 460)), "undistortion_map": (np.zeros((48, 64)),) * 2,
             "rectification_map": (np.zeros((48, 64)),) * 2}  # fmt: skip
    values |= {f"{key}_{side}": pair[i] for key, pair in sides.items() for i, side in enumerate(("left", "right"))}
    for name, value in values.items():
        np.save(tmp_path / f"{name}.npy", value)
    assert_same(load_rig(tmp_path, unit="m", size=SIZE))


def test_results_of_bouguets_toolbox(tmp_path: Path):
    path, three = tmp_path / "Calib_Results_stereo.mat", np.ones((3, 1))
    values = {"KK_left": K1, "KK_right": K2, "kc_left": D1[:, None], "kc_right": D2[:, None], "om": RVEC[:, None]}
    values |= {"R": R, "T": 1000 * T[:, None], "kc_left_error": D2[:, None], "kc_right_error": D1[:, None]}
    values |= {"om_error": three, "T_error": three, "omc_left_1": three, "Tc_left_1": three, "Rc_left_1": R.T}
    savemat(path, values | {"fc_left": [[500.0], [501.0]], "nx": 640.0, "X_left_1": np.zeros((3, 54))})
    np.testing.assert_allclose(load_rig(path, unit="mm", size=SIZE).extrinsics, RIG.extrinsics, atol=1e-12)


@pytest.mark.parametrize("name", ["roi", "validRoi", "validROI", "validPixROI"])
def test_regions_follow_under_each_of_their_names(tmp_path: Path, name: str):
    path = written(tmp_path / "a.json", content() | {f"{name}{side}": [1, 2, 3, 4] for side in (1, 2)})
    rig = load_rig(path, unit="m")
    save_rig(rig.with_extrinsics(rig.extrinsics + 0.01), tmp_path / "b.json")
    found = json.loads((tmp_path / "b.json").read_text())
    seen = cv2.stereoRectify(K1, D1, K2, D2, SIZE, np.array(found["R"]), np.array(found["T"]).reshape(3, 1), alpha=1.0)[
        5:
    ]
    assert [found[f"{name}1"], found[f"{name}2"]] == [list(region) for region in seen]
