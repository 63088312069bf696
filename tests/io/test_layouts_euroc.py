"""EuRoC: poses on the body become a rig, frames are paired by their times."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from trees import EUROC_TIMES, SIZE, cut, edit, euroc, euroc_sensor, pose_of, refused, write_image, write_text

from stereorecal import InputError, StereoRig, UnsupportedModelError
from stereorecal.io import load_log, load_scene

SENSOR = "mav0/cam1/sensor.yaml"


def rig_with_poses(folder: Path, poses: list[np.ndarray]) -> StereoRig:
    for index, pose in enumerate(poses):
        text = ",\n         ".join(", ".join(f"{value:.17g}" for value in line) for line in pose)
        write_text(folder / f"mav0/cam{index}/sensor.yaml", euroc_sensor(index, text))
    return load_scene(folder).rig


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return euroc(tmp_path_factory.mktemp("euroc"))


def test_the_log(tmp_path: Path):
    folder = euroc(tmp_path)
    log = load_log(folder)
    assert [mission.name for mission in log.missions] == [f"{tmp_path.name}/V1_01_easy"]
    assert [pair.name for pair in log.missions[0].pairs] == [f"{time}.png" for time in EUROC_TIMES]
    rig = log.calibrations["stored"]
    assert rig.left.size == rig.right.size == SIZE
    np.testing.assert_array_equal(rig.left.matrix, [[458.654, 0, 367.215], [0, 457.296, 248.375], [0, 0, 1]])
    np.testing.assert_array_equal(rig.right.distortion, [-0.28368365, 0.07451284, -0.00010473, -3.555907e-05])
    again = load_log(folder / "mav0")
    assert again.missions[0].name == "V1_01_easy/mav0"
    np.testing.assert_array_equal(again.calibrations["stored"].extrinsics, rig.extrinsics)


turns, places = st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-2, 2)] * 3)


@settings(max_examples=12)
@given(body_turn=turns, body_place=places, turn=st.tuples(*[st.floats(-0.3, 0.3)] * 3), shift=st.floats(-2, -0.05))
def test_the_direction(tree: Path, body_turn, body_place, turn, shift: float):
    """A point that the left camera sees, taken to the body and from there to the right camera, as 4x4 matrices."""
    left = pose_of(body_turn, body_place)
    right = left @ np.linalg.inv(pose_of(turn, [shift, 0.02 * shift, -0.01 * shift]))
    rig = rig_with_poses(tree, [left, right])
    points = np.random.default_rng(0).normal(size=(10, 3))
    seen = (np.linalg.inv(right) @ left @ np.column_stack([points, np.ones(10)]).T).T[:, :3]
    np.testing.assert_allclose(points @ rig.rotation.T + rig.translation, seen, atol=1e-9)


def test_frames_of_one_camera_only_are_left_out(tmp_path: Path):
    """As in V2_03_difficult; the frame after them is still paired with its own partner."""
    folder = euroc(tmp_path)
    (folder / "mav0/cam1/data" / f"{EUROC_TIMES[1]}.png").unlink()
    write_image(folder / "mav0/cam1/data" / f"{EUROC_TIMES[0] - 50000000}.png", 99)
    pairs = load_scene(folder).pairs
    assert [pair.name for pair in pairs] == [f"{EUROC_TIMES[0]}.png", f"{EUROC_TIMES[2]}.png"]
    assert [Path(path).name for pair in pairs for path in pair.origin[1][:2]] == [
        f"{EUROC_TIMES[index]}.png" for index in (0, 0, 2, 2)
    ]


def test_no_common_time(tmp_path: Path):
    folder = euroc(tmp_path)
    for path in (folder / "mav0/cam1/data").iterdir():
        path.rename(path.with_name(f"{int(path.stem) + 1}.png"))
    refused(folder, "mav0/cam0/data", "no image in it has the same time")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("T_BS:", "T_SB:", "'T_BS' is missing"),
        ("distortion_model: radial-tangential\n", "", "'distortion_model' is missing"),
        ("intrinsics:", "intrinsic:", "'intrinsics' is missing"),
        ("camera_model: pinhole", "camera_model: omni", "the lens model 'omni radial-tangential' is not supported"),
        ("radial-tangential", "fov", "the lens model 'pinhole fov' is not supported"),
    ],
)
def test_bad_sensors(tmp_path: Path, old: str, new: str, words: str, capfd: pytest.CaptureFixture[str]):
    folder = euroc(tmp_path)
    edit(folder / SENSOR, old, new)
    refused(folder, SENSOR, words, kind=UnsupportedModelError if " model '" in words else InputError)
    assert capfd.readouterr() == ("", "")


def test_missing_and_broken_files(tmp_path: Path):
    folder = euroc(tmp_path)
    cut(folder / SENSOR, "data")
    refused(folder, SENSOR)
    (folder / SENSOR).unlink()
    refused(folder, SENSOR, "no such file")
    for path in (folder / "mav0/cam1/data").iterdir():
        path.unlink()
    refused(folder, "mav0/cam1/data", "no image in it")


def test_the_real_one(data_dir: Path, tmp_path: Path):
    """EuRoC's own numbers, with the images of the real scene: the rig that its calib.json has from another hand."""
    scene, folder = data_dir / "euroc" / "vicon_room_seq", tmp_path / "V1_01_easy"
    for index, side in enumerate(("left", "right")):
        write_text(folder / f"mav0/cam{index}/sensor.yaml", euroc_sensor(index, size=(752, 480)))
        (folder / f"mav0/cam{index}/data").symlink_to(scene / side)
    log, content = load_log(folder), json.loads((scene / "calib.json").read_text())
    rig = log.calibrations["stored"]
    np.testing.assert_allclose(rig.rotation, content["R"], atol=1e-9)
    np.testing.assert_allclose(rig.translation, content["T"], atol=1e-9)
    for side, camera in (("left", rig.left), ("right", rig.right)):
        np.testing.assert_array_equal(camera.matrix, content[f"K_{side}"])
        np.testing.assert_array_equal([*camera.distortion, 0], content[f"D_{side}"])
    assert [f"left/{pair.name}" for pair in log.missions[0].pairs] == content["left_files"]
