"""What is refused, in one sentence that says what to do; nothing is written then."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import SAMPLES
from machine import full_disk

from stereorecal import CalibrationWarning, InputError, UnsupportedModelError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io import load_rig, save_rig, write_text


def refused(call, words: str, kind: type[InputError] = InputError) -> None:
    with pytest.raises(InputError) as error:
        call()
    message = str(error.value)
    assert isinstance(error.value, kind)
    assert words in message
    assert "\n" not in message
    assert message.endswith((".", "?"))


# --- reading ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "a: 1\nb: 2\n", "the format is unknown; expected one of stereorecal, kalibr, boofcv"),
        ("a.json", '{"a": 1}', "the format is unknown"),
        ("a.txt", "hello world", "the format is unknown"),
        ("a.ini", "[left]\nfx = 3\n", "the format is unknown"),
        ("a.conf", "\r\n[LEFT_CAM_HD] ; the left one\r\nfx=3\r\n", "the format is unknown"),
        ("a.json", "[1, 2", "not valid JSON"),
        ("a.xml", "<?xml version='1.0'?><opencv_storage><M1>", "not an XML file"),
        ("a.xml", "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "not an XML file"),
        ("a.yaml", samples.ROS_PAIR[0], "this is one of two files (ros: "),
        ("a.yaml", samples.EUROC_PAIR[1], "this is one of two files (euroc: "),
        ("a.yaml", SAMPLES["opencv pair"].texts[0], "intrinsics only, no extrinsics (R, T): OpenCV's stereo_calib"),
        ("a.yaml", SAMPLES["opencv pair"].texts[1], "extrinsics only, no intrinsics (K1 or M1"),
        ("a.yaml", samples.KALIBR.partition("cam1:")[0], "the chain has no cam1"),
        ("a.yaml", "K: " + "[" * 200_000, "too long or too deeply nested"),
        ("a.json", '{"cameraData": ' + "[" * 200_000, "nests more than 100 levels"),
        ("a.yaml", samples.OPENCV.replace("imageSize: [ 64, 48 ]\n", ""), "the file has no image size"),
        ("a.txt", samples.KITTI_ODOMETRY, "the file has no image size"),
    ],
)
def test_files(tmp_path: Path, name: str, text: str, words: str):
    path = tmp_path / name
    path.write_text(text)
    refused(lambda: load_rig(path), words)
    with pytest.raises(InputError, match=name):
        load_rig(path)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("kalibr", "camera_model: pinhole", "camera_model: fov"),
        ("kalibr", "distortion_model: radtan", "distortion_model: fov"),
        ("ros", "plumb_bob", "thin_prism_fisheye"),
        ("euroc", "radial-tangential", "fov"),
        ("boofcv", "  model: pinhole_radial_tangential", "  model: kannala_brandt"),
        ("basalt", "pinhole-radtan8", "ucm"),
    ],
)
def test_lenses_that_nobody_knows(tmp_path: Path, name: str, old: str, new: str):
    sample = SAMPLES[name]
    assert old in sample.texts[0]
    paths = replace(sample, texts=tuple(text.replace(old, new) for text in sample.texts)).write(tmp_path)
    refused(lambda: load_rig(*paths), "undistort the images, or calibrate as pinhole", UnsupportedModelError)


def test_names_that_are_none(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    refused(lambda: load_rig(path, format="kalibre"), "did you mean kalibr?")
    refused(lambda: load_rig(path, unit="furlong"), "choose one of: m, cm, mm, in")
    refused(lambda: load_rig(path, format="ros"), "give the left and the right one")


def test_folders(tmp_path: Path):
    refused(lambda: load_rig(tmp_path), "there is no calibration file in it")
    for name in ("ros", "euroc", "kalibr", "opencv pair"):
        folder = tmp_path / name
        folder.mkdir()
        paths = SAMPLES[name].write(folder)
        rig = load_rig(folder, unit=SAMPLES[name].unit)
        np.testing.assert_array_equal(rig.extrinsics, load_rig(*paths, unit=SAMPLES[name].unit).extrinsics)
    (tmp_path / "kalibr" / "old.yaml").write_text(samples.KALIBR)
    refused(lambda: load_rig(tmp_path / "kalibr"), "several calibrations are in there (calibration0.yaml, old.yaml)")


CAMERA_INFO = samples.ROS_PAIR[1].partition("projection_matrix")[0]


@pytest.mark.parametrize("in_folder", [False, True])
@pytest.mark.parametrize(
    ("texts", "words"),
    [
        ((samples.ROS_PAIR[0], CAMERA_INFO), "b.yaml: the key 'projection_matrix' is missing"),
        ((samples.ROS_PAIR[0], samples.EUROC_PAIR[0]), "a.yaml looks like ros, {}b.yaml like euroc; give two of one"),
        ((samples.ROS_PAIR[0], "a: 1"), "b.yaml: the key 'image_width' is missing"),
        (("b: 2", "a: 1"), "b.yaml: the format is unknown"),
        (
            tuple(text.replace("imageSize: [ 64, 48 ]\n", "") for text in SAMPLES["opencv pair"].texts),
            "b.yaml: the file has no image size (imageSize); give size=",
        ),
    ],
)
def test_two_files_that_are_no_calibration(tmp_path: Path, texts: tuple[str, str], words: str, in_folder: bool):
    paths = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text)
    refused(lambda: load_rig(tmp_path) if in_folder else load_rig(*paths), words.format(f"{tmp_path}/"))


def test_two_whole_calibrations(tmp_path: Path):
    (kalibr,) = SAMPLES["kalibr"].write(tmp_path)
    (tmp_path / "left.yaml").write_text(samples.ROS_PAIR[0])
    refused(lambda: load_rig(kalibr, kalibr), "each is a calibration by itself (kalibr); give one")
    refused(lambda: load_rig(tmp_path / "left.yaml", kalibr), "these two do not belong together")


def test_left_and_right_the_wrong_way_round(tmp_path: Path):
    left, right = SAMPLES["ros"].write(tmp_path)
    assert np.array_equal(load_rig([left, right]).extrinsics, load_rig(left, right).extrinsics)
    refused(lambda: load_rig([left, right], left), "3 calibration files were given, and one of them twice")
    refused(lambda: load_rig(right, left), "left and right are swapped")
    refused(lambda: load_rig(left, left), "no baseline")


# --- units --------------------------------------------------------------------------------------------------


def test_an_inferred_unit_is_said(tmp_path: Path):
    (path,) = SAMPLES["opencv yaml"].write(tmp_path)
    with pytest.warns(CalibrationWarning, match=r"taken to be in mm, a baseline of 0\.12 m: say unit='mm'"):
        rig = load_rig(path)
    assert rig.baseline == pytest.approx(0.12, rel=1e-3)
    assert load_rig(path, unit="cm").baseline == pytest.approx(1.2, rel=1e-3)
    path.write_text(samples.OPENCV.replace("-120., 1., -2.", "-0.12, 0.001, -0.002"))
    with pytest.warns(CalibrationWarning, match="taken to be in m, a baseline"):
        assert load_rig(path).baseline == pytest.approx(0.12, rel=1e-3)


def test_the_unit_of_a_template(tmp_path: Path):
    """Of a baseline that tells nothing: 3, in centimetres."""
    template = tmp_path / "template.yaml"
    template.write_text(samples.OPENCV.replace("-120., 1., -2.", "-3., 0., 0."))
    with pytest.warns(CalibrationWarning, match="taken to be in m, a baseline"):
        save_rig(samples.RIG, tmp_path / "guessed.yaml", template=template)
    save_rig(samples.RIG, tmp_path / "said.yaml", template=template, unit="cm")
    rig = load_rig(template, unit="cm")
    own = rig.with_extrinsics(samples.RIG.extrinsics)
    save_rig(own, tmp_path / "own.yaml", template=template)
    save_rig(own, tmp_path / "anew.xml", format="opencv")
    for name in ("said.yaml", "own.yaml", "anew.xml"):
        again = load_rig(tmp_path / name, unit="cm")
        np.testing.assert_allclose(again.extrinsics, samples.RIG.extrinsics, atol=1e-12)
    refused(lambda: save_rig(own, tmp_path / "other.yaml", unit="mm"), "are in cm, not in mm; leave the unit out")
    refused(lambda: save_rig(rig, tmp_path / "a.yaml", format="kalibr", unit="cm"), "this kalibr file are in m, not in")


@pytest.mark.parametrize("name", ["kalibr", "ros", "euroc", "basalt", "kitti-raw"])
def test_a_unit_that_is_stated_is_used(tmp_path: Path, name: str):
    """Also where the format has another one: a board measured in mm gives a file in mm, and it is written back so."""
    long = samples.RIG.with_extrinsics(samples.RIG.extrinsics * [1, 1, 1, 1000, 1000, 1000])
    paths = SAMPLES[name].paths(tmp_path)
    save_rig(long, paths, format=name)
    before = [path.read_bytes() for path in paths]
    rig = load_rig(paths, unit="mm")
    np.testing.assert_allclose(rig.extrinsics, samples.RIG.extrinsics, atol=1e-9)
    save_rig(rig, paths, overwrite=True)
    assert [path.read_bytes() for path in paths] == before
    moved = rig.with_extrinsics(rig.extrinsics + 0.001)
    save_rig(moved, paths, overwrite=True)
    np.testing.assert_allclose(load_rig(paths, unit="mm").extrinsics, moved.extrinsics, atol=1e-12)
    refused(lambda: save_rig(moved, paths, overwrite=True, unit="m"), "are in mm, not in m; leave the unit out")


def test_a_file_that_states_its_unit_keeps_it(tmp_path: Path):
    save_rig(samples.RIG, tmp_path / "rig.json")
    assert load_rig(tmp_path / "rig.json", unit="m").baseline == pytest.approx(float(samples.RIG.baseline))
    refused(lambda: load_rig(tmp_path / "rig.json", unit="mm"), "rig.json: lengths of a stereorecal file are in the")


def test_left_and_right_as_names_in_opencvs_file(tmp_path: Path):
    """Its unit is not that of a calib.json, which has these names."""
    text = samples.OPENCV
    for one, other in (("K1", "K_left"), ("D1", "D_left"), ("K2", "K_right"), ("D2", "D_right")):
        text = text.replace(f"{one}:", f"{other}:")
    (tmp_path / "rig.yaml").write_text(text)
    rig = load_rig(tmp_path / "rig.yaml", unit="mm")
    assert (rig.source.format, float(rig.baseline)) == ("opencv", pytest.approx(0.12, rel=1e-3))


# --- writing ------------------------------------------------------------------------------------------------

EIGHT = np.array([-0.3, 0.1, 0.001, -0.002, 0.01, 0.02, 0.03, 0.04])


@pytest.mark.parametrize(
    ("rig", "name", "format", "words"),
    [
        (samples.RIG, "a.txt", "middlebury", "no place for a rotation or a lens; write it as opencv"),
        (samples.RIG, "a.txt", "kitti-odometry", "no place for a rotation or a lens; write it as opencv"),
        (
            samples.rig_of(samples.RIG.extrinsics, EIGHT),
            "a.yaml",
            "kalibr",
            "write it as opencv, ros or depthai instead",
        ),
        (
            samples.rig_of(samples.RIG.extrinsics, EIGHT),
            "a.yaml",
            "boofcv",
            "write it as opencv, ros or depthai instead",
        ),
        (samples.rig_of(samples.RIG.extrinsics, EIGHT), "a.txt", "kitti-raw", "has 5 lens coefficients"),
        (samples.rig_of(samples.RIG.extrinsics, np.arange(12) * 1e-3), "a.json", "basalt", "has 8 lens coefficients"),
        (samples.RIG, "a.yaml", "ros", "ros is written as two files, left and right"),
        (samples.RIG, "a.json", "kalibr", "the ending contradicts what is to be written"),
        (samples.RIG, "a.yaml", "stereorecal", "give a name ending in .json"),
        (samples.RIG, "a.txt", None, "the file name's ending does not identify the format"),
        (samples.RIG, "a.yaml", "kalib", "did you mean kalibr?"),
        (samples.RIG, "nowhere/a.yaml", "kalibr", "cannot be written"),
    ],
)
def test_what_a_format_cannot_hold(tmp_path: Path, rig: StereoRig, name: str, format: str | None, words: str):
    refused(lambda: save_rig(rig, tmp_path / name, format=format), words)
    assert list(tmp_path.iterdir()) == []


def test_one_rectification_of_four_cameras(tmp_path: Path):
    text = samples.KITTI_RAW + "R_rect_02: 1 0 0 0 1 0 0 0 1\n"
    path = tmp_path / "calib_cam_to_cam.txt"
    path.write_text(text)
    rig = load_rig(path)
    moved = rig.with_extrinsics(rig.extrinsics + np.array([0.01, 0, 0, 0, 0, 0]))
    refused(lambda: save_rig(moved, tmp_path / "b.txt"), "one rectification of four cameras")
    save_rig(moved, tmp_path / "b.yaml", format="opencv")
    np.testing.assert_allclose(load_rig(tmp_path / "b.yaml", unit="m").extrinsics, moved.extrinsics, atol=1e-12)


def test_nothing_is_overwritten(tmp_path: Path):
    paths = SAMPLES["ros"].write(tmp_path)
    rig = load_rig(*paths)
    refused(lambda: save_rig(rig, (tmp_path / "new.yaml", paths[1])), "the file exists already")
    assert not (tmp_path / "new.yaml").exists()


def test_two_files_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    left, right = SAMPLES["ros"].write(tmp_path)
    before = [path.read_bytes() for path in (left, right)]
    rig = load_rig(left, right)
    moved = rig.with_extrinsics(rig.extrinsics + 0.01)
    full = Path("/dev/full")
    if full.exists():
        refused(lambda: save_rig(moved, (left, full), format="ros", overwrite=True), "/dev/full: cannot be written")
    refused(lambda: save_rig(moved, (left, tmp_path / "." / left.name), overwrite=True), "give two names")
    assert left.read_bytes() == before[0]
    with full_disk(nth=2):
        refused(lambda: save_rig(moved, (left, right), overwrite=True), f"{right}: cannot be written")
    assert [path.read_bytes() for path in (left, right)] == before
    new = (tmp_path / "a.yaml", tmp_path / "b.yaml")
    with full_disk(nth=2):
        refused(lambda: save_rig(moved, new, overwrite=True), "cannot be written")
    assert sorted(tmp_path.iterdir()) == [left, right]


def test_permissions_stay(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    path.chmod(0o640)
    rig = load_rig(path)
    save_rig(rig.with_extrinsics(rig.extrinsics + 0.01), path, overwrite=True)
    assert path.stat().st_mode & 0o777 == 0o640
    write_text(path, "other")
    assert path.stat().st_mode & 0o777 == 0o640


def test_cameras_of_different_sizes(tmp_path: Path):
    rig = StereoRig(samples.RIG.left, samples.RIG.right.resized((32, 24)), samples.RIG.extrinsics)
    refused(lambda: save_rig(rig, tmp_path / "a.yaml", format="opencv"), "different sizes; write the rig as kalibr")
    save_rig(rig, tmp_path / "a.yaml", format="kalibr")
    assert load_rig(tmp_path / "a.yaml").right.size == (32, 24)


def test_a_camera_with_skew(tmp_path: Path):
    (path,) = SAMPLES["boofcv"].write(tmp_path)
    path.write_text(samples.BOOFCV.replace("    skew: 0.0", "    skew: 0.5"))
    refused(lambda: load_rig(path, unit="mm"), "skew, which is not supported")
    assert Camera(samples.SIZE, samples.MATRIX).distortion.size == 0
