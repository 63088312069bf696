"""KITTI raw, odometry and stereo: projections, poses, cameras, frames, and what is refused."""

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from trees import (
    PLACES,
    SIZE,
    K,
    cut,
    edit,
    kitti_2012,
    kitti_2015,
    kitti_cam_to_cam,
    kitti_drive,
    kitti_odometry,
    kitti_projections,
    kitti_raw,
    pose_of,
    projection,
    refused,
    row,
    set_line,
    without_line,
    write_image,
    write_text,
)

from stereorecal import StereoRig, UnsupportedModelError
from stereorecal.io import load_log, load_scene, save_rig
from stereorecal.recordings import Pair

SYNC, EXTRACT = "2011_09_26_drive_0001_sync", "2011_09_26_drive_0001_extract"
POINTS = np.random.default_rng(0).uniform([-1, -1, 2], [1, 1, 8], (20, 3))


def homogeneous(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.ones(len(points))])


def assert_sees_as_the_projections(rig: StereoRig, left: int, right: int) -> None:
    """Points seen through KITTI's 3x4 matrices and triangulated with the rig are where they are in the left frame."""
    pixels = []
    for index in (left, right):
        seen = homogeneous(POINTS) @ projection(index).T
        pixels.append((seen[:, :2] / seen[:, 2:]).T)
    ours = [
        rig.left.matrix @ np.eye(3, 4),
        rig.right.matrix @ np.column_stack([rig.rotation, rig.translation]),
    ]
    found = cv2.triangulatePoints(*ours, *pixels)
    np.testing.assert_allclose((found[:3] / found[3]).T, POINTS + PLACES[left], rtol=1e-6)


def names(pairs: tuple[Pair, ...]) -> list[tuple[str, str]]:
    """The names of the files: the folder of the image and its number."""
    return [tuple("/".join(Path(path).parts[-3:]) for path in pair.origin[1][:2]) for pair in pairs]


# --- raw ----------------------------------------------------------------------------------------------------


def test_a_day_of_rectified_drives(tmp_path: Path):
    day = kitti_raw(tmp_path)
    write_text(day / "calib_velo_to_cam.txt", "R: 1")
    log = load_log(day)
    assert log.name == f"{tmp_path.name}/2011_09_26"
    assert [mission.name for mission in log.missions] == [SYNC, SYNC.replace("1_sync", "2_sync")]
    assert [pair.name for pair in log.missions[0].pairs] == [f"{index:010d}.png" for index in range(3)]
    rig = log.calibrations["stored"]
    assert rig.left.size == rig.right.size == SIZE
    np.testing.assert_allclose(rig.left.matrix, K)
    np.testing.assert_allclose(rig.extrinsics, [0, 0, 0, -0.54, 0, 0], atol=1e-12)
    assert rig.left.distortion.size == rig.right.distortion.size == 0


@pytest.mark.parametrize(
    ("cameras", "chosen"), [((0, 1, 2, 3), (0, 1)), ((2, 3), (2, 3)), ((0, 2, 3), (2, 3)), ((0, 1, 3), (0, 1))]
)
def test_grey_before_colour(tmp_path: Path, cameras: tuple[int, ...], chosen: tuple[int, int]):
    day = kitti_raw(tmp_path)
    shutil.rmtree(day / SYNC)
    scene = load_scene(kitti_drive(day / SYNC, cameras, frames=1))
    assert scene.name == f"2011_09_26/{SYNC}"
    left, right = chosen
    assert names(scene.pairs) == [(f"image_{left:02d}/data/0000000000.png", f"image_{right:02d}/data/0000000000.png")]
    assert_sees_as_the_projections(scene.rig, left, right)


small = st.tuples(*[st.floats(-0.2, 0.2)] * 3)


