"""MODD2 and MODS: names, partners, millimetres, and what is refused."""

import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from field_trees import OPENCV_STEREO, modd2, modd2_sequence, mods
from hypothesis import given, settings, strategies as st
from trees import SIZE, cut, edit, refused, write_image, write_text

from stereorecal import InputError, UnsupportedModelError
from stereorecal.geometry import rotation_from_vector
from stereorecal.io import load_log, load_scene


def test_modd2(tmp_path: Path):
    log = load_log(modd2(tmp_path))
    names = ["kope67-00-00000025-00000200", "kope71-01-00000040-00000340"]
    assert [mission.name for mission in log.missions] == names
    assert list(log.calibrations) == ["stored"]  # both files say the same
    for mission in log.missions:
        assert [pair.name for pair in mission.pairs] == ["00000025L.jpg", "00000026L.jpg"]
    pair = log.missions[1].pairs[1]
    frames = tmp_path / "video_data" / names[1] / "frames"
    assert pair.origin[1][:2] == (str(frames / "00000026L.jpg"), str(frames / "00000026R.jpg"))
    np.testing.assert_array_equal(pair.right, cv2.imread(str(frames / "00000026R.jpg"), cv2.IMREAD_UNCHANGED))


def test_the_calibration(tmp_path: Path):
    rig = load_scene(modd2_sequence(tmp_path / "kope67-00-00000025-00000200")).rig
    assert rig.left.size == rig.right.size == SIZE
    np.testing.assert_array_equal(rig.left.matrix, [[21, 0, 11.5], [0, 21.5, 7.25], [0, 0, 1]])
    np.testing.assert_array_equal(rig.right.matrix, [[20, 0, 12.5], [0, 20.5, 8.25], [0, 0, 1]])
    np.testing.assert_array_equal(rig.left.distortion, [-0.3, 0.1, 0.001, -0.002, 0.015])
    np.testing.assert_array_equal(rig.right.distortion, [-0.2, 0.05, 0, 0.001])
    np.testing.assert_allclose(rig.rotation, cv2.Rodrigues(np.array([0, -0.01, 0]))[0], atol=1e-6)
    np.testing.assert_allclose(rig.translation, [-0.356, 0.0025, -0.00125], rtol=1e-15)  # metres


def test_different_calibrations_are_named_after_the_first_sequence_that_has_them(tmp_path: Path):
    root = modd2(tmp_path)
    third = modd2_sequence(root / "video_data" / "kope75-00-00000001-00000100")
    edit(third / "calibration.yaml", "-356.", "-357.")
    modd2_sequence(root / "video_data" / "kope82-00-00000001-00000100")
    log = load_log(root)
    assert list(log.calibrations) == ["kope67-00-00000025-00000200", "kope75-00-00000001-00000100"]
    assert [mission.calibration[:6] for mission in log.missions] == ["kope67", "kope67", "kope75", "kope67"]
    assert log.calibration_of(log.missions[2]).translation[0] == -0.357


def test_mods(tmp_path: Path):
    log = load_log(mods(tmp_path))
    names = ["kope100-00006790-00007090", "kope100-00011830-00012500", "stru02-00118250-00118800"]
    assert [mission.name for mission in log.missions] == names
    assert [mission.calibration for mission in log.missions] == [names[0], names[0], names[2]]
    assert [rig.translation[0] for rig in log.calibrations.values()] == [-0.356, -0.3]
    assert [pair.name for pair in log.missions[0].pairs] == ["00006790L.jpg", "00006800L.jpg"]
    assert [pair.name for pair in log.missions[2].pairs] == ["00118250L.jpg"]


def test_mods_without_a_calibration(tmp_path: Path):
    path = mods(tmp_path) / "calibration" / "calibration-kope100.yaml"
    path.unlink()
    refused(tmp_path, str(path), "no such file")


