"""camera_info as messages are printed, once or several times, of one camera or of both in a file."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
from refusals import refused

from stereorecal.geometry import StereoRig
from stereorecal.io import load_rig, save_rig

KINDS = {"rostopic echo": "KDRP", "ros2 topic echo": "kdrp"}


def matrices(rig: StereoRig) -> list[list[np.ndarray]]:
    """K, D, R and P of both cameras, as camera_calibration has them."""
    cameras = [(camera.matrix, np.pad(camera.distortion, (0, 1))) for camera in (rig.left, rig.right)]
    R1, R2, P1, P2, *_ = cv2.stereoRectify(*cameras[0], *cameras[1], samples.SIZE, rig.R, rig.T[:, None], alpha=0)
    return [[*cameras[0], R1, P1], [*cameras[1], R2, P2]]


def message(numbers: list[np.ndarray], keys: str = "KDRP", frame: str = "cam", stamp: int = 1) -> str:
    lines = [f'header: \n  seq: {stamp}\n  stamp: \n    secs: {stamp}\n    nsecs: 5\n  frame_id: "{frame}"']
    lines += [f"height: {samples.SIZE[1]}", f"width: {samples.SIZE[0]}", 'distortion_model: "plumb_bob"']
    lines += [f"{key}: {np.ravel(array).tolist()}" for key, array in zip(keys, numbers, strict=True)]
    lines += ["binning_x: 0", "binning_y: 0", "roi: \n  x_offset: 0\n  height: 0\n  do_rectify: False"]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("times", [1, 3])
def test_a_file_for_each_camera(tmp_path: Path, kind: str, times: int):
    paths, new = [[tmp_path / f"{word}{side}.yaml" for side in "lr"] for word in ("", "new-")]
    for path, numbers in zip(paths, matrices(samples.RIG), strict=True):
        path.write_text("".join(message(numbers, KINDS[kind], stamp=stamp) + "---\n" for stamp in range(times)))
    rig = load_rig(*paths)
    assert rig.source.format == "ros"
    np.testing.assert_allclose(rig.extrinsics, samples.RIG.extrinsics, atol=1e-9)
    save_rig(rig, new)
    assert [path.read_bytes() for path in new] == [path.read_bytes() for path in paths]
    moved = rig.with_extrinsics(rig.extrinsics + np.array([0.01, 0.0, -0.01, 0.0, 0.001, 0.0]))
    save_rig(moved, new, overwrite=True)
    np.testing.assert_allclose(load_rig(*new).extrinsics, moved.extrinsics, atol=1e-12)
    assert new[0].read_text().count("secs:") == 2 * times


def test_both_cameras_in_one_file(tmp_path: Path):
    path, new = tmp_path / "both.yaml", tmp_path / "new.yaml"
    left, right = matrices(samples.RIG)
    parts = [message(left, frame="l"), message(right, frame="r"), message(left, frame="l", stamp=2)]
    path.write_text("---\n".join(parts))
    rig = load_rig(path)
    assert rig.source.format == "camera_info"
    np.testing.assert_allclose(rig.extrinsics, samples.RIG.extrinsics, atol=1e-9)
    moved = rig.with_extrinsics(rig.extrinsics + 0.001)
    save_rig(moved, new)
    np.testing.assert_allclose(load_rig(new).extrinsics, moved.extrinsics, atol=1e-12)
    path.write_text("---\n".join(reversed(parts[:2])))
    refused(lambda: load_rig(path), "--cameras right,left")
    for cameras in (("right", "left"), ("l", "r")):
        np.testing.assert_allclose(load_rig(path, cameras=cameras).extrinsics, samples.RIG.extrinsics, atol=1e-9)
    third = message([left[0] + np.diag([1, 0, 0]), *left[1:]], frame="third")
    path.write_text("---\n".join([*parts, third]))
    refused(lambda: load_rig(path), "it has 3 calibrations that differ (l, r, third); keep those")


def test_files_that_are_no_pair(tmp_path: Path):
    left, right = matrices(samples.RIG)
    one, other = tmp_path / "one.yaml", tmp_path / "other.yaml"
    one.write_text(message(left))
    refused(lambda: load_rig(one), "looks like ros: this is not one whole calibration")
    other.write_text("---\n".join([message(right), message(left)]))
    refused(lambda: load_rig(one, other), "other.yaml: it holds 2 calibrations that differ")
    one.write_text("a: 1\n---\nb: 2\n")
    refused(lambda: load_rig(one), "it holds several YAML documents")
    one.write_text("a: 1\n---\na: 2\n")
    refused(lambda: load_rig(one), "it holds several YAML documents")
    one.write_text("documents: [1, 2]\nother: 3\n")
    refused(lambda: load_rig(one), "the format is unknown")


def test_matrices_that_a_driver_left_empty(tmp_path: Path):
    """A rotation of zeros is none where the images are rectified; else nothing tells it, and it is refused."""
    (_, _, _, P1), (_, _, _, P2) = matrices(samples.RIG)
    paths, nothing = [tmp_path / "l.yaml", tmp_path / "r.yaml"], np.zeros((3, 3))
    for path, P in zip(paths, (P1, P2), strict=True):
        path.write_text(message([P[:, :3], np.zeros(5), nothing, P]))
    np.testing.assert_allclose(load_rig(*paths).extrinsics, [0, 0, 0, -samples.RIG.baseline, 0, 0], atol=1e-12)
    paths[1].write_text(message([P2[:, :3], np.full(5, 0.01), nothing, P2]))
    refused(lambda: load_rig(*paths), "R is 0, and the images are not rectified; calibrate")
    paths[1].write_text(message([nothing, np.zeros(5), np.eye(3), P2]))
    refused(lambda: load_rig(*paths), "K is 0: this camera is not calibrated")


def test_a_new_file_of_both_cameras(tmp_path: Path):
    save_rig(samples.RIG, tmp_path / "both.yaml", format="camera_info")
    again = load_rig(tmp_path / "both.yaml")
    assert again.source.format == "camera_info"
    np.testing.assert_allclose(again.extrinsics, samples.RIG.extrinsics, atol=1e-12)