@settings(max_examples=10)
@given(turn=small, shift=st.floats(-1.0, -0.1), left_turn=small, left_place=small, colour=st.booleans())
def test_the_direction_of_raw_drives(
    tmp_path_factory: pytest.TempPathFactory, turn, shift, left_turn, left_place, colour
):
    """Points in camera 00's frame, taken to each camera by its own 4x4 matrix."""
    day = tmp_path_factory.mktemp("raw") / "2011_09_26"
    left = 2 if colour else 0
    poses = [np.eye(4)] * 4  # camera 00 is where it is
    if colour:
        poses[left] = pose_of(left_turn, left_place)
    poses[left + 1] = pose_of(turn, [shift, 0.1 * shift, -0.05 * shift]) @ poses[left]
    write_text(day / "calib_cam_to_cam.txt", kitti_cam_to_cam(poses))
    rig = load_scene(kitti_drive(day / EXTRACT, (left, left + 1), frames=1)).rig
    points = homogeneous(np.random.default_rng(1).normal(size=(10, 3)))
    in_left, in_right = ((points @ poses[index].T)[:, :3] for index in (left, left + 1))
    np.testing.assert_allclose(in_left @ rig.rotation.T + rig.translation, in_right, atol=1e-9)


def test_the_lenses_of_raw_drives(tmp_path: Path):
    day = kitti_raw(tmp_path)
    rig = load_scene(kitti_drive(day / EXTRACT)).rig
    np.testing.assert_allclose(rig.right.matrix, K + np.diag([1, 1, 0]))
    np.testing.assert_allclose(rig.right.distortion, [-0.3, 0.1, 0.001, 0.002, -0.01])
    log = load_log(day)
    assert list(log.calibrations) == [EXTRACT, SYNC]
    assert [mission.calibration for mission in log.missions] == [EXTRACT, SYNC, SYNC]
    assert log.calibrations[EXTRACT].left.distortion.size == 5
    assert log.calibrations[SYNC].left.distortion.size == 0


def test_raw_frames_are_paired_by_time(tmp_path: Path):
    """Camera 01 starts a frame later and misses one: its numbers say nothing."""
    drive = kitti_drive(kitti_raw(tmp_path) / EXTRACT, frames=5)
    times = ["2011-09-26 13:02:25.100400100", "2011-09-26 13:02:25.299900000", "2011-09-26 13:02:25.400000001"]
    write_text(drive / "image_01" / "timestamps.txt", "\r\n".join(times))
    for index in (3, 4):
        (drive / "image_01" / "data" / f"{index:010d}.png").unlink()
    found = [tuple(int(Path(name).stem) for name in pair) for pair in names(load_scene(drive).pairs)]
    assert found == [(1, 0), (3, 1), (4, 2)]
    assert len(load_scene(drive, limit=2).pairs) == 2


@pytest.mark.parametrize("text", ["2011-09-26 13:02:25.1\n", "a\nb\nc\n", "\n \n2011-09-26 13:02:25.1\n"])
def test_bad_times(tmp_path: Path, text: str):
    drive = kitti_drive(kitti_raw(tmp_path) / EXTRACT)
    write_text(drive / "image_00" / "timestamps.txt", text)
    refused(drive, "image_00/timestamps.txt", "not every image in data has a time")


def test_no_common_time(tmp_path: Path):
    drive = kitti_drive(kitti_raw(tmp_path) / EXTRACT)
    edit(drive / "image_01" / "timestamps.txt", "13:02", "14:02")
    refused(drive, "image_00", "no two frames lie within 0.05 s of each other")
    (drive / "image_01" / "timestamps.txt").unlink()
    refused(drive, "image_01/timestamps.txt", "no such file")


def test_a_drive_without_one_of_its_cameras_or_its_name(tmp_path: Path):
    drive = kitti_raw(tmp_path) / SYNC
    shutil.rmtree(drive / "image_01")
    refused(drive, str(drive), "image_00 and image_01, or image_02 and image_03")
    (drive / "image_01" / "data").mkdir(parents=True)
    refused(drive, str(drive / "image_01" / "data"), "no image in it")
    refused(drive.rename(drive.with_name("harbour")), "harbour", "_sync (rectified) or _extract")


