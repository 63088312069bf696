"""What real files hold that the samples do not: lenses without a model, OpenCV 5's arrays, aliases, dates, shifts."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import SAMPLES, as_json, as_xml, assert_same, beside
from parts_of_repairs import document
from refusals import refused

from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

FOUR = "[-0.3, 0.1, 0.001, -0.002]"
FIVE = "[-0.3, 0.1, 0.001, -0.002, 0.0]"

# --- lenses -------------------------------------------------------------------------------------------------


def with_lenses(rig: StereoRig, lens) -> StereoRig:
    left, right = (replace(camera, distortion=np.array(lens, float)) for camera in (rig.left, rig.right))
    return replace(rig, left=left, right=right)


@pytest.mark.parametrize("stated", ["[0.0, 0.0, 0.0, 0.0]", "[]"])
def test_kalibr_without_a_lens(tmp_path: Path, stated: str):
    nameless = SAMPLES["kalibr"].changed(("distortion_model: radtan", "distortion_model: none"))
    (path,) = nameless.write(tmp_path)
    refused(lambda: load_rig(path), "the distortion model is 'none', but there are coefficients")
    rig, new = load_rig(nameless.changed((FOUR, stated)).write(tmp_path)), tmp_path / "b.yaml"
    save_rig(with_lenses(rig, samples.LENS), new)
    assert new.read_text().count("distortion_model: radtan") == 2
    np.testing.assert_array_equal(load_rig(new).right.distortion, samples.LENS)
    wider = replace(rig, left=replace(rig.left, matrix=np.array(rig.left.matrix) + np.diag([1.0, 1.0, 0.0])))
    save_rig(wider, new, overwrite=True)
    assert new.read_text().count(f"distortion_coeffs: {stated}\n  distortion_model: none") == 2


@pytest.mark.parametrize("model", [' ""', " none", ""])
def test_ros_without_a_lens(tmp_path: Path, model: str):
    nameless = SAMPLES["ros"].changed(("distortion_model: plumb_bob   #", f"distortion_model:{model}   #"))
    paths = nameless.write(tmp_path)
    refused(lambda: load_rig(paths), "but there are coefficients; name their model")
    nameless.changed((FIVE, "[]"), ("rows: 1\n  cols: 5", "rows: 0\n  cols: 0")).write(tmp_path)
    new = beside(paths)
    save_rig(with_lenses(load_rig(paths), samples.LENS), new)
    np.testing.assert_array_equal(load_rig(new).left.distortion, samples.LENS)
    assert "distortion_model: plumb_bob   # as ever" in new[0].read_text()
    assert "rows: 1\n  cols: 4\n  data: [-0.3" in new[0].read_text()


def test_ros_with_more_than_eight_coefficients(tmp_path: Path):
    twelve = [-0.3, 0.1, 0.001, -0.002, 0.0, 0.0, 0.0, 0.0, 0.001, 0.002, 0.003, 0.004]
    changes = ("plumb_bob", "rational_polynomial"), ("cols: 5", "cols: 12"), (FIVE, str(twelve))
    paths = SAMPLES["ros"].changed(*changes).write(tmp_path)
    moved = with_lenses(load_rig(paths), [-0.2, *twelve[1:]])
    save_rig(moved, beside(paths))
    np.testing.assert_array_equal(load_rig(beside(paths)).left.distortion, moved.left.distortion)
    refused(lambda: save_rig(replace(moved, source=None), (tmp_path / "x", tmp_path / "y"), format="ros"), "needs 12")


def test_ros_with_both_cameras_shifted(tmp_path: Path):
    """As KITTI's colour cameras: both positions are relative to a third."""
    paths = SAMPLES["ros"].changed(("32.0, 0.0,", "32.0, 1.8,"), ("-7.2", "-5.4")).write(tmp_path)
    rig = load_rig(paths)
    assert rig.baseline == pytest.approx(0.12, rel=1e-12)
    moved = rig.with_extrinsics(rig.extrinsics + np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0]))
    save_rig(moved, beside(paths))
    assert_same(load_rig(beside(paths)), moved)


