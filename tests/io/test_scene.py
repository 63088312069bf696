"""Scene folders: what is read, what is refused. Numbers and JSON that are none are refused in their own tests."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from trees import SIZE, refused_scene, texture, write_image

from stereorecal import InputError, UnsupportedModelError
from stereorecal.io import load_scene


def calibration() -> dict[str, Any]:
    """A valid calib.json as written by hand, with keys of its own."""
    matrix = [[20.0, 0.0, 11.5], [0.0, 20.0, 7.5], [0.0, 0.0, 1.0]]
    return {
        "image_size": list(SIZE),
        "K_left": matrix,
        "D_left": [0.1, -0.05, 0.001, 0.002, 0.01],
        "K_right": matrix,
        "D_right": [0.1, -0.05, 0.001, 0.002],
        "distortion_model": "plumb_bob",
        "R": cv2.Rodrigues(np.array([0.01, -0.02, 0.03]))[0].tolist(),
        "T": [-0.1, 0.001, 0.002],
        "baseline_m": 0.10002499687578103,
        "rectified": False,
        "max_disparity_px": 12,
        "disparity_gt": None,
        "notes": {"weather": ["sun", "große Hitze"]},
    }


UNCALIBRATED = dict.fromkeys(("K_left", "D_left", "K_right", "D_right", "R", "T", "distortion_model"))
Make = Callable[..., Path]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Writes a scene folder; keyword arguments replace keys of its calib.json (`...` removes one)."""

    def make(frames: int = 1, **changes: Any) -> Path:
        folder = tmp_path / "recordings" / "garden"
        for index in range(frames):
            name = "" if frames == 1 else f"/{index}"
            write_image(folder / f"left{name}.png", 2 * index)
            write_image(folder / f"right{name}.png", 2 * index + 1)
        content = {key: value for key, value in (calibration() | changes).items() if value is not ...}
        (folder / "calib.json").write_text(json.dumps(content), encoding="utf-8")
        return folder

    return make


# --- reading ------------------------------------------------------------------------------------------------


def test_one_pair(make: Make):
    scene = load_scene(make())
    assert scene.name == "recordings/garden"
    assert scene.reference == "stored"
    assert len(scene.pairs) == 1
    np.testing.assert_array_equal(scene.pairs[0].right, texture(1))
    rig, stated = scene.rig, calibration()
    assert rig is not None
    assert rig.left.size == rig.right.size == SIZE
    for side, camera in (("left", rig.left), ("right", rig.right)):
        np.testing.assert_array_equal(camera.matrix, stated[f"K_{side}"])
        np.testing.assert_array_equal(camera.distortion, stated[f"D_{side}"])
    np.testing.assert_allclose(rig.rotation, stated["R"], atol=1e-15)
    np.testing.assert_array_equal(rig.translation, stated["T"])
    assert dict(scene.info) == {key: stated[key] for key in ("rectified", "max_disparity_px", "disparity_gt", "notes")}


def test_frames_in_natural_order_and_limit(make: Make):
    folder = make(frames=12)
    scene = load_scene(str(folder))
    assert [pair.name for pair in scene.pairs] == [f"{i}.png" for i in range(12)]
    np.testing.assert_array_equal(scene.pairs[11].right, texture(23))
    assert len(pickle.dumps(scene)) < 10_000  # pairs travel as paths
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(scene)).pairs[3].left, scene.pairs[3].left)
    assert [pair.name for pair in load_scene(folder, limit=2).pairs] == ["0.png", "1.png"]
    with pytest.raises(InputError, match="limit of 0"):
        load_scene(folder, limit=0)


