"""Which cameras of a file are read and written back, and how they stand: the right one first, two of four, one above
the other, one upside down. Files are read and written as they are, and what matches images turns both."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
import yaml
from every import SAMPLES, STANDS, assert_same, new_files, write_exchanged
from gathered import gathered
from refusals import refused

from stereorecal import CalibrationWarning
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io import load_log, load_rig, load_scene, save_rig, save_scene

RIG = samples.rig_of([0.02, -0.03, 0.01, -0.12, 0.004, -0.003])
SWAPPED = "left and right are exchanged: T[0] must be negative (x_right = R x_left + T); "
EXCHANGED = ("right", "left")
CHANGE = np.array([0.01, 0.02, -0.03, -0.01, 0.001, 0.002])
pytestmark = pytest.mark.filterwarnings("ignore:.*(translation is taken|turned by)")


@pytest.mark.parametrize("turns", [(0, 0), (1, 1), (3, 3)])
def test_derived_matrices(tmp_path: Path, turns: tuple[int, int]):
    """Matrices are as OpenCV computes them, for a file whose right camera stands first and for cameras one above the
    other; from these alone R and T are read."""
    (path,) = paths = new_files(tmp_path, "opencv")
    if any(turns):
        save_rig(replace(RIG, turns=turns), path, format="opencv")
    else:
        write_exchanged(RIG, "opencv", paths)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    K1, D1, K2, D2, R, T = (storage.getNode(key).mat() for key in ("K1", "D1", "K2", "D2", "R", "T"))
    size = samples.SIZE[::-1] if any(turns) else samples.SIZE
    made = cv2.stereoRectify(K1, D1, K2, D2, size, R, T, alpha=1.0)
    for key, matrix in zip(("R1", "R2", "P1", "P2", "Q"), made[:5], strict=True):
        np.testing.assert_allclose(storage.getNode(key).mat(), matrix, rtol=0, atol=1e-6, err_msg=key)
    path.write_text(path.read_text().replace("\nR:", "\nR_:").replace("\nT:", "\nT_:"))
    found = load_rig(path, unit="m", cameras=None if any(turns) else EXCHANGED)
    np.testing.assert_allclose(found.rotation, R if any(turns) else R.T, atol=1e-9)
    np.testing.assert_allclose(found.translation, T[:, 0] if any(turns) else -R.T @ T[:, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "cameras", "said"),
    [
        ("kalibr", ("cam1", "cam0"), f"{SWAPPED}the cameras were given as cam1,cam0: give cam0,cam1"),
        ("kalibr", ("cam0", "cam2"), "the cameras are cam0,cam2, and the file has cam0,cam1; give the left and the"),
        ("kalibr", ("cam0", "cam0"), "the cameras are cam0,cam0, and the file has cam0,cam1; give the left and the"),
        ("opencv yaml", ("cam1", "cam0"), "the cameras are cam1,cam0, and opencv names none; give right,left if"),
        ("opencv yaml", EXCHANGED, f"{SWAPPED}the cameras were given as right,left: give left,right"),
        ("middlebury", ("cam1", "cam0"), f"{SWAPPED}the cameras were given as cam1,cam0"),
        ("ros", ("1", "0"), f"{SWAPPED}the cameras were given as 1,0: give 0,1"),
        ("basalt", ("0", "2"), "the cameras are 0,2, and the file has 0,1"),
        ("kalibr", ("cam1",), "cameras is ('cam1',); give the names of the left and the right camera"),
        ("kalibr", (1, 0), "cameras is (1, 0); give the names of the left and the right camera"),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_cameras_that_a_file_has_not(tmp_path: Path, name: str, cameras, said: str):
    paths = SAMPLES[name].write(tmp_path)
    refused(lambda: load_rig(paths, unit=SAMPLES[name].unit, cameras=cameras), said)


def chain_of_four(key: str | None) -> str:
    """Four cameras side by side, cam3 outermost on the left, with poses on an IMU besides if `key` says so."""
    content = {}
    link = np.eye(4)
    link[:3, :3], link[:3, 3] = RIG.rotation.T, -RIG.rotation.T @ RIG.translation
    on_imu = np.diag([-1.0, -1.0, 1.0, 1.0])
    for index in range(4):
        camera = dict(yaml.safe_load(samples.KALIBR)["cam1"], intrinsics=[60.0 + index, 61.0, 31.5, 23.5])
        del camera["T_cam_imu"], camera["T_cn_cnm1"]
        if index:
            camera["T_cn_cnm1"] = link.tolist()
            on_imu = link @ on_imu
        if key is not None:
            camera[key] = (on_imu if key == "T_cam_imu" else np.linalg.inv(on_imu)).tolist()
        content[f"cam{index}"] = camera
    return yaml.safe_dump(content)


@pytest.mark.parametrize("key", [None, "T_cam_imu", "T_imu_cam"])
@pytest.mark.parametrize(("last", "first"), list(combinations((3, 2, 1, 0), 2)))
def test_two_of_four(tmp_path: Path, key: str | None, first: int, last: int):
    path, new = tmp_path / "a.yaml", tmp_path / "b.yaml"
    path.write_text(chain_of_four(key))
    cameras = f"cam{last}", f"cam{first}"
    refused(lambda: load_rig(path, cameras=(cameras[1], cameras[0])), SWAPPED)
    rig = load_rig(path, cameras=cameras)
    assert (rig.left.matrix[0, 0], rig.right.matrix[0, 0]) == (60.0 + last, 60.0 + first)
    moved = rig.with_extrinsics(rig.extrinsics + CHANGE)
    save_rig(moved, new)
    assert_same(load_rig(new, cameras=cameras), moved)
    old, now = (yaml.safe_load(one.read_text()) for one in (path, new))
    links = {index for index in (1, 2, 3) if old[f"cam{index}"]["T_cn_cnm1"] != now[f"cam{index}"]["T_cn_cnm1"]}
    assert links == {last}
    if key is not None:  # which still say the same
        for name in now:
            now[name].pop("T_cn_cnm1", None)
        new.write_text(yaml.safe_dump(now))
        assert_same(load_rig(new, cameras=cameras), moved)


def test_other_sockets(tmp_path: Path):
    """Those of a DepthAI file have numbers."""
    path = tmp_path / "a.json"
    save_rig(RIG, path, format="depthai")
    assert_same(load_rig(path, cameras=("1", "2")), RIG)
    refused(lambda: load_rig(path, cameras=("2", "1")), f"{SWAPPED}the cameras were given as 2,1: give 1,2")
    refused(lambda: load_rig(path, cameras=("0", "1")), "the cameras are 0,1, and the file has 1,2; give the left")


def test_a_scene(tmp_path: Path):
    (path,) = paths = new_files(tmp_path, "opencv")
    write_exchanged(RIG, "opencv", paths)
    for offset, side in enumerate(("left", "right")):
        cv2.imwrite(str(tmp_path / f"{side}.png"), np.eye(*samples.SIZE[::-1], offset) * 255)
    scene = gathered(tmp_path / "left.png", tmp_path / "right.png", path, unit="m", cameras=EXCHANGED)
    assert isinstance(scene.rig, StereoRig)
    assert_same(scene.rig, RIG)


# --- one above the other, or upside down


@pytest.mark.parametrize("turns", [(1, 1), (3, 3)])
def test_fisheyes_one_above_the_other(tmp_path: Path, turns: tuple[int, int]):
    cameras = {side: replace(getattr(RIG, side), model="equidistant") for side in ("left", "right")}
    paths, rig = new_files(tmp_path, "ros"), replace(RIG, **cameras, turns=turns)
    for one in (rig, replace(rig, extrinsics=rig.extrinsics + CHANGE)):
        save_rig(one, paths, format="ros", overwrite=True)
        assert_same(load_rig(paths).side_by_side(), one)


def test_both_upside_down_are_not_told_from_exchanged(tmp_path: Path):
    """Neither is guessed."""
    words = "if both are upside down, turn images and calibration"
    refused(lambda: save_rig(replace(RIG, turns=(2, 2)), tmp_path / "calib.json"), words)


def stood(folder: Path, scene, turns: tuple[int, int]) -> tuple[Path, Path, Path]:
    """A scene as cameras that stand otherwise took it: images of either side, and the calibration."""
    pair = scene.pairs[0]
    for side, image, turn in zip(("l", "r"), (pair.left, pair.right), turns, strict=True):
        (folder / side).mkdir(parents=True)
        cv2.imwrite(str(folder / side / "7.png"), np.rot90(np.rint(image), -turn))
    save_rig(replace(scene.rig, turns=turns, source=None), folder / "calib.json")
    return folder / "l", folder / "r", folder / "calib.json"


@pytest.mark.parametrize("turns", STANDS.values(), ids=STANDS)
def test_images_are_turned_with_the_calibration(tmp_path: Path, scene, turns: tuple[int, int]):
    rendered = scene("street", 0, (320, 240))
    plain = gathered(*stood(tmp_path / "plain", rendered, (0, 0)))
    places = stood(tmp_path / "turned", rendered, turns)
    with pytest.warns(CalibrationWarning, match="turned by"):
        turned = gathered(*places)
    assert isinstance(turned.rig, StereoRig)
    assert turned.rig.turns == turned.pairs[0].turns == turns
    np.testing.assert_array_equal(turned.pairs[0].left, plain.pairs[0].left)
    np.testing.assert_array_equal(turned.pairs[0].right, plain.pairs[0].right)
    save_scene(turned, tmp_path / "saved")
    assert same_rig(load_rig(tmp_path / "saved"), turned.rig)
    again = cv2.imread(str(tmp_path / "saved" / "left.png"), cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(again, cv2.imread(str(places[0] / "7.png"), cv2.IMREAD_GRAYSCALE))
    for read in (load_scene(tmp_path / "saved").pairs[0], load_log(tmp_path / "saved").missions[0].pairs[0]):
        np.testing.assert_array_equal(read.left, plain.pairs[0].left)
