"""What makers of stereo cameras give: ZED's factory .conf, and the text that RealSense's tool prints."""

import random
from pathlib import Path

import cv2
import numpy as np
import pytest
from refusals import refused

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

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


@pytest.mark.parametrize(
    ("old", "new", "size", "said"),
    [
        ("", "", None, "the file has calibrations for images of 672x376, 1280x720, 1920x1200; give size=(width"),
        ("", "", (640, 480), "the images are 640x480, and the file has calibrations for 672x376, 1280x720, 1920x1200"),
        ("Baseline=120.25", "Baseline=-120.25", (672, 376), "Baseline is -120.25; it is the distance of the cameras"),
        ("Baseline=120.25", "", (672, 376), "STEREO: the key 'BASELINE' is missing"),
        ("RX_VGA=0.002", "RX_VGA=0.2", (672, 376), "RX, CV and RZ are in radians, and the cameras of a ZED are not"),
        ("RX_VGA=", "RX_=", (672, 376), "the key 'RX_VGA' is missing"),
        ("k1=", "q1=", (672, 376), "the key 'K1' is missing"),
        ("TY=0.125", "TY=nan", (672, 376), "TY contains NaN"),
        ("_CAM_", "_CAM_X_", (672, 376), "the format is unknown"),
        ("[RIGHT_CAM_", "[RIGHT_X_", (672, 376), "there is no image size at which the file has both cameras"),
    ],
)
def test_zed_refused(tmp_path: Path, old: str, new: str, size, said: str):
    path = written(tmp_path, "\n".join(zed_sections()).replace(old, new))
    refused(lambda: load_rig(path, size=size), said)


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
    matrix = [[size[0] / 2, 0, size[0] / 2 + 0.25], [0, size[0] / 2 + 0.5, size[1] / 2], [0, 0, 1]]
    np.testing.assert_array_equal(rig.left.matrix, matrix)
    assert not np.any(rig.left.distortion)
    start, _, back = path.read_text().rpartition("Extrinsic")
    backwards = written(tmp_path, start.rpartition("Extrinsic")[0] + "Extrinsic" + back, "backwards.txt")
    check_motion(load_rig(backwards, size=size))
    refused(lambda: save_rig(rig, tmp_path / "new.txt", format="realsense"), "is read, not written")


def test_two_realsenses_in_one_text(tmp_path: Path):
    """The program prints all devices that are plugged in."""
    path = written(tmp_path, printed() + printed().replace("320.25", "321.5"))
    refused(lambda: load_rig(path, size=(640, 480)), "it has two intrinsics for images of 640x480; keep those of one")


def test_realsense_fisheyes(tmp_path: Path):
    text = printed(("Fisheye 1", "Fisheye 2"), lens="-0.004 0.037 -0.035 0.005 0", model="Kannala Brandt4")
    rig = load_rig(written(tmp_path, text), size=(640, 480))
    assert rig.left.model == rig.right.model == "equidistant"
    np.testing.assert_array_equal(rig.right.distortion, [-0.004, 0.037, -0.035, 0.005])
    check_motion(rig)


@pytest.mark.parametrize(
    ("old", "new", "size", "said", "kind"),
    [
        ("", "", None, "the file has calibrations for images of 640x480, 848x480; give size=", InputError),
        (
            "",
            "",
            (1280, 720),
            "the images are 1280x720, and the file has calibrations for 640x480, 848x480",
            InputError,
        ),
        ('"Infrared 2"', '"Depth"', (640, 480), "it has not the intrinsics of Infrared 1 and Infrared 2", InputError),
        (
            'To\t  "Infrared',
            'To\t  "Other',
            (640, 480),
            "it has no extrinsics from Infrared 1 to Infrared 2",
            InputError,
        ),
        ("{Y8}", "{Z}", (848, 480), "it has two intrinsics for images of 848x480", InputError),
        ("0 0 0 0 0", "0.1 0 0 0 0", (640, 480), "'Modified' is not supported", UnsupportedModelError),
        ("-0.0501", "word", (640, 480), "Extrinsic from Infrared 1 To Infrared 2: numbers is not an array", InputError),
    ],
)
def test_realsense_refused(tmp_path: Path, old: str, new: str, size, said: str, kind):
    text = printed().replace(old, new)
    if kind is UnsupportedModelError:
        text = text.replace("Brown Conrady", "Modified")
    if new == "{Z}":
        text = text.replace("{Y16}", "{Z}").replace("Modified ", "").replace("0.1 0.2 0.3 0.4 0.5", "0 0 0 0 0")
    refused(lambda: load_rig(written(tmp_path, text), size=size), said, kind=kind)
