"""Forms that are read and not written: MATLAB, mrcal, VINS, ORB-SLAM, FoundationStereo, ost.txt, ZED's factory .conf,
the text that RealSense's tool prints; and unknown ones."""

import json
import random
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from refusals import refused
from scipy.io import savemat
from test_matrices_under_any_names import D1, D2, K1, K2, RIG, SIZE, R, T, assert_same

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import StereoRig
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
    "zed": lambda folder: [written(folder, "\n".join(zed_sections()))],
    "realsense": lambda folder: [written(folder, printed(), "printed.txt")],
}


@pytest.mark.parametrize("name", [name for name in FORMS if name not in ("zed", "realsense")])
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


VGA, SMALL = (672, 376), (640, 480)
REFUSED = [
    ("mrcal", "OPENCV5", "SPLINED_STEREOGRAPHIC", None, "mrcal-convert-lensmodel"),
    ("orbslam", "PinHole", "Sphere", None, "the lens model 'Sphere' is not supported"),
    ("vins", "cam1_pinhole", "cam7_pinhole", None, "there is no such file; put it beside the settings"),
    ("vins", "cam1_pinhole", "../../cam7_pinhole", None, "there is no such file; put it beside the settings"),
    ("matlab", "millimeters", "furlongs", None, "WorldUnits is 'furlongs'"),
    ("matlab", '"ImageSize": [480, 640]', '"ImageSize": []', None, "ImageSize is empty"),
    ("zed", "", "", None, "the file has calibrations for images of 672x376, 1280x720, 1920x1200; give size=(width"),
    ("zed", "", "", SMALL, "the images are 640x480, and the file has calibrations for 672x376, 1280x720, 1920x1200"),
    ("zed", "Baseline=120.25", "Baseline=-120.25", VGA, "Baseline is -120.25; it is the distance of the cameras"),
    ("zed", "Baseline=120.25", "", VGA, "STEREO: the key 'BASELINE' is missing"),
    ("zed", "RX_VGA=0.002", "RX_VGA=0.2", VGA, "RX, CV and RZ are in radians, and the cameras of a ZED are not"),
    ("zed", "RX_VGA=", "RX_=", VGA, "the key 'RX_VGA' is missing"),
    ("zed", "k1=", "q1=", VGA, "the key 'K1' is missing"),
    ("zed", "TY=0.125", "TY=nan", VGA, "TY contains NaN"),
    ("zed", "_CAM_", "_CAM_X_", VGA, "the format is unknown"),
    ("zed", "[RIGHT_CAM_", "[RIGHT_X_", VGA, "there is no image size at which the file has both cameras"),
    ("realsense", "", "", None, "the file has calibrations for images of 640x480, 848x480; give size="),
    ("realsense", "", "", (1280, 720), "images are 1280x720, and the file has calibrations for 640x480, 848x480"),
    ("realsense", '"Infrared 2"', '"Depth"', SMALL, "it has not the intrinsics of Infrared 1 and Infrared 2"),
    ("realsense", 'To\t  "Infrared', 'To\t  "Other', SMALL, "it has no extrinsics from Infrared 1 to Infrared 2"),
    ("realsense", "0 0 0 0 0\n", "0.1 0 0 0 0\n", SMALL, "'Modified' is not supported"),
    ("realsense", "-0.0501", "word", SMALL, "Extrinsic from Infrared 1 To Infrared 2: numbers is not an array"),
]


@pytest.mark.parametrize(("name", "old", "new", "size", "words"), REFUSED)
def test_refusals(tmp_path: Path, name: str, old: str, new: str, size: tuple[int, int] | None, words: str):
    paths = FORMS[name](tmp_path)
    assert old in paths[0].read_text()
    for path in paths:
        text = path.read_text().replace(old, new)
        path.write_text(text.replace("Brown Conrady", "Modified") if "Modified" in words else text)
    unsupported = "not supported" in words or "convert-lensmodel" in words
    refused(lambda: load_rig(*paths, size=size), words, kind=UnsupportedModelError if unsupported else InputError)


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
    for format in (None, "foundationstereo"):
        rig = load_rig(path, size=SIZE, format=format)
        np.testing.assert_allclose(rig.extrinsics, [0, 0, 0, -0.12, 0, 0], atol=1e-12)
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
    np.testing.assert_array_equal(load_rig(path, format="camera_info").extrinsics, rig.extrinsics)
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


