"""Rigs whose cameras stand one above the other, or with one upside down: files are read and written as they are, and
what matches images turns both."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
from every import STANDS, assert_same, new_files
from refusals import refused

from stereorecal import CalibrationWarning
from stereorecal.geometry import StereoRig, same_rig
from stereorecal.io import gather_scene, load_log, load_rig, load_scene, save_rig, save_scene

RIG = samples.rig_of([0.02, -0.03, 0.01, -0.12, 0.004, -0.003])
CHANGE = np.array([0.01, 0.02, -0.03, -0.01, 0.001, 0.002])
each_stand = pytest.mark.parametrize("turns", STANDS.values(), ids=STANDS)
each_above = pytest.mark.parametrize("turns", [(1, 1), (3, 3)])
pytestmark = pytest.mark.filterwarnings("ignore:.*(translation is taken|turned by)")


@each_above
def test_derived_matrices_of_cameras_one_above_the_other(tmp_path: Path, turns: tuple[int, int]):
    """As OpenCV computes them; and R and T are read from them alone."""
    path = tmp_path / "0.yaml"
    save_rig(replace(RIG, turns=turns), path, format="opencv")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    K1, D1, K2, D2, R, T = (storage.getNode(key).mat() for key in ("K1", "D1", "K2", "D2", "R", "T"))
    made = cv2.stereoRectify(K1, D1, K2, D2, samples.SIZE[::-1], R, T, alpha=1.0)
    for key, matrix in zip(("R1", "R2", "P1", "P2", "Q"), made[:5], strict=True):
        np.testing.assert_allclose(storage.getNode(key).mat(), matrix, rtol=0, atol=1e-6, err_msg=key)
    path.write_text(path.read_text().replace("\nR:", "\nR_:").replace("\nT:", "\nT_:"))
    found = load_rig(path, unit="m")
    np.testing.assert_allclose(found.rotation, R, atol=1e-9)
    np.testing.assert_allclose(found.translation, T[:, 0], atol=1e-9)


@each_above
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


@each_stand
def test_images_are_turned_with_the_calibration(tmp_path: Path, scene, turns: tuple[int, int]):
    rendered = scene("street", 0, (320, 240))
    plain = gather_scene(*stood(tmp_path / "plain", rendered, (0, 0)))
    places = stood(tmp_path / "turned", rendered, turns)
    with pytest.warns(CalibrationWarning, match="turned by"):
        turned = gather_scene(*places)
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