def test_ros_without_a_model(tmp_path: Path):
    """As old files: ROS reads five coefficients as plumb_bob; four may be of two models."""
    expected = load_rig(SAMPLES["ros"].write(tmp_path))
    nameless = SAMPLES["ros"].changed(("distortion_model: plumb_bob   # as ever\n", ""))
    paths = nameless.write(tmp_path)
    rig = load_rig(paths)
    np.testing.assert_array_equal(rig.left.distortion, expected.left.distortion)
    moved = with_lenses(rig, [-0.2, 0.1, 0.001, -0.002, 0.03])
    save_rig(moved, paths, overwrite=True)
    np.testing.assert_array_equal(load_rig(paths).right.distortion, moved.right.distortion)
    nameless.changed(("cols: 5", "cols: 4"), (FIVE, FOUR)).write(tmp_path)
    refused(lambda: load_rig(paths), "the key 'distortion_model' is missing")


@pytest.mark.parametrize("name", ["ros 1 messages", "ros 2 messages"])
def test_ros_messages(tmp_path: Path, name: str):
    """As camera_info YAML of the same numbers, with keys in any order, and as JSON; one alone is half."""
    expected, paths = load_rig(SAMPLES["ros"].write(tmp_path)), SAMPLES[name].write(tmp_path)
    np.testing.assert_array_equal(load_rig(paths).extrinsics, expected.extrinsics)
    refused(lambda: load_rig(paths[0]), "looks like ros: this is not one whole calibration")
    for path in paths:
        content = document(path, path.read_text()).content
        path.write_text(json.dumps(dict(sorted(content.items(), reverse=True))))
    np.testing.assert_array_equal(load_rig(paths).extrinsics, expected.extrinsics)
    np.testing.assert_array_equal(load_rig(paths).right.matrix, expected.right.matrix)
    SAMPLES[name].changed(("31.5", "[31.5, [1.0]]")).write(tmp_path)
    refused(lambda: load_rig(paths), "is not an array of numbers")


PROJECTION = np.array([[60.0, 0.0, 32.0], [0.0, 60.0, 24.0], [0.0, 0.0, 1.0]])


def with_projections(folder: Path, *projections: np.ndarray) -> tuple[Path, Path]:
    paths = folder / "l.yaml", folder / "r.yaml"
    for path, text, projection in zip(paths, samples.ROS_PAIR, projections, strict=True):
        path.write_text(re.sub(r"\[60\.0, 0\.0, 32\.0.*\]", str(projection.ravel().tolist()), text))
    return paths


def test_the_whole_fourth_column_of_ros(tmp_path: Path):
    """Its y and z, as of KITTI's cameras, which are placed against a third."""
    places = [0.03, 0.0004, 0.003], [-0.09, 0.005, 0.002]
    plain = load_rig(with_projections(tmp_path, *(np.column_stack([PROJECTION, [x, 0, 0]]) for x in (0.0, -7.2))))
    to_rectified = plain.translation / -0.12  # R_right^T (1, 0, 0)
    paths = with_projections(tmp_path, *(PROJECTION @ np.column_stack([np.eye(3), place]) for place in places))
    before, rig = [path.read_text() for path in paths], load_rig(paths)
    apart = np.subtract(places[1], places[0])
    assert rig.baseline == pytest.approx(np.linalg.norm(apart), rel=1e-12)
    assert np.dot(rig.translation, to_rectified) == pytest.approx(apart[0], abs=1e-12)
    np.testing.assert_array_equal(rig.rotation, plain.rotation)
    save_rig(rig, paths, overwrite=True)
    assert [path.read_text() for path in paths] == before


@pytest.mark.parametrize(
    ("projection", "words"),
    [
        (np.zeros((3, 4)), "r.yaml: projection_matrix is 0; calibrate the two as stereo"),
        (np.column_stack([-PROJECTION, [7.2, 0, 0]]), "r.yaml: projection_matrix: "),
        (np.column_stack([PROJECTION, [0, 0, 0]]), "projection_matrix has no baseline"),
        (np.column_stack([PROJECTION, [0.1, 0.1, 7.2]]), "the cameras stand neither side by side"),
    ],
)
def test_ros_without_a_baseline(tmp_path: Path, projection: np.ndarray, words: str):
    left = np.column_stack([PROJECTION, [0, 0, 0]])
    refused(lambda: load_rig(with_projections(tmp_path, left, projection)), words)