def test_a_day_without_drives(tmp_path: Path):
    day = kitti_raw(tmp_path)
    for drive in day.glob("*_sync"):
        shutil.rmtree(drive)
    refused(day, "the log has no sequence")


@pytest.mark.parametrize(
    ("key", "value", "drive", "words"),
    [
        ("P_rect_01", None, SYNC, "'P_rect_01' is missing"),
        ("S_rect_00", None, SYNC, "'S_rect_00' is missing"),
        ("P_rect_00", "0 " * 12, SYNC, "P_rect_00: the camera matrix is singular"),
        ("S_rect_00", "48 32", SYNC, "24x16, but the calibration is for 48x32"),
        ("K_01", None, EXTRACT, "'K_01' is missing"),
        ("D_01", "0.1 0.2", EXTRACT, "distortion has 2 coefficients"),
    ],
)
def test_bad_calibrations_of_raw_drives(tmp_path: Path, key: str, value: str | None, drive: str, words: str):
    day = kitti_raw(tmp_path)
    kitti_drive(day / drive)
    path = day / "calib_cam_to_cam.txt"
    without_line(path, f"{key}:") if value is None else set_line(path, key, value)
    kind = {"kind": UnsupportedModelError} if "coefficients" in words else {}
    refused(day / drive, str(day), words, **kind)


# --- odometry -----------------------------------------------------------------------------------------------


def test_odometry(tmp_path: Path):
    root = kitti_odometry(tmp_path)
    second = root / "sequences" / "01" / "calib.txt"
    second.write_text(kitti_projections().replace(row(-0.54 * 21), row(-0.5 * 21)))
    log = load_log(root)
    assert [mission.name for mission in log.missions] == ["00", "01"]
    assert [mission.calibration for mission in log.missions] == ["00", "01"]
    assert [rig.translation[0] for rig in log.calibrations.values()] == pytest.approx([-0.54, -0.5])
    assert [pair.name for pair in log.missions[1].pairs] == ["000000.png", "000001.png"]
    assert_sees_as_the_projections(load_scene(root / "sequences" / "00").rig, 0, 1)
    second.write_text(kitti_projections())
    assert list(load_log(root).calibrations) == ["stored"]


def test_odometry_in_colour_is_written_where_it_stands(tmp_path: Path):
    """Neither P2 nor P3 is camera 00, from which all of them count: the left one stays, the right one is beside it."""
    folder = kitti_odometry(tmp_path) / "sequences" / "00"
    write_text(folder / "calib.txt", "\ufeff" + kitti_projections())  # a byte order mark
    shutil.rmtree(folder / "image_1")
    for side in (2, 3):
        write_image(folder / f"image_{side}" / "000000.png", side, colour=True)
    scene = load_scene(folder)
    rig = scene.rig
    assert names(scene.pairs) == [("00/image_2/000000.png", "00/image_3/000000.png")]
    assert_sees_as_the_projections(rig, 2, 3)
    longer = rig.with_extrinsics(np.array(rig.extrinsics) * 1.01)
    save_rig(longer, folder / "calib.txt", overwrite=True)
    np.testing.assert_allclose(load_scene(folder).rig.translation, longer.translation, atol=1e-12)
    save_rig(rig, folder / "calib.txt", overwrite=True)
    assert_sees_as_the_projections(load_scene(folder).rig, 2, 3)


def test_frames_of_different_times_are_no_pair(tmp_path: Path):
    folder = kitti_odometry(tmp_path) / "sequences" / "00"
    (folder / "image_0" / "000001.png").unlink()
    (folder / "image_1" / "000000.png").unlink()
    refused(folder, "image_0/000000.png", "no partner on the right side")


