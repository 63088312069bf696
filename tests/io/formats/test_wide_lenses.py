"""New files of every format, with lenses of every model that it has a place for: read as what they are, written without
a loss, refused where they have no place."""

import json
import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
import yaml
from every import NEW, SAMPLES, angles, assert_same, beside, new_files, shifts, unit_of
from hypothesis import given, settings, strategies as st
from lenses import WIDE_LENSES
from refusals import refused

from stereorecal import UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_rig, save_rig

HOLDS = {
    "radtan": NEW,
    "equidistant": ("kalibr", "ros", "euroc", "basalt", "depthai", "opencv", "stereorecal"),
    "ds": ("kalibr", "basalt", "stereorecal"),
    "eucm": ("kalibr", "basalt", "stereorecal"),
    "omni": ("kalibr", "stereorecal"),
}
TERMS = {"radtan": samples.LENS, **WIDE_LENSES}
CHANGE = np.array([0.01, 0.02, 0.03, -0.01, 0.001, 0.001])
each = pytest.mark.parametrize(("model", "name"), [(model, name) for model in HOLDS for name in HOLDS[model]])


def rig_of(model: str, extrinsics=samples.RIG.extrinsics, scale: float = 1.0) -> StereoRig:
    lens, matrices = scale * np.array(TERMS[model]), (samples.RIG.left.matrix, samples.RIG.right.matrix)
    left, right = (Camera(samples.SIZE, matrix, lens, model=model) for matrix in matrices)
    return StereoRig(left, right, np.array(extrinsics, float))


@each
@settings(max_examples=max(5, settings.default.max_examples // 12), deadline=None)
@given(angles=angles, shift=shifts, scale=st.floats(0.5, 1.0))
def test_new_files_and_changes_to_them(tmp_path_factory, model: str, name: str, angles, shift, scale: float):
    rig, unit = rig_of(model, [*angles, *shift], scale), unit_of(name)
    paths = new_files(tmp_path_factory.mktemp("new"), name)
    save_rig(rig, paths, format=name)
    again = load_rig(paths, unit=unit)
    assert again.source.format == name
    assert_same(again, rig)
    right = replace(again.right, distortion=np.asarray(again.right.distortion) * 0.9)
    moved = replace(again, right=right, extrinsics=again.extrinsics + np.array([0.01, 0.01, 0.01, -0.01, 0, 0]))
    save_rig(moved, beside(paths))
    found = load_rig(beside(paths), unit=unit)
    assert_same(found, moved)
    np.testing.assert_array_equal(found.left.distortion, again.left.distortion)


@pytest.mark.parametrize(
    ("model", "name"), [(model, name) for model in HOLDS for name in NEW if name not in HOLDS[model]]
)
def test_formats_without_a_place_say_which_have_one(tmp_path: Path, model: str, name: str):
    paths = new_files(tmp_path, name)
    words = f"no place for a lens of the model '{model}'; write it as kalibr"
    refused(lambda: save_rig(rig_of(model), paths, format=name), words)
    assert not any(path.exists() for path in paths)


@pytest.mark.parametrize("name", ["middlebury", "kitti-odometry"])
def test_formats_of_rectified_images(tmp_path: Path, name: str):
    """A pure equidistant lens has coefficients that are all zero, and is no pinhole."""
    cameras = [Camera(samples.SIZE, samples.MATRIX, np.zeros(4), model="equidistant")] * 2
    rig = StereoRig(*cameras, np.array([0, 0, 0, -0.1, 0, 0]))
    refused(lambda: save_rig(rig, tmp_path / "a.txt", format=name), "no place for a rotation or a lens")


NUMBER = re.compile(r"-?\d+\.?\d*(e[-+]?\d+)?")


@each
def test_into_a_copy_of_its_own_file_only_numbers_differ(tmp_path: Path, model: str, name: str):
    """Of every format: words, keys and their order stay, and so do the intrinsics, to the last digit."""
    paths, unit = new_files(tmp_path, name), unit_of(name)
    save_rig(rig_of(model), paths, format=name)
    before = load_rig(paths, unit=unit)
    after = before.with_extrinsics(before.extrinsics + CHANGE)
    save_rig(after, beside(paths))
    found = load_rig(beside(paths), unit=unit)
    assert_same(found, after)
    for old, camera in ((before.left, found.left), (before.right, found.right)):
        np.testing.assert_array_equal(camera.matrix, old.matrix)
        np.testing.assert_array_equal(camera.distortion, old.distortion)
    texts = [(old.read_text(), moved.read_text()) for old, moved in zip(paths, beside(paths), strict=True)]
    assert any(one != other for one, other in texts)
    for one, other in texts:
        assert NUMBER.sub("#", one).split() == NUMBER.sub("#", other).split()


def test_opencvs_own_fisheye_file(tmp_path: Path):
    """What cv2.fisheye.stereoCalibrate leaves has no name of a model, unless one writes OpenCV's own key."""
    path, rig = tmp_path / "stereo.yml", rig_of("equidistant")
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
    refused(lambda: save_rig(rig_of("equidistant"), new, template=path), words)
    assert not new.exists()


def test_lenses_of_two_models(tmp_path: Path):
    rig = replace(rig_of("equidistant"), right=rig_of("ds").right)
    refused(lambda: save_rig(rig, tmp_path / "calib.json"), "'equidistant' and 'ds', but a calib.json has one")
    save_rig(rig, tmp_path / "chain.yaml", format="kalibr")
    assert_same(load_rig(tmp_path / "chain.yaml"), rig)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"distortion_coeffs": [0.1] * 5}, "5 coefficients"),
        ({"distortion_model": "none"}, "there are coefficients"),
        ({"camera_model": "omni"}, "'equidistant' is not supported"),
        ({"camera_model": "omni", "distortion_model": "radtan"}, "intrinsics must hold 5 numbers"),
        ({"camera_model": "pinhole-omni"}, "'pinhole-omni'"),
        ({"camera_model": "ds", "intrinsics": [0.1, 0.5, 60, 60, 32, 24]}, "'equidistant' is not supported"),
        ({"camera_model": "ds", "distortion_model": "none"}, "intrinsics must hold 6 numbers"),
        ({"distortion_coeffs": [-1e4, 0.0, 0.0, 0.0]}, "fold the image back within 5 degrees"),
        ({"distortion_coeffs": [-5.0, 0.0, 0.0, 0.0]}, "degrees off its axis"),
    ],
)
def test_chains_that_are_wrong(tmp_path: Path, change: dict, words: str):
    path = tmp_path / "chain.yaml"
    save_rig(rig_of("equidistant"), path, format="kalibr")
    content = yaml.safe_load(path.read_text())
    content["cam1"] |= change
    path.write_text(yaml.safe_dump(content))
    unsupported = any(word in words for word in ("coefficients", "not supported", "pinhole-omni"))
    kind = {"kind": UnsupportedModelError} if unsupported and "there are" not in words else {}
    refused(lambda: load_rig(path), "chain.yaml", words, **kind)


def test_depthai_uses_four_of_fourteen(tmp_path: Path):
    path = tmp_path / "oak.json"
    save_rig(rig_of("equidistant"), path, format="depthai")
    content = json.loads(path.read_text())
    assert [camera["cameraType"] for _, camera in content["cameraData"]] == [1, 1]
    assert all(len(camera["distortionCoeff"]) == 14 for _, camera in content["cameraData"])
    content["cameraData"][0][1]["cameraType"] = 2
    path.write_text(json.dumps(content))
    refused(lambda: load_rig(path), "neither of the perspective model", kind=UnsupportedModelError)
