"""`diff`: files and folders, what is printed, the JSON, and bad input."""

import json
from pathlib import Path

import numpy as np
import pytest
from trees import kitti_odometry

from stereorecal.io import load_scene, save_rig
from stereorecal.recalibration import difference


@pytest.fixture
def rigs(clean_scene: Path, drifted_scene: Path):
    return [load_scene(folder).rig for folder in (clean_scene, drifted_scene)]


def test_scene_folders(command, clean_scene: Path, drifted_scene: Path, rigs):
    answer = command("diff", clean_scene, drifted_scene)
    assert (answer.code, answer.err) == (0, "")
    *block, legend = answer.out.splitlines()
    assert legend == "epipolar error over the view, depth straight ahead: how wrong the first is if the second is right"
    assert block == str(difference(*rigs)).splitlines()
    assert "pitch +0.800, yaw +0.300, roll -0.900" in answer.out


def test_another_layout(command, tmp_path: Path):
    """A data set without a calib.json; of several sequences it asks for one."""
    sources = kitti_odometry(tmp_path)
    source = sources / "sequences" / "00"
    rig = load_scene(source).rig
    assert rig is not None
    turned = rig.extrinsics + np.radians([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    save_rig(rig.with_extrinsics(turned), tmp_path / "other.json", format="stereorecal")
    answer = command("diff", source, tmp_path / "other.json")
    assert (answer.code, answer.err) == (0, "")
    assert "yaw +0.100" in answer.out
    command("diff", sources, source).refuses("2 sequences are in there")


def test_json(command, clean_scene: Path, drifted_scene: Path, rigs, tmp_path: Path):
    target = tmp_path / "difference.json"
    assert command("diff", clean_scene, drifted_scene, "--json", target).out
    content = json.loads(target.read_text())
    assert list(content)[:4] == ["schema", "versions", "before", "after"]
    assert content["schema"] == "stereorecal.difference/1"
    assert (content["before"], content["after"]) == (str(clean_scene), str(drifted_scene))
    assert {**content, **difference(*rigs).as_dict()} == content
    assert command("diff", clean_scene, drifted_scene, "--json", "-").out == target.read_text()
    assert "NaN" not in target.read_text()


def test_bad_places(command, clean_scene: Path, folder: Path, tmp_path: Path):
    content = json.loads((folder / "calib.json").read_text())
    (folder / "calib.json").write_text(json.dumps({**content, "image_size": [320, 240]}))
    for words, message in (
        ((clean_scene, folder), "the calibrations are for left images of 160x120 and of 320x240; resize one"),
        ((tmp_path, clean_scene), "there is no calibration file in it"),
    ):
        command("diff", *words).refuses(message)