def test_relative_folder_gets_its_full_name(make: Make, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(make())
    assert load_scene(".").name == "recordings/garden"


def test_without_calibration(make: Make):
    assert load_scene(make(**UNCALIBRATED)).rig is None
    refused_scene(make(**UNCALIBRATED, image_size=[20, 20]), "20x20", about="garden")


@pytest.mark.parametrize(
    "model",
    ["opencv", "OpenCV (k1 k2 p1 p2 k3 [k4 k5 k6 ...]); zeros = rectified", "Plumb_Bob", "rational_polynomial",
     "radtan", "none", "", None, ..., "opencv5"],
)  # fmt: skip
def test_names_of_the_pinhole_model(make: Make, model: Any):
    assert load_scene(make(distortion_model=model)).rig.left.model == "radtan"


@pytest.mark.parametrize(
    "model",
    ["equidistant", "fisheye", "opencv_fisheye", "OpenCV (fisheye)", "kb4", "equidistant (Kannala-Brandt k1 k2 k3 k4)"],
)
def test_names_of_opencvs_fisheye(make: Make, model: Any):
    rig = load_scene(make(distortion_model=model, D_left=[0.1, 0, 0, 0], D_right=[0, 0, 0, 0])).rig
    assert rig.left.model == rig.right.model == "equidistant"
    refused_scene(make(distortion_model=model, D_left=[0.1, 0, 0, 0, 0]), "5 coefficients", UnsupportedModelError)


@pytest.mark.parametrize("model", ["omnidir", "opencv omni", "equirectangular", "fov", 4])
def test_other_models_are_unsupported(make: Make, model: Any):
    refused_scene(make(distortion_model=model), "lens model .* is not supported", UnsupportedModelError)


@pytest.mark.parametrize("distortion", [None, [], [[]]])
def test_no_distortion(make: Make, distortion: Any):
    assert load_scene(make(D_left=distortion)).rig.left.distortion.shape == (0,)


def test_rows_columns_and_a_byte_order_mark(make: Make):
    row, column = [calibration()["D_left"]], [[value] for value in calibration()["T"]]
    path = make(D_left=row, T=column, image_size=[24.0, 16.0]) / "calib.json"
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    rig = load_scene(path.parent).rig
    np.testing.assert_array_equal(rig.left.distortion, row[0])
    np.testing.assert_array_equal(rig.translation, calibration()["T"])


# --- bad input ----------------------------------------------------------------------------------------------


def test_missing_folder_and_files(make: Make, tmp_path: Path):
    refused_scene(tmp_path / "nowhere", "no such folder", about="nowhere")
    folder = make()
    refused_scene(folder / "calib.json", "this is a file; give the folder")
    (folder / "left.png").unlink()
    refused_scene(folder, r"no image left\.\*", about="garden")
    (folder / "calib.json").write_text("[1, 2]")
    refused_scene(folder, "no JSON object")
    (folder / "calib.json").unlink()
    refused_scene(folder, "no such file")
    (folder / "calib.json").mkdir()
    refused_scene(folder, "calib.json: cannot be read")


@pytest.mark.parametrize("key", ["image_size", "K_left", "K_right", "D_left", "D_right", "R", "T"])
def test_keys_that_are_missing_or_no_numbers(make: Make, key: str):
    refused_scene(make(**{key: ...}), f"the key '{key}' is missing")
    refused_scene(make(**{key: ["x"]}), f"{key} is not an array of numbers")


@pytest.mark.parametrize(
    ("written", "words"),
    [
        (
            {"distortion_model": ..., "distorsion_model": "equidistant"},
            "the key 'distorsion_model' is not known; rename it if 'distortion_model' is meant",
        ),
        ({"D_left": ..., "D_lefft": [0.0] * 5}, "the key 'D_left' is missing; rename 'D_lefft' if that is meant"),
    ],
)
def test_keys_that_are_misspelt(make: Make, written: dict[str, object], words: str):
    refused_scene(make(**written), words)


@pytest.mark.parametrize(
    "written",
    [
        {"readout": 0.01, "references": ["a paper"]},
        {"distorsion_model": "kept, since the key itself is there"},
    ],
)
def test_keys_that_are_only_like_others(make: Make, written: dict[str, object]):
    assert load_scene(make(**written)).info.items() >= written.items()


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("K_left", [[0, 0, 11], [0, 20, 7], [0, 0, 1]], "left camera: .*singular or negative"),
        ("K_left", None, "K_left contains null"),
        ("R", [[1, 0, 0], [0, 1, 0], [0, 1e200, 1]], "R is not a rotation"),  # and nothing overflows
        ("T", [0, 0, 0], "baseline is zero"),
    ],
)
def test_values_that_are_no_calibration(make: Make, key: str, value: Any, words: str):
    refused_scene(make(**{key: value}), words)


def test_wrong_number_of_coefficients(make: Make):
    refused_scene(make(D_right=[0.0] * 3), "right camera: .*3 coefficients", UnsupportedModelError)


def test_bad_images_are_named(make: Make):
    folder = make(frames=3)
    path = folder / "right" / "1.png"
    path.write_bytes(path.read_bytes()[:-30])
    refused_scene(folder, "image is truncated", about=str(path))
    assert len(load_scene(folder, limit=1).pairs) == 1
    write_image(path, 0, (20, 16))
    refused_scene(folder, "24x16 and the right one 20x16", about=str(path))
    write_image(folder / "left" / "1.png", 1, (20, 16))
    refused_scene(folder, "1.png: the images are 20x16, but the calibration is for 24x16", about=str(folder))


def test_images_without_partner(make: Make):
    """Neither are other names matched by their order."""
    folder = make(frames=3)
    (folder / "left" / "1.png").unlink()
    refused_scene(folder, "no partner on the left", about=str(folder / "right" / "1.png"))
    (folder / "right" / "2.png").unlink()  # equal counts, different names
    refused_scene(folder, "no partner on the right", about=str(folder / "left" / "2.png"))
    (folder / "right" / "1.png").rename(folder / "right" / "x.png")
    (folder / "right" / "0.png").rename(folder / "right" / "y.png")
    refused_scene(folder, "no partner on the right", about="0.png")


def test_two_readings_of_one_side(make: Make):
    folder = make()
    (folder / "notes.txt").write_text("left.txt and the like do no harm")
    (folder / "left.txt").write_text("not an image")
    load_scene(folder)
    write_image(folder / "left.jpg", 0)
    refused_scene(folder, r"both left\.jpg and left\.png are there", about="garden")
    (folder / "left.jpg").unlink()
    write_image(folder / "left" / "0.png", 0)
    refused_scene(folder, r"both left\.png and left.0\.png are there", about="garden")