# --- OpenCV -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", [".yml", ".xml", ".json"])
def test_opencv_with_image_size(tmp_path: Path, ending: str):
    path = tmp_path / f"a{ending}"
    written_as = {".yml": str, ".xml": as_xml, ".json": as_json}[ending]
    path.write_text(written_as(samples.OPENCV.replace("imageSize:", "image_size:")))
    rig = load_rig(path, unit="mm")
    assert (rig.source.format, rig.left.size) == ("opencv", samples.SIZE)


YAML_5 = (
    ("rows: 1\n   cols: 5", "sizes: [ 5 ]"),
    ("rows: 3\n   cols: 1", "sizes: [ 3 ]"),
    ("D1: !!opencv-", "D1: !!opencv-nd-"),
)
XML_5 = (
    ("<rows>1</rows>\n  <cols>5</cols>", "<sizes>\n    5</sizes>"),
    ("<rows>3</rows>\n  <cols>1</cols>", "<sizes>3</sizes>"),
)


@pytest.mark.parametrize(
    ("name", "changes", "grown"),
    [("opencv yaml", YAML_5, "sizes: [ 8 ]"), ("opencv xml", XML_5, "<sizes>\n    8</sizes>")],
)
def test_the_arrays_of_opencv_5(tmp_path: Path, name: str, changes, grown: str):
    sample = SAMPLES[name]
    expected = sample.load(sample.write(tmp_path))
    paths = sample.changed(*changes).write(tmp_path)
    rig = sample.load(paths)
    assert_same(rig, expected)
    eight = with_lenses(rig, [-0.3, 0.1, 0.001, -0.002, 0.0, 0.01, 0.02, 0.03])
    moved = eight.with_extrinsics(rig.extrinsics + 0.01)
    save_rig(moved, beside(paths))
    assert_same(sample.load(beside(paths)), moved)
    assert grown in beside(paths)[0].read_text()


# --- texts --------------------------------------------------------------------------------------------------


def test_aliases(tmp_path: Path):
    path = tmp_path / "a.yaml"
    lists = "".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12))
    for bomb in ("a0: &a0 [1, 2]\n" + lists, "a: &a [1, *a]\n"):
        path.write_text(bomb + samples.KALIBR)
        refused(lambda: load_rig(path), "its aliases expand to more")
    size = "resolution: [64, 48]"
    path.write_text(samples.KALIBR.replace(size, "resolution: &size [64, 48]", 1).replace(size, "resolution: *size"))
    assert load_rig(path).right.size == samples.SIZE


@pytest.mark.parametrize("merged", ["*one", "[*one, *none]"])
def test_keys_that_are_merged(tmp_path: Path, merged: str):
    """Those of cam1 itself come first. What stands once for both cameras is not changed for one."""
    path, new = tmp_path / "a.yaml", tmp_path / "b.yaml"
    expected = load_rig(SAMPLES["kalibr"].write(tmp_path))
    start, cam1 = samples.KALIBR.split("cam1:\n")
    cam1 = cam1.replace("  camera_model: pinhole\n", "").replace(f"  distortion_coeffs: {FOUR}\n", "")
    start = start.replace("cam0:\n", "base: &none {intrinsics: [1]}\ncam0: &one\n")
    path.write_text(f"{start}cam1:\n  <<: {merged}\n{cam1}")
    rig = load_rig(path)
    assert_same(rig, expected)
    moved = rig.with_extrinsics(rig.extrinsics + 0.001)
    save_rig(moved, new)
    assert_same(load_rig(new), moved)
    own = replace(rig, right=replace(rig.right, matrix=np.array(rig.right.matrix) + np.diag([1.0, 1.0, 0.0])))
    save_rig(own, new, overwrite=True)
    assert_same(load_rig(new), own)
    lens = replace(rig, right=replace(rig.right, distortion=np.array(rig.right.distortion) * 1.5))
    words = "cam1.distortion_coeffs stands once for several keys (YAML's & and *); write it out for each, or write a"
    refused(lambda: save_rig(lens, new, overwrite=True), words)


def test_a_date_is_no_line_of_numbers(tmp_path: Path):
    path = tmp_path / "a.yaml"
    path.write_text("date: 2016-01-01 12:00:00\n" + samples.KALIBR)
    assert load_rig(path).source.format == "kalibr"
    path.write_text(samples.OPENCV.replace("%YAML:1.0\n---\n", "date: 20160101 120000\n"))
    assert load_rig(path, format="opencv", unit="mm").source.format == "opencv"