# --- stereo 2012 and 2015 -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("tree", "key"), [(kitti_2012, "P1"), (kitti_2015, "P_rect_03")])
def test_frames_that_share_a_calibration_are_one_mission(tmp_path: Path, tree, key: str):
    folder = tree(tmp_path)
    if tree is kitti_2015:  # which does not matter to it
        edit(folder / "calib_cam_to_cam" / "000002.txt", "09-Jan-2012", "10-Jan-2012")
    log = load_log(folder)
    assert [mission.name for mission in log.missions] == ["000000"]
    assert [pair.name for pair in log.missions[0].pairs] == [f"{index:06d}_10.png" for index in range(3)]
    set_line(next(folder.glob("calib*/000001.txt")), key, row(projection(int(key[-1])) - np.eye(3, 4, 3)))
    log = load_log(folder)
    assert list(log.calibrations) == ["000000", "000001"]
    assert [(mission.name, mission.calibration) for mission in log.missions] == [
        ("000000", "000000"), ("000001", "000001"),
    ]  # fmt: skip
    assert [[pair.name for pair in mission.pairs] for mission in log.missions] == [
        ["000000_10.png", "000002_10.png"], ["000001_10.png"],
    ]  # fmt: skip
    assert [len(mission.pairs) for mission in load_log(folder, limit=1).missions] == [1, 1]


def test_cameras_of_the_stereo_benchmarks(tmp_path: Path):
    grey = kitti_2012(tmp_path / "2012")
    assert_sees_as_the_projections(load_scene(grey).rig, 0, 1)
    shutil.rmtree(grey / "image_0")
    scene = load_scene(grey)
    assert_sees_as_the_projections(scene.rig, 2, 3)
    assert names(scene.pairs)[0] == ("training/colored_0/000000_10.png", "training/colored_1/000000_10.png")
    assert_sees_as_the_projections(load_scene(kitti_2015(tmp_path / "2015")).rig, 2, 3)


def test_the_size_of_2015(tmp_path: Path):
    folder = kitti_2015(tmp_path)
    edit(folder / "calib_cam_to_cam" / "000000.txt", f"S_rect_02: {row(SIZE)}", "S_rect_02: 48 32")
    refused(folder, str(folder / "000000"), "000000_10.png", "24x16, but the calibration is for 48x32")


@pytest.mark.parametrize(
    ("tree", "place", "archive"),
    [
        (kitti_raw, "calib_cam_to_cam.txt", "2011_09_26_calib.zip"),
        (kitti_odometry, "sequences/01/calib.txt", "data_odometry_calib.zip"),
        (kitti_2012, "calib/000001.txt", "data_stereo_flow_calib.zip"),
        (kitti_2015, "calib_cam_to_cam/000001.txt", "data_scene_flow_calib.zip"),
    ],
)
def test_calibrations_that_are_cut_or_were_not_unpacked(tmp_path: Path, tree, place: str, archive: str):
    folder = tree(tmp_path)
    path = folder / place
    cut(path, ":")
    refused(folder, str(path.parent), "is missing")
    path.unlink()
    refused(folder, f"{path}: there is no such file; download {archive} from KITTI's page")


# --- real images --------------------------------------------------------------------------------------------

# Of 2011_09_26 and of the day of 000000_10 of 2012, as KITTI's files have them.
P_2015 = {
    "P_rect_02": "7.215377e+02 0.000000e+00 6.095593e+02 4.485728e+01 0.000000e+00 7.215377e+02 1.728540e+02 "
    "2.163791e-01 0.000000e+00 0.000000e+00 1.000000e+00 2.745884e-03",
    "P_rect_03": "7.215377e+02 0.000000e+00 6.095593e+02 -3.395242e+02 0.000000e+00 7.215377e+02 1.728540e+02 "
    "2.199936e+00 0.000000e+00 0.000000e+00 1.000000e+00 2.729905e-03",
    "S_rect_02": "1.242000e+03 3.750000e+02",
}
P_2012 = {
    "P2": "7.070912e+02 0.000000e+00 6.018873e+02 4.688783e+01 0.000000e+00 7.070912e+02 1.831104e+02 1.178601e-01 "
    "0.000000e+00 0.000000e+00 1.000000e+00 6.203223e-03",
    "P3": "7.070912e+02 0.000000e+00 6.018873e+02 -3.334597e+02 0.000000e+00 7.070912e+02 1.831104e+02 1.930130e+00 "
    "0.000000e+00 0.000000e+00 1.000000e+00 3.318498e-03",
}


