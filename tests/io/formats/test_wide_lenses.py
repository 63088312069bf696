"""Files of fisheye and other wide lenses: read as what they are, written without a loss, refused where they have no
place."""

import json
import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import samples
from every import SAMPLES
from hypothesis import given, settings, strategies as st
from lenses import WIDE_LENSES

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig, same_rig
from stereorecal.io import load_rig, save_rig

HOLDS = {
    "equidistant": ("kalibr", "ros", "euroc", "basalt", "depthai", "opencv", "stereorecal"),
    "ds": ("kalibr", "basalt", "stereorecal"),
    "eucm": ("kalibr", "basalt", "stereorecal"),
    "omni": ("kalibr", "stereorecal"),
}
EVERY = ("kalibr", "ros", "euroc", "basalt", "depthai", "opencv", "stereorecal", "boofcv", "kitti-raw")
ENDINGS = {"basalt": ".json", "depthai": ".json", "stereorecal": ".json", "kitti-raw": ".txt"}
FISHEYE = [-0.02, -0.007, 0.002, -0.001]


def rig_of(model: str, extrinsics=(0.01, -0.02, 0.03, -0.12, 0.001, -0.002), scale: float = 1.0) -> StereoRig:
    lens = scale * np.array(WIDE_LENSES[model])
    cameras = [
        Camera(samples.SIZE, camera.matrix, lens, model=model) for camera in (samples.RIG.left, samples.RIG.right)
    ]
    return StereoRig(*cameras, np.array(extrinsics, float))


def places(folder: Path, name: str) -> list[Path]:
    return [folder / f"new{index}{ENDINGS.get(name, '.yaml')}" for index in range(2 if name in ("ros", "euroc") else 1)]


def place_of(paths: list[Path]):
    return paths[0] if len(paths) == 1 else tuple(paths)


@pytest.mark.parametrize(("model", "name"), [(model, name) for model in HOLDS for name in HOLDS[model]])
@settings(max_examples=5, deadline=None)
@given(angles=st.tuples(*[st.floats(-0.3, 0.3)] * 3), scale=st.floats(0.5, 1.0))
def test_new_files_and_changes_to_them(tmp_path_factory, model: str, name: str, angles, scale: float):
    folder, rig = tmp_path_factory.mktemp("wide"), rig_of(model, [*angles, -0.12, 0.001, -0.002], scale)
    paths = places(folder, name)
    save_rig(rig, place_of(paths), format=name)
    again = load_rig(*paths, unit="m" if name == "opencv" else None)
    assert (again.source.format, again.left.model, again.right.model) == (name, model, model)
    assert same_rig(rig, again)
    terms = dict.fromkeys(("distortion",), np.asarray(again.right.distortion) * 0.9)
    moved = replace(again, right=replace(again.right, **terms), extrinsics=again.extrinsics + 0.01)
    others = [path.with_stem(f"moved-{path.stem}") for path in paths]
    save_rig(moved, place_of(others))
    found = load_rig(*others, unit="m" if name == "opencv" else None)
    assert same_rig(moved, found)
    np.testing.assert_array_equal(found.left.distortion, again.left.distortion)


@pytest.mark.parametrize(
    ("model", "name"), [(model, name) for model in HOLDS for name in EVERY if name not in HOLDS[model]]
)
def test_formats_without_a_place_say_which_have_one(tmp_path: Path, model: str, name: str):
    paths = places(tmp_path, name)
    with pytest.raises(InputError, match=rf"no place for a lens of the model '{model}'; write it as kalibr") as raised:
        save_rig(rig_of(model), place_of(paths), format=name)
    assert str(raised.value).count("\n") == 0
    assert not any(path.exists() for path in paths)


@pytest.mark.parametrize("name", ["middlebury", "kitti-odometry"])
def test_formats_of_rectified_images(tmp_path: Path, name: str):
    """A pure equidistant lens has coefficients that are all zero, and is no pinhole."""
    cameras = [Camera(samples.SIZE, samples.MATRIX, np.zeros(4), model="equidistant")] * 2
    with pytest.raises(InputError, match="no place for a rotation or a lens"):
        save_rig(StereoRig(*cameras, np.array([0, 0, 0, -0.1, 0, 0])), tmp_path / "a.txt", format=name)


@pytest.mark.parametrize(("name", "old"), [("kalibr", "radtan"), ("ros", "plumb_bob"), ("euroc", "radial-tangential")])
def test_only_lines_with_numbers_of_the_extrinsics_differ(tmp_path: Path, name: str, old: str):
    texts = [text.replace(f"distortion_model: {old}", "distortion_model: equidistant") for text in SAMPLES[name].texts]
    texts = [
        text.replace("cols: 5\n  data: [-0.3, 0.1, 0.001, -0.002, 0.0]", f"cols: 4\n  data: {FISHEYE}")
        for text in texts
    ]
    sample = replace(
        SAMPLES[name], texts=tuple(text.replace("[-0.3, 0.1, 0.001, -0.002]", str(FISHEYE)) for text in texts)
    )
    paths = sample.write(tmp_path)
    before = load_rig(*paths)
    assert before.left.model == "equidistant"
    np.testing.assert_array_equal(before.left.distortion, FISHEYE)
    after = before.with_extrinsics(before.extrinsics + np.array([0.01, 0.02, 0.03, -0.01, 0.001, 0.001]))
    new = [tmp_path / f"new-{path.name}" for path in paths]
    save_rig(after, place_of(new))
    assert same_rig(load_rig(*new), after)
    for text, path in zip(sample.texts, new, strict=True):
        pairs = list(zip(text.splitlines(), path.read_text().splitlines(), strict=True))
        differ = [pair for pair in pairs if pair[0] != pair[1]]
        assert len(differ) < 0.4 * len(pairs)
        assert all(any(digit in line for digit in "0123456789") for line, _ in differ)
        assert not any(word in line for line, _ in differ for word in ("distortion", "intrinsics", "resolution"))


