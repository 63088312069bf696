"""Middlebury: millimetres, doffs, one scene and many."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from field_trees import MIDDLEBURY, middlebury, middlebury_scene
from trees import SIZE, cut, edit, refused, write_image, write_text

from stereorecal import CalibrationWarning
from stereorecal.io import load_log, load_scene


def test_a_folder_of_scenes(tmp_path: Path):
    log = load_log(middlebury(tmp_path))
    assert log.name == f"{tmp_path.name}/trainingQ"
    assert [mission.name for mission in log.missions] == ["Adirondack", "Motorcycle"]
    assert [[pair.name for pair in mission.pairs] for mission in log.missions] == [["im0.png"], ["im0.png"]]
    assert list(log.calibrations) == ["stored"]
    folder = tmp_path / "trainingQ"
    assert log.missions[1].pairs[0].origin[1][:2] == tuple(str(folder / f"Motorcycle/im{i}.png") for i in (0, 1))
    edit(folder / "Motorcycle" / "calib.txt", "baseline=193.001", "baseline=150")
    log = load_log(folder)
    assert {name: rig.translation[0] for name, rig in log.calibrations.items()} == {
        "Adirondack": -0.193001,
        "Motorcycle": -0.15,
    }
    assert [mission.calibration for mission in log.missions] == ["Adirondack", "Motorcycle"]


def test_scenes_that_differ_in_size_only_share_no_calibration(tmp_path: Path):
    folder = middlebury(tmp_path)
    for name in ("im0.png", "im1.png"):
        write_image(folder / "Motorcycle" / name, len(name) + int(name[2]), (20, 16))
    edit(folder / "Motorcycle" / "calib.txt", "width=24", "width=20")
    assert list(load_log(folder).calibrations) == ["Adirondack", "Motorcycle"]


def test_the_calibration(tmp_path: Path):
    rig = load_scene(middlebury_scene(tmp_path)).rig
    assert rig.left.size == rig.right.size == SIZE
    np.testing.assert_array_equal(rig.left.matrix, [[21.5, 0, 10.25], [0, 21.5, 7.5], [0, 0, 1]])
    np.testing.assert_array_equal(rig.right.matrix, [[21.5, 0, 12.75], [0, 21.5, 7.5], [0, 0, 1]])
    assert rig.left.distortion.size == rig.right.distortion.size == 0
    np.testing.assert_array_equal(rig.extrinsics, [0, 0, 0, -0.193001, 0, 0])


def test_depth_is_as_the_authors_say(tmp_path: Path):
    """Z = baseline f / (d + doffs), with d = x_left - x_right."""
    rig = load_scene(middlebury_scene(tmp_path)).rig
    points = np.array([[0.1, 0.2, 1.0], [-0.5, 0.3, 2.0], [0.4, -0.1, 7.5]])
    left = rig.left.project(points)
    right = cv2.projectPoints(points, rig.rotation, rig.translation, rig.right.matrix, None)[0][:, 0]
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-12)
    np.testing.assert_allclose(0.193001 * 21.5 / (left[:, 0] - right[:, 0] + 2.5), points[:, 2])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("cam1=", "cam2=", "'cam1' is missing"),
        ("baseline=193.001\n", "", "'baseline' is missing"),
        ("baseline=193.001", "baseline=", "baseline must hold one number, not 0"),
        ("baseline=193.001", "baseline=nan", "baseline contains NaN"),
        ("baseline=193.001", "baseline=193 mm", "baseline is not an array of numbers"),
        ("baseline=193.001", "baseline=193 1", "baseline must hold one number, not 2"),
        ("baseline=193.001", "baseline=1e999", "baseline contains NaN or infinite"),
        ("baseline=193.001", "baseline=19_3", "baseline is not an array of numbers"),
        ("width=24", "width=inf", "width contains NaN or infinite"),
        ("width=24", "width=1e300", "width is 1e+300, but an image size"),
        ("baseline=193.001", "baseline=0", "baseline is zero"),
        ("baseline=193.001", "baseline=-193", "left and right are exchanged"),
        ("[21.5 0 12.75; 0 21.5 7.5; 0 0 1]", "[21.5 0 12.75; 0 21.5 7.5]", "cam1 must hold 3x3 numbers, not 2x3"),
        ("[21.5 0 12.75; 0 21.5 7.5; 0 0 1]", "[21.5 0 12.75; 0 21", "cam1 is not an array of numbers"),
        ("[21.5 0 12.75", "[0 0 12.75", "singular or negative"),
        ("width=24", "width=0", "image size"),
        ("width=24", "width=24.5", "width is 24.5, but an image size"),
    ],
)
def test_bad_calibrations(tmp_path: Path, old: str, new: str, words: str):
    path = middlebury_scene(tmp_path) / "calib.txt"
    edit(path, old, new)
    refused(tmp_path, str(path), words)


def test_missing_and_broken_files(tmp_path: Path):
    folder = middlebury(tmp_path)
    path = folder / "Motorcycle" / "calib.txt"
    cut(path, "height")
    refused(folder, str(path), "'height' is missing")
    path.write_text("")
    refused(folder, str(path), "empty")
    path.unlink()
    refused(folder, str(path), "no such file")
    write_text(path, MIDDLEBURY.replace("width=24", "width=48"))
    refused(folder, "Motorcycle", "24x16, but the calibration is for 48x16")


def test_a_data_set_whose_unit_is_wrong(tmp_path: Path):
    """Middlebury's millimetres, given in micrometres."""
    folder = middlebury(tmp_path) / "Motorcycle"
    edit(folder / "calib.txt", "baseline=193.001", "baseline=193001")
    for read in (load_log, load_scene):
        with pytest.warns(CalibrationWarning, match="the baseline is 193") as found:
            read(folder)
        assert len(found) == 1


def test_the_real_one(data_dir: Path, tmp_path: Path):
    scene, folder = data_dir / "middlebury2014" / "motorcycle_quarter", tmp_path / "Motorcycle-perfect"
    folder.mkdir()
    (folder / "im0.png").symlink_to(scene / "left.png")
    (folder / "im1.png").symlink_to(scene / "right.png")
    write_text(
        folder / "calib.txt",
        "cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]\ncam1=[994.978 0 342.279; 0 994.978 254.877; 0 0 1]\n"
        "doffs=31.086\nbaseline=193.001\nwidth=741\nheight=500\nndisp=70\n",
    )
    found, expected = load_scene(folder), load_scene(scene)
    content = json.loads((scene / "calib.json").read_text())
    np.testing.assert_array_equal(found.rig.left.matrix, content["K_left"])
    np.testing.assert_array_equal(found.rig.right.matrix, content["K_right"])
    np.testing.assert_array_equal(found.rig.extrinsics, expected.rig.extrinsics)
    np.testing.assert_array_equal(found.pairs[0].left, expected.pairs[0].left)