# --- devices

ZED_SIZES = {"VGA": (672, 376), "HD": (1280, 720), "FHD1200": (1920, 1200)}
TURN = np.array([0.002, -0.011, 0.0007])
MOTION = cv2.Rodrigues(np.array([0.001, -0.002, 0.0005]))[0], np.array([-0.0501, 0.0002, -0.0003])


def zed_sections(lens: str = "k1=-0.17\nk2=0.026\np1=0.0003\np2=-0.0001\nk3=0.004\n") -> list[str]:
    sections = ["[STEREO]\nBaseline=120.25\nTY=0.125\nTZ=-0.5\n"]
    for name, (width, height) in ZED_SIZES.items():
        sections[0] += f"CV_{name}={TURN[1]}\nRX_{name}={TURN[0]}\nRZ_{name}={TURN[2]}\n"
        for side, more in (("LEFT", 0), ("RIGHT", 3)):
            sections.append(
                f"[{side}_CAM_{name}]\nfx={width / 2 + more}\nfy={width / 2}\ncx={width / 2 - more}\ncy={height / 2}\n"
                + lens
            )
    return sections


def written(folder: Path, text: str, name: str = "device.conf") -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", list(ZED_SIZES))
def test_zed(tmp_path: Path, name: str, seed: int):
    sections = zed_sections()
    random.Random(seed).shuffle(sections)
    text = "\n".join(sections)
    path = written(tmp_path, text if seed else text.replace("=", " = ").replace("\n", "\r\n"))
    rig = load_rig(path, size=ZED_SIZES[name])
    width, height = rig.left.size
    assert (rig.left.size, rig.source.format, rig.source.unit) == (ZED_SIZES[name], "zed", "mm")
    again = load_rig(path, size=list(ZED_SIZES[name]), format="zed")  # pyright: ignore[reportArgumentType]
    np.testing.assert_array_equal(again.extrinsics, rig.extrinsics)
    np.testing.assert_allclose(rig.T, [-0.12025, 0.000125, -0.0005], rtol=1e-12)
    np.testing.assert_allclose(rig.R, cv2.Rodrigues(TURN)[0], rtol=0, atol=1e-12)
    right = [[width / 2 + 3, 0, width / 2 - 3], [0, width / 2, height / 2], [0, 0, 1]]
    np.testing.assert_array_equal(rig.right.matrix, right)
    np.testing.assert_array_equal(rig.left.distortion, [-0.17, 0.026, 0.0003, -0.0001, 0.004])
    save_rig(rig, tmp_path / "calib.json")
    np.testing.assert_allclose(load_rig(tmp_path / "calib.json").extrinsics, rig.extrinsics, rtol=0, atol=1e-12)
    refused(lambda: save_rig(rig, tmp_path / "new.conf", format="zed"), "is read, not written; write the rig as opencv")


@pytest.mark.parametrize(
    ("terms", "model"),
    [
        (
            {"k1": 0.5, "k2": -0.25, "p1": 0.001, "p2": 0.002, "k3": 0.01, "k4": 0.75, "k5": -0.125, "k6": 0.02},
            "radtan",
        ),
        ({"k1": 0.1, "k2": -0.02, "k3": 0.003, "k4": -0.0004}, "equidistant"),  # no tangential ones
    ],
)
def test_zed_with_one_lens_for_all_sizes(tmp_path: Path, terms: dict[str, float], model: str):
    lines = "".join(f"{name} = {term}\n" for name, term in terms.items())
    lenses = [f"[LEFT_DISTO]\n{lines}", f"[RIGHT_DISTO]\n{lines}"]
    rig = load_rig(written(tmp_path, "\n".join([*zed_sections(lens=""), *lenses])), size=(1280, 720))
    assert rig.left.model == rig.right.model == model
    np.testing.assert_array_equal(rig.left.distortion, list(terms.values()))
    both = written(tmp_path, "\n".join([*zed_sections(), *lenses]))
    refused(lambda: load_rig(both, size=(1280, 720)), "its lens is not the one in LEFT_DISTO; remove")