def test_the_size_may_be_that_of_the_images(tmp_path: Path):
    """OpenCV's own files have none."""
    folder = modd2_sequence(tmp_path)
    edit(folder / "calibration.yaml", "imageSize: [ 24, 16 ]\n", "")
    assert load_scene(folder).rig.left.size == SIZE
    write_text(folder / "calibration.yaml", OPENCV_STEREO.replace("[ 24, 16 ]", "[ 48, 32 ]"))
    refused(folder, str(folder), "24x16, but the calibration is for 48x32")


@settings(max_examples=20)
@given(
    turn=st.tuples(*[st.floats(-0.3, 0.3)] * 3),
    shift=st.tuples(st.floats(-2000, -10), st.floats(-9, 9), st.floats(-9, 9)),
    coefficients=st.sampled_from([4, 5, 8, 12, 14]),
)
def test_what_opencv_writes(tmp_path_factory: pytest.TempPathFactory, turn, shift, coefficients: int):
    rotation, matrix = rotation_from_vector(np.array(turn)), np.array([[1 / 3, 0, 0.1], [0, 0.7, 0.2], [0, 0, 1]])
    distortion = np.linspace(0.001, -0.002, coefficients)
    folder = modd2_sequence(tmp_path_factory.mktemp("modd2"), frames=1)
    storage = cv2.FileStorage(str(folder / "calibration.yaml"), cv2.FILE_STORAGE_WRITE)
    for side in (1, 2):
        storage.write(f"M{side}", matrix * [[side], [side], [1]])
        storage.write(f"D{side}", distortion[None] * side)
    storage.write("R", rotation)
    storage.write("T", np.array(shift)[:, None])
    storage.write("imageSize", np.array([SIZE], float))
    storage.release()
    rig = load_scene(folder).rig
    np.testing.assert_allclose(rig.rotation, rotation, atol=1e-12)
    np.testing.assert_allclose(rig.translation * 1000, shift, rtol=1e-12, atol=1e-12)
    for side, camera in ((1, rig.left), (2, rig.right)):
        np.testing.assert_array_equal(camera.matrix, matrix * [[side], [side], [1]])
        np.testing.assert_array_equal(camera.distortion, distortion * side)


# --- bad input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("M2:", "M3:", "'M2' is missing"),
        ("\nT:", "\nT_lidar:", "'T' is missing"),
        ("[ 21., 0.", "[ .Nan, 0.", "M1 contains NaN"),
        ("[ -356.", "[ .Inf", "T contains NaN or infinite"),
        ("[ -356.", "[ -1.0e+999", "T contains NaN or infinite"),
        ("[ -356.", '[ "-356."', "T is not an array of numbers"),
        ("[ -356.", "[ [[[[[-356.]]]]]", "T is not an array of numbers"),
        ("[ -356.", "[ far", "T is not an array of numbers"),
        ("[ -356., 2.5, -1.25 ]", "[ -356., 2.5 ]", "T must hold 3 numbers, not 2"),
        ("   rows: 3\n   cols: 3\n   dt: d\n   data: [ 21.", "   rows: 1\n   cols: 9\n   dt: d\n   data: [ 21.",
         "M1 must hold 3x3 numbers, not 9"),
        ("   cols: 3\n   dt: d\n   data: [ 20., 0., 12.5, 0., 20.5, 8.25, 0., 0., 1. ]",
         "   cols: 0\n   dt: d\n   data: [ ]", "M2"),
        ("-2.0e-03,\n       1.5e-02 ]", "-2.0e-03, 1.5e-02 ", "not a YAML file"),
        ("[ 21., 0.", "[ 0., 0.", "singular or negative"),
        ("[ 0.99995, 0.0", "[ 0.9, 0.0", "R is not a rotation"),
        ("[ -356.", "[ 356.", "left and right are exchanged"),
        ("[ 24, 16 ]", "[ 24, 16, 3 ]", "imageSize must hold 2 numbers"),
        ("[ 24, 16 ]", "[ 24.5, 16 ]", "imageSize is 24.5, but an image size"),
        ("[ 24, 16 ]", "[ 0, 16 ]", "image size"),
    ],
)  # fmt: skip
def test_bad_calibrations(tmp_path: Path, old: str, new: str, words: str, capfd: pytest.CaptureFixture[str]):
    folder = modd2_sequence(tmp_path, frames=1)
    path = folder / "calibration.yaml"
    edit(path, old, new)
    refused(folder, str(path), words)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "content",
    [b"", b" \n", b"calibration", b"- 1\n- 2\n", b"%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   c", b"M1: [1, 2",
     b"<?xml version='1.0'?><opencv_storage><M1>", b"\x89PNG\xff\xfe", b"a\x00b", b"{"],
)  # fmt: skip
def test_files_that_are_no_calibration(tmp_path: Path, content: bytes, capfd: pytest.CaptureFixture[str]):
    path = modd2_sequence(tmp_path, frames=1) / "calibration.yaml"
    path.write_bytes(content)
    refused(tmp_path, str(path))
    assert capfd.readouterr() == ("", "")