NUMBER = re.compile(r"-?\d+\.?\d*(e[-+]?\d+)?")


@pytest.mark.parametrize(("model", "name"), [(model, name) for model in HOLDS for name in HOLDS[model]])
def test_into_a_copy_of_its_own_file_only_numbers_differ(tmp_path: Path, model: str, name: str):
    """Of every format: words, keys and their order stay, and so do the intrinsics, to the last digit."""
    paths = places(tmp_path, name)
    save_rig(rig_of(model), place_of(paths), format=name)
    before = load_rig(*paths, unit="m" if name == "opencv" else None)
    after = before.with_extrinsics(before.extrinsics + np.array([0.01, 0.02, 0.03, -0.01, 0.001, 0.001]))
    new = [path.with_stem(f"moved-{path.stem}") for path in paths]
    save_rig(after, place_of(new))
    found = load_rig(*new, unit="m" if name == "opencv" else None)
    assert same_rig(found, after)
    for old_camera, camera in ((before.left, found.left), (before.right, found.right)):
        np.testing.assert_array_equal(camera.matrix, old_camera.matrix)
        np.testing.assert_array_equal(camera.distortion, old_camera.distortion)
    texts = [(old.read_text(), moved.read_text()) for old, moved in zip(paths, new, strict=True)]
    assert any(one != other for one, other in texts)
    for one, other in texts:
        assert NUMBER.sub("#", one).split() == NUMBER.sub("#", other).split()


def test_opencvs_own_fisheye_file(tmp_path: Path):
    """What cv2.fisheye.stereoCalibrate leaves has no name of a model, unless one writes OpenCV's own key."""
    path, rig = tmp_path / "stereo.yml", rig_of("equidistant")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for key, item in {
        "K1": rig.left.matrix,
        "D1": rig.left.distortion,
        "K2": rig.right.matrix,
        "D2": rig.right.distortion,
    }.items():
        storage.write(key, np.asarray(item))
    storage.write("R", np.asarray(rig.rotation))
    storage.write("T", np.asarray(rig.translation)[:, None])
    storage.write("fisheye_model", 1)
    storage.release()
    found = load_rig(path, size=samples.SIZE, unit="m")
    assert same_rig(found, rig)
    text = path.read_text().replace("fisheye_model: 1", "fisheye_model: 0")
    path.write_text(text)
    assert load_rig(path, size=samples.SIZE, unit="m").left.model == "radtan"


def test_a_lens_of_another_model_goes_into_no_template(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    with pytest.raises(InputError, match="has a lens of the model 'radtan', and the rig one of 'equidistant'"):
        save_rig(rig_of("equidistant"), tmp_path / "new.yaml", template=path)
    assert not (tmp_path / "new.yaml").exists()


def test_lenses_of_two_models(tmp_path: Path):
    rig = replace(rig_of("equidistant"), right=rig_of("ds").right)
    with pytest.raises(InputError, match=r"'equidistant' and 'ds', but a calib\.json has one"):
        save_rig(rig, tmp_path / "calib.json")
    save_rig(rig, tmp_path / "chain.yaml", format="kalibr")
    assert same_rig(load_rig(tmp_path / "chain.yaml"), rig)


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
        ({"distortion_coeffs": [-1e4, 0.0, 0.0, 0.0]}, "within 5 degrees"),
    ],
)
def test_chains_that_are_wrong(tmp_path: Path, change: dict, words: str):
    path = tmp_path / "chain.yaml"
    save_rig(rig_of("equidistant"), path, format="kalibr")
    from yaml import safe_dump, safe_load

    content = safe_load(path.read_text())
    content["cam1"] |= change
    path.write_text(safe_dump(content))
    with pytest.raises(InputError, match=words) as raised:
        load_rig(path)
    assert "chain.yaml" in str(raised.value)


def test_depthai_uses_four_of_fourteen(tmp_path: Path):
    path, rig = tmp_path / "oak.json", rig_of("equidistant")
    save_rig(rig, path, format="depthai")
    content = json.loads(path.read_text())
    assert [camera["cameraType"] for _, camera in content["cameraData"]] == [1, 1]
    assert all(len(camera["distortionCoeff"]) == 14 for _, camera in content["cameraData"])
    content["cameraData"][0][1]["cameraType"] = 2
    path.write_text(json.dumps(content))
    with pytest.raises(UnsupportedModelError, match="neither of the perspective model"):
        load_rig(path)
