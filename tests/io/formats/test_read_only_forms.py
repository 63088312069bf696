"""Forms that are read and not written: MATLAB, mrcal, VINS, ORB-SLAM, FoundationStereo, ost.txt; and unknown ones."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from refusals import refused
from scipy.io import savemat
from test_matrices_under_any_names import D1, D2, K1, K2, RIG, SIZE, R, T, assert_same

from stereorecal import InputError, UnsupportedModelError
from stereorecal.io import load_rig, save_rig, save_template

POSE = np.vstack([np.c_[R, T], [0, 0, 0, 1]])


def opencv(matrix) -> str:
    rows, columns = np.shape(matrix)
    data = ", ".join(map(repr, np.ravel(matrix).tolist()))
    return f"!!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {data} ]"


def mrcal(folder: Path) -> list[Path]:
    paths = []
    reference = np.array([0.1, 0.2, -0.3, 1.0, 2.0, 3.0])
    from_reference = np.vstack([np.c_[cv2.Rodrigues(reference[:3])[0], reference[3:]], [0, 0, 0, 1]])
    right = POSE @ from_reference
    motions = (reference, np.r_[cv2.Rodrigues(right[:3, :3])[0].ravel(), right[:3, 3]])
    for name, K, D, motion in zip(("left", "right"), (K1, K2), (D1, D2), motions, strict=True):
        numbers = ", ".join(map(repr, [K[0, 0], K[1, 1], K[0, 2], K[1, 2], *D.tolist()]))
        text = f"""# made by hand
{{
    'lensmodel': 'LENSMODEL_OPENCV5',
    # f and c, then the lens
    'intrinsics': [ {numbers.replace("np.float64(", "").replace(")", "")},],
    'extrinsics': {motion.tolist()},
    'imagersize': [ 640, 480,],
}}
"""
        paths.append(folder / f"{name}.cameramodel")
        paths[-1].write_text(text)
    return paths


def orb_slam(folder: Path) -> list[Path]:
    lines = ["%YAML:1.0", "", "Camera.type: 'PinHole'", "Camera.width: 640", "Camera.height: 480"]
    for name, K, D in (("Camera1", K1, D1), ("Camera2", K2, D2)):
        values = [*K[[0, 1, 0, 1], [0, 1, 2, 2]], *D]
        named = zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"), values, strict=True)
        lines += [f"{name}.{key}: {float(value)!r}" for key, value in named]
    path = folder / "settings.yaml"
    path.write_text("\n".join([*lines, f"Stereo.T_c1_c2: {opencv(np.linalg.inv(POSE))}", ""]))
    return [path]


def vins(folder: Path) -> list[Path]:
    body = np.vstack([np.c_[cv2.Rodrigues(np.array([1.0, -1.0, 0.5]))[0], [0.1, 0.2, 0.3]], [0, 0, 0, 1]])
    for side, K, D in ((0, K1, D1), (1, K2, D2)):
        lens = dict(zip(("k1", "k2", "p1", "p2"), D[:4].tolist(), strict=True))
        pinhole = dict(zip(("fx", "fy", "cx", "cy"), K[[0, 1, 0, 1], [0, 1, 2, 2]].tolist(), strict=True))
        camera = {"model_type": "PINHOLE", "camera_name": "a", "image_width": 640, "image_height": 480}
        camera |= {"distortion_parameters": lens, "projection_parameters": pinhole}
        (folder / f"cam{side}_pinhole.yaml").write_text("%YAML:1.0\n---\n" + yaml.safe_dump(camera))
    poses = (body, body @ np.linalg.inv(POSE))
    text = "%YAML:1.0\n\nimu: 1\nimage_width: 640\nimage_height: 480\n"
    for side in (0, 1):
        text += f'cam{side}_calib: "cam{side}_pinhole.yaml"\nbody_T_cam{side}: {opencv(poses[side])}\n'
    (folder / "main.yaml").write_text(text)
    return [folder / "main.yaml"]


def struct(unit: str = "millimeters", old: bool = True) -> dict:
    found = {"Version": "1", "TranslationOfCamera2": [], "RotationOfCamera2": []}
    length = {"millimeters": 1000.0, "inches": 1 / 0.0254}[unit]
    for side, zero_based, D in ((1, K1, D1), (2, K2, D2)):
        K = zero_based + np.array([[0, 0, 1.0], [0, 0, 1], [0, 0, 0]])
        camera = {"RadialDistortion": [D[0], D[1], D[4]], "TangentialDistortion": [D[2], D[3]], "WorldUnits": unit}
        camera |= {"ImageSize": [480, 640]} | ({"IntrinsicMatrix": K.T.tolist()} if old else {"K": K.tolist()})
        found[f"CameraParameters{side}"] = camera
    if old:
        return found | {"RotationOfCamera2": R.T.tolist(), "TranslationOfCamera2": (length * T).tolist()}
    del found["RotationOfCamera2"], found["TranslationOfCamera2"]
    return found | {"PoseCamera2": {"R": R.tolist(), "Translation": (length * T).tolist(), "Dimensionality": 3}}


def matlab(folder: Path, **how) -> list[Path]:
    (folder / "a.json").write_text(json.dumps({"stereoParams": struct(**how)}))
    return [folder / "a.json"]


def mat(folder: Path, compressed: bool = False) -> list[Path]:
    cells = np.empty(2, object)
    cells[0], cells[1] = "a.png", {"corners": np.zeros((3, 2))}
    savemat(folder / "a.mat", {"s": struct(), "images": cells}, do_compression=compressed)
    return [folder / "a.mat"]


FORMS = {
    "mrcal": mrcal,
    "orbslam": orb_slam,
    "vins": vins,
    "matlab": matlab,
    "matlab .mat": mat,
    "matlab -v7": lambda folder: mat(folder, compressed=True),
    "matlab new": lambda folder: matlab(folder, old=False),
    "matlab inches": lambda folder: matlab(folder, unit="inches"),
}


@pytest.mark.parametrize("name", FORMS)
def test_forms(tmp_path: Path, name: str):
    paths = FORMS[name](tmp_path)
    rig = load_rig(*paths)
    np.testing.assert_allclose(rig.extrinsics, RIG.extrinsics, atol=1e-9)
    for found, right in ((rig.left, RIG.left), (rig.right, RIG.right)):
        assert found.size == SIZE
        np.testing.assert_allclose(found.matrix, right.matrix, rtol=1e-12)
        count = 4 if name == "vins" else 5
        np.testing.assert_allclose(found.distortion[:count], right.distortion[:count], rtol=1e-12)
    said = f"{name.split()[0]} ("
    refused(lambda: save_rig(rig, tmp_path / "new.json", format=name.split()[0]), said)
    save_rig(rig, tmp_path / "new.json")
    assert_same(load_rig(tmp_path / "new.json"), rig)


@pytest.mark.parametrize(
    ("name", "old", "new", "words", "kind"),
    [
        ("mrcal", "OPENCV5", "SPLINED_STEREOGRAPHIC", "mrcal-convert-lensmodel", UnsupportedModelError),
        ("orbslam", "PinHole", "Sphere", "the camera type 'Sphere' is not supported", UnsupportedModelError),
        ("vins", "cam1_pinhole", "cam7_pinhole", "there is no such file; put it beside the settings", InputError),
        ("vins", "cam1_pinhole", "../../cam7_pinhole", "there is no such file; put it beside the settings", InputError),
        ("matlab", "millimeters", "furlongs", "WorldUnits is 'furlongs'", InputError),
        ("matlab", '"ImageSize": [480, 640]', '"ImageSize": []', "ImageSize is empty", InputError),
    ],
)
def test_refusals(tmp_path: Path, name: str, old: str, new: str, words: str, kind):
    paths = FORMS[name](tmp_path)
    assert old in paths[0].read_text()
    for path in paths:
        path.write_text(path.read_text().replace(old, new))
    refused(lambda: load_rig(*paths), words, kind=kind)


def test_rotations_of_matlab_that_disagree(tmp_path: Path):
    (tmp_path / "a.json").write_text(json.dumps(struct() | {"PoseCamera2": {"A": np.linalg.inv(POSE).tolist()}}))
    refused(lambda: load_rig(tmp_path / "a.json"), "is not the transpose of PoseCamera2's R")


def test_settings_of_rectified_images(tmp_path: Path):
    path, camera = tmp_path / "a.yaml", "Camera.fx: 500.0\nCamera.fy: 500.0\nCamera.cx: 320.0\nCamera.cy: 240.0\n"
    path.write_text(f"%YAML:1.0\n{camera}Camera.width: 640\nCamera.height: 480\nCamera.bf: 60.0\n")
    rig = load_rig(path)
    np.testing.assert_allclose(rig.extrinsics, [0, 0, 0, -0.12, 0, 0], atol=1e-12)
    path.write_text(path.read_text() + "Camera.k1: -0.3\n")
    refused(lambda: load_rig(path), "there are coefficients of a lens")
    path.write_text(path.read_text() + "DepthMapFactor: 5000\n")  # of a depth camera, whose baseline is none
    refused(lambda: load_rig(path), "the format is unknown")


@pytest.mark.parametrize("lines", ["500 0 320 0 501 240 0 0 1\n0.12\n", "500, 0, 320\n0, 501, 240\n0, 0, 1\n0.12\n"])
def test_a_camera_matrix_and_a_baseline(tmp_path: Path, lines: str):
    path = tmp_path / "K.txt"
    path.write_text(lines)
    np.testing.assert_allclose(load_rig(path, size=SIZE).extrinsics, [0, 0, 0, -0.12, 0, 0], atol=1e-12)
    refused(lambda: load_rig(path), "the file has no image size")
    path.write_text(lines.replace("0.12", "-0.12"))
    refused(lambda: load_rig(path, size=SIZE), "the baseline, is -0.12")


def test_what_camera_calibration_prints(tmp_path: Path):
    R1, R2, P1, P2, *_ = cv2.stereoRectify(K1, D1, K2, D2, SIZE, R, T[:, None], alpha=0)
    text, rows = "", lambda matrix: "\n".join(" ".join(map(repr, row)) for row in np.atleast_2d(matrix).tolist())
    for side, K, D, rectify, P in (("left", K1, D1, R1, P1), ("right", K2, D2, R2, P2)):
        text += f"# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n[rig/{side}]\n\n"
        text += f"camera matrix\n{rows(K)}\n\ndistortion\n{rows(D)}\n\nrectification\n{rows(rectify)}\n\n"
        text += f"projection\n{rows(P)}\n\n"
    path = tmp_path / "ost.txt"
    path.write_text(text)
    rig = load_rig(path)
    np.testing.assert_allclose(rig.extrinsics, RIG.extrinsics, atol=1e-9)
    refused(lambda: save_rig(rig, path, overwrite=True), "the ending contradicts what is to be written")


def test_what_is_unknown_is_listed_and_can_be_filled_in(tmp_path: Path):
    path, template = tmp_path / "a.txt", tmp_path / "calib.json"
    path.write_text("some words of nobody\n")
    refused(lambda: load_rig(path), "the format is unknown; expected one of ")
    path = tmp_path / "a.yaml"
    path.write_text(f"fast: {[1.0, 2.0, 3.0]}\nslow:\n  deep: {[[1, 2], [3, 4]]}\n")
    refused(lambda: load_rig(path), "It has fast (3), slow.deep (2x2). Give the numbers to sr.StereoRig.from_matrices(")
    save_template([path], template)
    refused(lambda: load_rig(template), "image_size contains null")
    values = json.loads(template.read_text())
    assert values["found"] == {"fast": [1.0, 2.0, 3.0], "slow.deep": [[1.0, 2.0], [3.0, 4.0]]}
    cameras = {"K_left": K1, "D_left": D1, "K_right": K2, "D_right": D2, "R": R, "T": T, "image_size": np.array(SIZE)}
    template.write_text(json.dumps(values | {key: value.tolist() for key, value in cameras.items()}))
    assert_same(load_rig(template))
    refused(lambda: save_template([path], template), "exists already")


@pytest.mark.parametrize(("form", "format"), [(mat, "orbslam"), (orb_slam, "matlab")])
def test_a_file_of_another_form_is_refused(tmp_path: Path, form, format: str):
    (path,) = form(tmp_path)
    refused(lambda: load_rig(path, format=format), path.name)