def test_a_truncated_calibration(tmp_path: Path):
    """Wherever it ends, one sentence says so; only the last line can be spared, the size is then that of the images."""
    path = modd2_sequence(tmp_path, frames=1) / "calibration.yaml"
    for word in ("rows", "data", "D1", "M2", "R:", "T:", "-1.25", "imageSize"):
        path.write_text(OPENCV_STEREO)
        cut(path, word)
        refused(tmp_path, str(path)) if word != "imageSize" else load_log(tmp_path)


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return modd2_sequence(tmp_path_factory.mktemp("modd2"), frames=1)


@settings(max_examples=100)
@given(
    position=st.integers(0, len(OPENCV_STEREO) - 1),
    length=st.integers(0, 3),
    damage=st.text(st.sampled_from("0.-[]{}:!&*#%'\"\n\t é\0"), max_size=3),
)
def test_a_damaged_calibration_is_read_or_refused(sequence: Path, position: int, length: int, damage: str):
    write_text(sequence / "calibration.yaml", OPENCV_STEREO[:position] + damage + OPENCV_STEREO[position + length :])
    message = ""
    try:
        load_log(sequence)
    except InputError as error:
        message = str(error)
    assert not message or str(sequence) in message
    assert "\n" not in message


def test_unsupported_number_of_coefficients(tmp_path: Path):
    edit(modd2_sequence(tmp_path) / "calibration.yaml", ", 1.0e-03 ]", " ]")
    edit(tmp_path / "calibration.yaml", "cols: 4", "cols: 3")
    refused(tmp_path, "the distortion has 3 coefficients (D2)", kind=UnsupportedModelError)


def test_a_calibration_that_is_missing_or_no_file(tmp_path: Path):
    root = modd2(tmp_path)
    path = root / "video_data" / "kope71-01-00000040-00000340" / "calibration.yaml"
    path.unlink()
    refused(root, f"{path}: there is no such file")
    path.mkdir()
    refused(root, f"{path}: cannot be read")


@pytest.mark.parametrize("remove", ["00000026L.jpg", "00000026R.jpg"])
def test_an_image_without_partner(tmp_path: Path, remove: str):
    (modd2_sequence(tmp_path) / "frames" / remove).unlink()
    kept, side = ("00000026R.jpg", "left") if "L" in remove else ("00000026L.jpg", "right")
    refused(tmp_path, f"{tmp_path / 'frames' / kept}: this image has no partner on the {side} side")


def test_frames_of_different_times_are_no_pair(tmp_path: Path):
    shutil.rmtree(modd2_sequence(tmp_path) / "frames")
    write_image(tmp_path / "frames" / "00000000L.jpg", 0)
    write_image(tmp_path / "frames" / "00000001R.jpg", 1)
    refused(tmp_path, "00000000L.jpg", "no partner")


@pytest.mark.parametrize("make", [lambda frames: None, lambda frames: write_image(frames / "00000025.jpg", 0)])
def test_a_sequence_without_frames(tmp_path: Path, make: Callable[[Path], object]):
    frames = modd2_sequence(tmp_path) / "frames"
    for path in frames.iterdir():
        path.unlink()
    make(frames)
    with pytest.raises(InputError, match="no image in"):
        load_log(tmp_path)
