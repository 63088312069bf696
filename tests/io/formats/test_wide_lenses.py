"""Lenses that a format has no place for, and files whose lenses are wrong, are refused; others are what they are."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
import yaml
from every import HOLDS, NEW, SAMPLES, assert_same, new_files, of_model
from refusals import refused

from stereorecal import UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_rig, save_rig


@pytest.mark.parametrize(
    ("model", "name"), [(model, name) for model in HOLDS for name in NEW if name not in HOLDS[model]]
)
def test_formats_without_a_place_say_which_have_one(tmp_path: Path, model: str, name: str):
    paths = new_files(tmp_path, name)
    words = f"no place for a lens of the model '{model}'; write it as kalibr"
    refused(lambda: save_rig(of_model(model), paths, format=name), words)
    assert not any(path.exists() for path in paths)


@pytest.mark.parametrize("name", ["middlebury", "kitti-odometry"])
def test_formats_of_rectified_images(tmp_path: Path, name: str):
    """A pure equidistant lens has coefficients that are all zero, and is no pinhole."""
    cameras = [Camera(samples.SIZE, samples.MATRIX, np.zeros(4), model="equidistant")] * 2
    rig = StereoRig(*cameras, np.array([0, 0, 0, -0.1, 0, 0]))
    refused(lambda: save_rig(rig, tmp_path / "a.txt", format=name), "no place for a rotation or a lens")


def test_opencvs_own_fisheye_file(tmp_path: Path):
    """What cv2.fisheye.stereoCalibrate leaves has no name of a model, unless one writes OpenCV's own key."""
    path, rig = tmp_path / "stereo.yml", of_model("equidistant")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for side, camera in (("1", rig.left), ("2", rig.right)):
        storage.write(f"K{side}", np.asarray(camera.matrix))
        storage.write(f"D{side}", np.asarray(camera.distortion))
    storage.write("R", np.asarray(rig.rotation))
    storage.write("T", np.asarray(rig.translation)[:, None])
    storage.write("fisheye_model", 1)
    storage.release()
    assert_same(load_rig(path, size=samples.SIZE, unit="m"), rig)
    path.write_text(path.read_text().replace("fisheye_model: 1", "fisheye_model: 0"))
    assert load_rig(path, size=samples.SIZE, unit="m").left.model == "radtan"


def test_a_lens_of_another_model_goes_into_no_template(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    new = tmp_path / "new.yaml"
    words = "has a lens of the model 'radtan', and the rig one of 'equidistant'"
    refused(lambda: save_rig(of_model("equidistant"), new, template=path), words)
    assert not new.exists()


def test_lenses_of_two_models(tmp_path: Path):
    rig = replace(of_model("equidistant"), right=of_model("ds").right)
    refused(lambda: save_rig(rig, tmp_path / "calib.json"), "'equidistant' and 'ds', but a calib.json has one")
    save_rig(rig, tmp_path / "chain.yaml", format="kalibr")
    assert_same(load_rig(tmp_path / "chain.yaml"), rig)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"distortion_coeffs": [0.1] * 5}, "5 coefficients"),
        ({"distortion_model": "none"}, "there are coefficients"),
        ({"camera_model": "omni"}, "'omni equidistant' is not supported"),
        ({"camera_model": "omni", "distortion_model": "radtan"}, "intrinsics must hold 5 numbers"),
        ({"camera_model": "pinhole-omni"}, "'pinhole-omni equidistant'"),
        ({"camera_model": "ds", "intrinsics": [0.1, 0.5, 60, 60, 32, 24]}, "'ds equidistant' is not supported"),
        ({"camera_model": "ds", "distortion_model": "none"}, "intrinsics must hold 6 numbers"),
        ({"distortion_coeffs": [-1e4, 0.0, 0.0, 0.0]}, "fold the image back within 5 degrees"),
        ({"distortion_coeffs": [-5.0, 0.0, 0.0, 0.0]}, "degrees off its axis"),
    ],
)
def test_chains_that_are_wrong(tmp_path: Path, change: dict, words: str):
    path = tmp_path / "chain.yaml"
    save_rig(of_model("equidistant"), path, format="kalibr")
    content = yaml.safe_load(path.read_text())
    content["cam1"] |= change
    path.write_text(yaml.safe_dump(content))
    unsupported = any(word in words for word in ("coefficients", "not supported", "pinhole-omni"))
    kind = {"kind": UnsupportedModelError} if unsupported and "there are" not in words else {}
    refused(lambda: load_rig(path), "chain.yaml", words, **kind)


def test_depthai_uses_four_of_fourteen(tmp_path: Path):
    path = tmp_path / "oak.json"
    save_rig(of_model("equidistant"), path, format="depthai")
    content = json.loads(path.read_text())
    assert [camera["cameraType"] for _, camera in content["cameraData"]] == [1, 1]
    assert all(len(camera["distortionCoeff"]) == 14 for _, camera in content["cameraData"])
    content["cameraData"][0][1]["cameraType"] = 2
    path.write_text(json.dumps(content))
    refused(lambda: load_rig(path), "the lens model 'cameraType 2' is not supported", kind=UnsupportedModelError)