MAPS = f"[ {', '.join(['1.2345678e+02'] * 76800)} ]"


@pytest.mark.parametrize(
    ("name", "head", "tail"),
    [
        ("a.yaml", "", f"map: !!opencv-matrix\n   rows: 240\n   cols: 320\n   dt: f\n   data: {MAPS}\nlast: 1\n"),
        ("a.xml", "<!-- ours <a> -->\n", "\n<!-- the end -->\n"),
    ],
    ids=["maps", "comments beside the root"],
)
def test_what_stands_around_a_calibration_stays(tmp_path: Path, name: str, head: str, tail: str):
    path, new = tmp_path / name, tmp_path / f"new-{name}"
    text = samples.OPENCV
    if name == "a.xml":
        head, text = '<?xml version="1.0"?>\n' + head, as_xml(text).partition("?>")[2].strip()
    path.write_text(head + text + tail)
    rig = load_rig(path, unit="mm")
    save_rig(rig.with_extrinsics(rig.extrinsics + 0.01), new)
    assert new.read_text().startswith(head + text[:10])
    assert new.read_text().endswith(text[-10:] + tail)
    np.testing.assert_allclose(load_rig(new, unit="mm").extrinsics, rig.extrinsics + 0.01, atol=1e-12)


def test_a_calib_json_with_info_of_its_own(tmp_path: Path):
    path, new = tmp_path / "calib.json", tmp_path / "new.json"
    save_rig(samples.RIG, path)
    path.write_text(path.read_text().replace("{", '{\n\t"boat": "Ladja",', 1))
    save_rig(load_rig(path), new, {"boat": "Ladja"})
    assert new.read_bytes() == path.read_bytes()
    save_rig(load_rig(path), new, {"captain": "Ana"}, overwrite=True)
    assert '"captain": "Ana"' in new.read_text()


# --- poses on an IMU ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([("T_cam_imu", "T_body")], "nothing says how cam0 and cam1 stand to each other, neither T_cn_cnm1 of cam1"),
        (
            [("cam1:\n", "cam1:\n  T_cn_cnm_1: [0]\n"), ("_cam_imu", "_x")],
            "cam1: the key 'T_cn_cnm_1' is not known; rename it if 'T_cn_cnm1' is meant",
        ),
        ([("  - 1.0\n  cam_", "  - 2.0\n  cam_")], "cam1: the last row of T_cam_imu is not 0 0 0 1"),
        ([("  - -1.0\n", "  - 1.0\n")], "cam1: T_cam_imu is not a rotation (orthonormal, determinant +1)"),
        (
            [("  cam_overlaps", f"  T_imu_cam: {np.eye(4).ravel().tolist()}\n  cam_overlaps")],
            "T_cam_imu and T_imu_cam contradict each other; remove the one that is wrong",
        ),
    ],
)
def test_kalibr_without_poses(tmp_path: Path, changes, said: str):
    paths = SAMPLES["kalibr on imu"].changed(*changes).write(tmp_path)
    refused(lambda: load_rig(paths), said)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.0, 0.0, 0.0, 1.0]", "0.0, 0.0, 0.0, 2.0]", "the last row of T_BS is not 0 0 0 1"),
        ("[0.0, -1.0, 0.0", "[0.0, 1.0, 0.0", "T_BS is not a rotation (orthonormal, determinant +1)"),
    ],
)
def test_euroc_without_poses(tmp_path: Path, old: str, new: str, said: str):
    paths = SAMPLES["euroc"].changed((old, new)).write(tmp_path)
    refused(lambda: load_rig(paths), said)


@pytest.mark.parametrize("name", ["middlebury", "kitti-odometry"])
def test_rounding_is_no_rotation(tmp_path: Path, name: str):
    paths = SAMPLES[name].write(tmp_path)
    rig, (place,) = load_rig(paths, size=samples.SIZE), beside(paths)
    little, much = (rig.with_extrinsics(rig.extrinsics + np.array([t, -t, t, -0.01, 0, 0])) for t in (5e-10, 1e-8))
    save_rig(little, place)
    assert load_rig(place, size=samples.SIZE).baseline == pytest.approx(little.baseline, rel=1e-12)
    refused(lambda: save_rig(much, place, overwrite=True), "no place for a rotation")
