"""A calibration alone: what is written comes back, the rest is carried along, nothing is overwritten."""

import json
from pathlib import Path

import numpy as np
import pytest
from gathered import gathered
from refusals import refused

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_rig, load_scene, save_rig, save_scene

SIZE = (160, 120)
MATRIX = np.array([[150.1, 0, 79.3], [0, 149.9, 60.7], [0, 0, 1]])
RIG = StereoRig(
    Camera(SIZE, MATRIX, np.array([0.1, -0.02, 1 / 3, 1e-7, 0.0])),
    Camera(SIZE, MATRIX + 0.0),
    np.array([0.01, -0.02, 0.03, -0.356, 0.004, -0.003]),
)


def test_the_file_says_what_a_scene_folder_says(tmp_path: Path):
    save_rig(RIG, tmp_path / "c.json")
    content = json.loads((tmp_path / "c.json").read_text())
    assert set(content) == {
        "image_size", "K_left", "D_left", "K_right", "D_right", "distortion_model", "R", "T", "baseline_m"
    }  # fmt: skip
    np.testing.assert_allclose(content["R"], RIG.rotation, atol=1e-15)
    assert content["T"] == [-0.356, 0.004, -0.003]
    assert content["baseline_m"] == pytest.approx(np.linalg.norm([0.356, 0.004, 0.003]), abs=1e-12)


def test_other_keys_are_carried_along(scene, tmp_path: Path):
    save_scene(scene(), tmp_path / "s")
    path = tmp_path / "s" / "calib.json"
    others = {"notes": {"weather": ["sun", "große Hitze"]}, "rectified": False, "disparity_gt": None}
    path.write_text(json.dumps(json.loads(path.read_text()) | others | {"reference": "truth"}))
    before = load_scene(tmp_path / "s")
    save_rig(RIG, path, {**before.info, "T": [9, 9, 9]}, overwrite=True)
    after = load_scene(tmp_path / "s")
    assert after.info == before.info
    assert others.items() <= after.info.items()
    assert after.rig is not None
    np.testing.assert_allclose(after.rig.extrinsics, RIG.extrinsics, rtol=0, atol=1e-12)
    assert before.reference == "truth"
    assert after.reference == "stored"  # a repaired rig is no truth


def test_one_file_has_one_size(tmp_path: Path):
    smaller = StereoRig(RIG.left, RIG.right.resized((80, 60)), RIG.extrinsics)
    refused(lambda: save_rig(smaller, tmp_path / "c.json"), "one size of images for both cameras")
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path):
    refused(lambda: save_rig(RIG, tmp_path / "c.json", {"a": float("nan")}), "finite")
    refused(lambda: save_rig(RIG, tmp_path / "missing" / "c.json"), "cannot be written")
    assert not list(tmp_path.iterdir())


def test_a_file_without_a_calibration_is_no_rig(tmp_path: Path):
    path = tmp_path / "c.json"
    path.write_text(json.dumps({"image_size": [4, 4], "K_left": None, "K_right": None}))
    refused(lambda: load_rig(path), "c.json: the camera matrices are null")


def test_files_that_lie_anywhere_are_the_scene_that_a_folder_is(scene, tmp_path: Path):
    save_scene(scene("street", frames=2), tmp_path / "s")
    path = tmp_path / "s" / "calib.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"boat": "Ladja"}))
    whole = load_scene(tmp_path / "s")
    path.rename(tmp_path / "elsewhere.json")
    pattern = str(tmp_path / "s" / "left" / "*.png")
    found = gathered(pattern, tmp_path / "s" / "right", tmp_path / "elsewhere.json")
    assert found.name == pattern
    assert (found.info, found.reference) == (whole.info, whole.reference)
    assert (found.info["boat"], found.reference) == ("Ladja", "truth")
    assert found.rig is not None
    assert whole.rig is not None
    np.testing.assert_array_equal(found.rig.extrinsics, whole.rig.extrinsics)
    assert len(found.pairs) == 2
    for one, two in zip(found.pairs, whole.pairs, strict=True):
        np.testing.assert_array_equal(one.right, two.right)


def test_files_that_do_not_fit_are_blamed_by_name(scene, tmp_path: Path):
    """What is wrong with images alone is no fault of the calibration."""
    save_scene(scene(), tmp_path / "s")
    save_rig(RIG.resized((80, 60)), tmp_path / "c.json")
    places = (tmp_path / "s" / "left.png", tmp_path / "s" / "right.png", tmp_path / "c.json")
    refused(lambda: gathered(*places), "c.json: ", "the images are 160x120, but the calibration is for 80x60")
    copy = tmp_path / "copy.png"
    copy.write_bytes(places[0].read_bytes())
    words = f"^{places[0]} and {copy}: left and right are the same image"
    with pytest.raises(InputError, match=words):
        gathered(places[0], copy, tmp_path / "s" / "calib.json")
