"""What is refused, in one sentence that says what to do; nothing is written then."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import samples
from every import SAMPLES, beside, contents
from machine import full_disk
from refusals import refused

from stereorecal import CalibrationWarning, UnsupportedModelError
from stereorecal.geometry import StereoRig
from stereorecal.io import check_savable, load_rig, save_rig

# --- reading ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.yaml", "a: 1\nb: 2\n", "the format is unknown; expected one of stereorecal, kalibr, boofcv"),
        ("a.json", '{"a": 1}', "the format is unknown"),
        ("a.txt", "hello world", "the format is unknown"),
        ("a.conf", "\r\n[LEFT_CAM_HD] ; the left one\r\nfx=3\r\n", "the format is unknown"),
        ("a.xml", "<?xml version='1.0'?><opencv_storage><M1>", "not an XML file"),
        ("a.xml", "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "not an XML file"),
        (
            "a.yaml",
            samples.ROS_PAIR[0],
            "a.yaml looks like ros: this is not one whole calibration; give one file, or the two files of",
        ),
        (
            "a.yaml",
            samples.EUROC_PAIR[1],
            "a.yaml looks like euroc: this is not one whole calibration; give one file, or the two files of",
        ),
        (
            "a.yaml",
            SAMPLES["opencv pair"].texts[0],
            "no rotation and translation (R, T) are found among M1 (3x3), D1 (5), M2",
        ),
        (
            "a.yaml",
            SAMPLES["opencv pair"].texts[1],
            "no camera matrices (K1 or M1, K2 or M2) are found among R (3x3), T (3)",
        ),
        ("a.yaml", samples.KALIBR.partition("cam1:")[0], "the chain has no cam1"),
        ("a.yaml", samples.KALIBR.replace("61.25", ".nan"), "intrinsics contains NaN or infinite"),
        ("a.yaml", samples.KALIBR.replace("61.25", '"61.25"'), "intrinsics is not an array"),
        ("a.yaml", samples.OPENCV.replace("imageSize: [ 64, 48 ]\n", ""), "the file has no image size"),
        ("a.txt", samples.KITTI_ODOMETRY, "the file has no image size"),
        ("a.yaml", samples.BOOFCV.replace("    skew: 0.0", "    skew: 0.5"), "skew, which is not supported"),
        (
            "a.yaml",
            samples.BOOFCV.replace("radial_tangential:\n", "radial_tangential: [1, 2]\n  other:\n", 1),
            "left: radial_tangential is a list, and must have the key 't1'",
        ),
        (
            "a.json",
            '{"value0": {"T_imu_cam": 1, "intrinsics": [[1], [2]]}}',
            "intrinsics is a list, and must have",
        ),
        ("a.json", '{"value0": {"T_imu_cam": 1, "intrinsics": [{}]}}', "value0: intrinsics has not two cameras"),
    ],
)
def test_files(tmp_path: Path, name: str, text: str, words: str):
    path = tmp_path / name
    path.write_text(text)
    refused(lambda: load_rig(path), words, name)


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
@pytest.mark.parametrize("in_folder", [False, True])
def test_lenses_that_nobody_knows(tmp_path: Path, name: str, old: str, new: str, in_folder: bool):
    paths = SAMPLES[name].changed((old, new)).write(tmp_path)
    words = "undistort the images, or calibrate as pinhole"
    refused(lambda: load_rig(tmp_path if in_folder else paths), words, kind=UnsupportedModelError)


def test_names_that_are_none(tmp_path: Path):
    (path,) = SAMPLES["kalibr"].write(tmp_path)
    refused(lambda: load_rig(path, format="kalibre"), "did you mean kalibr?")
    refused(lambda: load_rig(path, unit="furlong"), "choose one of: m, cm, mm, in")
    refused(lambda: load_rig(path, format="ros"), "give the left and the right one")
    refused(lambda: load_rig(path, format="camera_info"), "not arranged as camera_info is (ROS camera_info of both")


def test_folders(tmp_path: Path):
    refused(lambda: load_rig(tmp_path), "there is no calibration file in it")
    for name in ("ros", "euroc", "kalibr", "opencv pair"):
        folder, sample = tmp_path / name, SAMPLES[name]
        folder.mkdir()
        paths = sample.write(folder)
        rig = load_rig(folder, unit=sample.unit)
        np.testing.assert_array_equal(rig.extrinsics, sample.load(paths).extrinsics)
    (tmp_path / "kalibr" / "old.yaml").write_text(samples.KALIBR)
    refused(lambda: load_rig(tmp_path / "kalibr"), "several calibrations are in there (calibration0.yaml, old.yaml)")
    (tmp_path / "ros" / "camchain.yaml").write_text(samples.KALIBR)
    words = "several calibrations are in there (camchain.yaml, calibration0.yaml with calibration1.yaml)"
    refused(lambda: load_rig(tmp_path / "ros"), words)


CAMERA_INFO = samples.ROS_PAIR[1].partition("projection_matrix")[0]


@pytest.mark.parametrize("in_folder", [False, True])
@pytest.mark.parametrize(
    ("texts", "words"),
    [
        ((samples.ROS_PAIR[0], CAMERA_INFO), "b.yaml: the key 'projection_matrix' is missing"),
        ((samples.ROS_PAIR[0], samples.EUROC_PAIR[0]), "a.yaml looks like ros, {}b.yaml looks like euroc: this is not"),
        ((samples.ROS_PAIR[0], "a: 1"), "b.yaml: the key 'image_width' is missing"),
        (("b: 2", "a: 1"), "b.yaml: the format is unknown"),
        (
            SAMPLES["opencv pair"].changed(("imageSize: [ 64, 48 ]\n", "")).texts,
            "b.yaml: the file has no image size (imageSize); give size=",
        ),
    ],
)
def test_two_files_that_are_no_calibration(tmp_path: Path, texts: tuple[str, str], words: str, in_folder: bool):
    paths = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text)
    refused(lambda: load_rig(tmp_path if in_folder else paths), words.format(f"{tmp_path}/"))


def test_files_that_do_not_belong_together(tmp_path: Path):
    (kalibr,) = SAMPLES["kalibr"].write(tmp_path)
    (tmp_path / "ros").mkdir()
    left, right = SAMPLES["ros"].write(tmp_path / "ros")
    refused(
        lambda: load_rig(kalibr, kalibr), "0.yaml looks like kalibr: this is not one whole calibration; give one file"
    )
    refused(
        lambda: load_rig(left, kalibr), "0.yaml looks like kalibr: this is not one whole calibration; give one file"
    )
    assert np.array_equal(load_rig([left, right]).extrinsics, load_rig(left, right).extrinsics)
    refused(lambda: load_rig([left, right], left), "3 calibration files were given, and one of them twice")
    refused(lambda: load_rig(right, left), "left and right are exchanged")
    refused(lambda: load_rig(left, left), "no baseline")


# --- units --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("stated", "unit"), [("-120., 1., -2.", "mm"), ("-0.12, 0.001, -0.002", "m")])
def test_an_inferred_unit_is_said(tmp_path: Path, stated: str, unit: str):
    (path,) = SAMPLES["opencv yaml"].changed(("-120., 1., -2.", stated)).write(tmp_path)
    with pytest.warns(CalibrationWarning, match=rf"taken to be in {unit}, a baseline of 0\.12 m: say unit='{unit}'"):
        rig = load_rig(path)
    assert rig.baseline == pytest.approx(0.12, rel=1e-3)
    if unit == "mm":
        assert load_rig(path, unit="cm").baseline == pytest.approx(1.2, rel=1e-3)


def test_the_unit_of_a_template(tmp_path: Path):
    """A unit has to be said where the baseline tells nothing: 3, in centimetres."""
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
    before = contents(paths)
    rig = load_rig(paths, unit="mm")
    np.testing.assert_allclose(rig.extrinsics, samples.RIG.extrinsics, atol=1e-9)
    save_rig(rig, paths, overwrite=True)
    assert contents(paths) == before
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
    names = (("M1:", "K_left:"), ("D1:", "D_left:"), ("M2:", "K_right:"), ("D2:", "D_right:"))
    sample = SAMPLES["opencv yaml"].changed(*names)
    rig = sample.load(sample.write(tmp_path))
    assert (rig.source.format, float(rig.baseline)) == ("opencv", pytest.approx(0.12, rel=1e-3))


# --- sizes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((32, 24), "leave size out, and resize the rig in Python: rig.resized((32, 24))."),
        ((64, 36), "crop the rig in Python: rig.cropped((64, 36)) if the images are cut out of the middle."),
        ((32, 18), "out of the middle, rig.resized((32, 24)).cropped((32, 18)) if they are resampled, too."),
        ((128, 60), "calibrate for these images, which are larger, and of another ratio of width to height."),
    ],
)
def test_what_to_do_with_images_of_another_size(tmp_path: Path, size: tuple[int, int], words: str):
    paths = SAMPLES["kalibr"].write(tmp_path)
    refused(lambda: load_rig(paths, size=size), words)


@pytest.mark.parametrize("size", [(128, 96), (32, 24), (64, 36)])
def test_a_size_that_the_file_does_not_say_is_doubted(tmp_path: Path, size: tuple[int, int]):
    paths = SAMPLES["opencv yaml"].changed(("imageSize:", "boats:")).write(tmp_path)
    assert load_rig(paths, unit="mm", size=samples.SIZE).left.size == samples.SIZE
    with pytest.warns(CalibrationWarning, match="is far from the middle of images of") as found:
        load_rig(paths, unit="mm", size=size)
    assert len(found) == 1
    paths = SAMPLES["kalibr"].changed(("31.5", "12.5")).write(tmp_path)
    assert load_rig(paths, size=samples.SIZE).left.size == samples.SIZE  # which the file says


# --- writing ------------------------------------------------------------------------------------------------

EIGHT = samples.rig_of(samples.RIG.extrinsics, np.array([-0.3, 0.1, 0.001, -0.002, 0.01, 0.02, 0.03, 0.04]))
TWELVE = samples.rig_of(samples.RIG.extrinsics, np.arange(12) * 1e-3)


@pytest.mark.parametrize(
    ("rig", "name", "format", "words"),
    [
        (samples.RIG, "a.txt", "middlebury", "no place for a rotation or a lens; write it as opencv"),
        (samples.RIG, "a.txt", "kitti-odometry", "no place for a rotation or a lens; write it as opencv"),
        (EIGHT, "a.yaml", "kalibr", "write it as opencv, ros or depthai instead"),
        (EIGHT, "a.yaml", "boofcv", "write it as opencv, ros or depthai instead"),
        (EIGHT, "a.txt", "kitti-raw", "has 5 lens coefficients"),
        (TWELVE, "a.json", "basalt", "has 8 lens coefficients"),
        (samples.RIG, "a.yaml", "ros", "ros is written as two files, left and right"),
        (samples.RIG, "a.json", "kalibr", "the ending contradicts what is to be written"),
        (samples.RIG, "a.yaml", "stereorecal", "give a name ending in .json"),
        (samples.RIG, "a.txt", None, "the file name's ending does not identify the format"),
        (samples.RIG, "a.yaml", "kalib", "did you mean kalibr?"),
        (samples.RIG, "nowhere/a.yaml", "kalibr", "cannot be written"),
    ],
)
def test_what_a_format_cannot_hold(tmp_path: Path, rig: StereoRig, name: str, format: str | None, words: str):
    for call in (save_rig, check_savable):
        refused(lambda call=call: call(rig, tmp_path / name, format=format), words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("kalibr", "[0.0, -1.0, 0.0, -0.02]", "[-0.02]", "T_cam_imu is not an array of numbers"),
        ("boofcv", "radial: [-0.3, 0.1]", "radial: -0.3", "a list where the file has none; write a new file"),
    ],
)
def test_values_that_are_not_read_and_cannot_be_written(tmp_path: Path, name: str, old: str, new: str, words: str):
    sample = SAMPLES[name].changed((old, new))
    (path,) = sample.write(tmp_path)
    rig = sample.load([path])
    moved = replace(samples.RIG, source=rig.source)
    refused(lambda: save_rig(moved, path, overwrite=True), words)


def test_one_rectification_of_four_cameras(tmp_path: Path):
    path = tmp_path / "calib_cam_to_cam.txt"
    path.write_text(samples.KITTI_RAW + "R_rect_02: 1 0 0 0 1 0 0 0 1\n")
    rig = load_rig(path)
    moved = rig.with_extrinsics(rig.extrinsics + np.array([0.01, 0, 0, 0, 0, 0]))
    refused(lambda: save_rig(moved, tmp_path / "b.txt"), "one rectification of four cameras")
    save_rig(moved, tmp_path / "b.yaml", format="opencv")
    np.testing.assert_allclose(load_rig(tmp_path / "b.yaml", unit="m").extrinsics, moved.extrinsics, atol=1e-12)


def test_two_files_or_none(tmp_path: Path):
    paths = left, right = SAMPLES["ros"].write(tmp_path)
    before = contents(paths)
    rig = load_rig(paths)
    moved = rig.with_extrinsics(rig.extrinsics + 0.01)
    refused(lambda: save_rig(rig, (tmp_path / "new.yaml", right)), "the file exists already")
    full = Path("/dev/full")
    if full.exists():
        refused(lambda: save_rig(moved, (left, full), format="ros", overwrite=True), "/dev/full: cannot be written")
    same = left, tmp_path / "." / left.name
    refused(lambda: save_rig(moved, same, overwrite=True), "give two names")
    refused(lambda: check_savable(moved, same), "give two names")
    for places in (paths, beside(paths)):
        with full_disk(nth=2):
            refused(lambda places=places: save_rig(moved, places, overwrite=True), f"{places[1]}: cannot be written")
    assert sorted(tmp_path.iterdir()) == paths
    assert contents(paths) == before


def test_rigs_that_another_file_would_not_hold(tmp_path: Path):
    two_sizes = StereoRig(samples.RIG.left, samples.RIG.right.resized((32, 24)), samples.RIG.extrinsics)
    words = "one size of images for both cameras, and these have two; write the rig as kalibr"
    refused(lambda: save_rig(two_sizes, tmp_path / "a.yaml", format="opencv"), words)
    save_rig(two_sizes, tmp_path / "a.yaml", format="kalibr")
    assert load_rig(tmp_path / "a.yaml").right.size == (32, 24)
    small = load_rig(SAMPLES["kalibr"].write(tmp_path)).resized((32, 24))
    words = "the file is for images of 64x48, and the rig for 32x24; write `rig.resized((64, 48))`"
    refused(lambda: save_rig(small, tmp_path / "b.yaml"), words)
    save_rig(replace(small, source=None), tmp_path / "b.yaml", format="kalibr")
    assert load_rig(tmp_path / "b.yaml").left.size == (32, 24)