@pytest.mark.parametrize(
    ("name", "sides", "calibrations", "content"),
    [
        ("kitti2015/000001_10", ("image_2", "image_3"), "calib_cam_to_cam/000001.txt", P_2015),
        ("kitti2012/000000_10", ("colored_0", "colored_1"), "calib/000000.txt", P_2012),
    ],
)
def test_the_real_stereo_frames(data_dir: Path, tmp_path: Path, name: str, sides, calibrations: str, content):
    scene, folder = data_dir / name, tmp_path / "training"
    for side, image in zip(sides, ("left.png", "right.png"), strict=True):
        (folder / side).mkdir(parents=True)
        (folder / side / f"{name[-9:]}.png").symlink_to(scene / image)
    write_text(folder / calibrations, "".join(f"{key}: {value}\n" for key, value in content.items()))
    found, stored = load_scene(folder), json.loads((scene / "calib.json").read_text())
    assert [pair.name for pair in found.pairs] == [f"{name[-9:]}.png"]
    np.testing.assert_array_equal(found.rig.left.matrix, stored["K_left"])
    np.testing.assert_array_equal(found.rig.right.matrix, stored["K_right"])
    np.testing.assert_allclose(found.rig.rotation, stored["R"], atol=1e-15)
    np.testing.assert_allclose(found.rig.translation, stored["T"], atol=1e-12)


def test_the_real_sequence(data_dir: Path, tmp_path: Path):
    scene, folder = data_dir / "kitti_odometry" / "suburb_seq", tmp_path / "sequences" / "04"
    folder.mkdir(parents=True)
    stored = json.loads((scene / "calib.json").read_text())
    matrix = np.array(stored["K_left"])
    lines = [f"P{i}: {row(matrix @ np.column_stack([np.eye(3), np.array(stored['T']) * i]))}\n" for i in (0, 1)]
    write_text(folder / "calib.txt", "".join(lines))
    (folder / "image_0").symlink_to(scene / "left")
    (folder / "image_1").symlink_to(scene / "right")
    log = load_log(tmp_path)
    rig = log.calibrations["stored"]
    np.testing.assert_allclose(rig.left.matrix, matrix)
    np.testing.assert_allclose(rig.translation, stored["T"], atol=1e-12)
    assert [f"left/{pair.name}" for pair in log.missions[0].pairs] == stored["left_files"]


# --- times --------------------------------------------------------------------------------------------------


def test_odometry_times(tmp_path: Path):
    """A line for each image, if there are as many."""
    (mission,) = load_log(kitti_odometry(tmp_path)).missions[:1]
    place, count = min(tmp_path.rglob("calib.txt")).parent, len(mission.pairs)
    assert {pair.time for pair in mission.pairs} == {None}
    for lines, expected in ((count, [0.1 * n for n in range(count)]), (count + 1, [None] * count)):
        write_text(place / "times.txt", "\n".join(f"{0.1 * n:e}" for n in range(lines)))
        assert [pair.time for pair in load_log(tmp_path).missions[0].pairs] == pytest.approx(expected)


def test_raw_times(tmp_path: Path):
    """Seconds after the first image."""
    day = kitti_raw(tmp_path)
    for camera in next(day.glob("*_sync")).glob("image_0*"):
        write_text(camera / "timestamps.txt", "\n".join(f"2011-09-26 13:02:25.{n}64389445" for n in range(3)))
    times = [pair.time for pair in load_log(day).missions[0].pairs]
    assert times == pytest.approx([0.0, 0.1, 0.2])