def mode(
    name: str, size: tuple[int, int], kind: str = "Y8", lens: str = "0 0 0 0 0", model: str = "Brown Conrady"
) -> str:
    width, height = size
    return (
        f' Intrinsic of "{name}" / {width}x{height} / {{{kind}}}\n  Width:      \t{width}\n  Height:     \t{height}\n'
        f"  PPX:        \t{width / 2 + 0.25}\n  PPY:        \t{height / 2}\n  Fx:         \t{width / 2}\n"
        f"  Fy:         \t{width / 2 + 0.5}\n  Distortion: \t{model}\n  Coeffs:     \t{lens}\n"
        "  FOV (deg):  \t89.9 x 58.7\n\n"
    )


def motion(one: str, other: str, R, T) -> str:
    rows = "".join("  " + "  ".join(map(repr, row)) + "\n" for row in np.asarray(R).tolist())
    shift = "  ".join(map(repr, np.asarray(T).tolist()))
    return f'Extrinsic from "{one}"\t  To\t  "{other}" :\n Rotation Matrix:\n{rows}\n Translation Vector: {shift}  \n\n'


def printed(names=("Infrared 1", "Infrared 2"), **lens) -> str:
    R, T = MOTION
    text = "Device info: \n    Name                          : \tCamera\n\nStream Profiles\n\n"
    text += "Intrinsic Parameters:\n\n" + mode("Color", (1280, 720))
    for name in names:
        text += mode(name, (640, 480), **lens) + mode(name, (848, 480), **lens)
        text += mode(name, (848, 480), "Y16", "0.1 0.2 0.3 0.4 0.5", "Modified Brown Conrady").replace("424", "431")
    text += 'Motion Intrinsic of "Gyro"\t  MOTION_XYZ32F\nBias Variances: 0  0  0  \n\nExtrinsic Parameters:\n'
    return (
        text
        + motion("Color", names[0], np.eye(3), np.ones(3))
        + motion(*names, R, T)
        + motion(names[1], names[0], R.T, -R.T @ T)
    )


def check_motion(rig: StereoRig) -> None:
    np.testing.assert_allclose(rig.R, MOTION[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rig.T, MOTION[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("size", [(640, 480), (848, 480)])
def test_realsense(tmp_path: Path, size: tuple[int, int]):
    path = written(tmp_path, printed(), "printed.txt")
    rig = load_rig(path, size=size)
    assert (rig.left.size, rig.source.format) == (size, "realsense")
    check_motion(rig)
    check_motion(load_rig(path, size=size, format="realsense"))
    matrix = [[size[0] / 2, 0, size[0] / 2 + 0.25], [0, size[0] / 2 + 0.5, size[1] / 2], [0, 0, 1]]
    np.testing.assert_array_equal(rig.left.matrix, matrix)
    assert not np.any(rig.left.distortion)
    start, _, back = path.read_text().rpartition("Extrinsic")
    backwards = written(tmp_path, start.rpartition("Extrinsic")[0] + "Extrinsic" + back, "backwards.txt")
    check_motion(load_rig(backwards, size=size))
    refused(lambda: save_rig(rig, tmp_path / "new.txt", format="realsense"), "is read, not written")


def test_two_realsenses_in_one_text(tmp_path: Path):
    """The program prints all devices that are plugged in; and formats of images, of which none may be Y8."""
    raw = (
        printed()
        .replace("Y16", "Z")
        .replace("Y8", "Z")
        .replace("Modified ", "")
        .replace("0.1 0.2 0.3 0.4 0.5", "0 " * 5)
    )
    path = written(tmp_path, raw)
    refused(lambda: load_rig(path, size=(848, 480)), "it has two intrinsics for images of 848x480")
    path = written(tmp_path, printed() + printed().replace("320.25", "321.5"))
    refused(lambda: load_rig(path, size=(640, 480)), "it has two intrinsics for images of 640x480; keep those of one")


def test_realsense_fisheyes(tmp_path: Path):
    text = printed(("Fisheye 1", "Fisheye 2"), lens="-0.004 0.037 -0.035 0.005 0", model="Kannala Brandt4")
    rig = load_rig(written(tmp_path, text), size=(640, 480))
    assert rig.left.model == rig.right.model == "equidistant"
    np.testing.assert_array_equal(rig.right.distortion, [-0.004, 0.037, -0.035, 0.005])
    check_motion(rig)
