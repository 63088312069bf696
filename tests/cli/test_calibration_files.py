"""Calibration files on the command line: convert, diff, score and recalibrate take every format, and give it back."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from machine import write_protected

import stereorecal as sr
from stereorecal.io import load_rig, load_scene, save_rig, save_scene

COUNT = ("--schedule", "count")  # improves the drifted scene


def test_help_names_every_format(command):
    help_text = " ".join(command("score", "--help").out.split())
    named = re.search(r"of the calibration file \(default: recognised\): ((?:\S+, )*\S+)", help_text)
    with pytest.raises(sr.InputError) as refusal:
        load_rig("calib.json", format="nothing")
    known = str(refusal.value).partition("choose one of: ")[2].rstrip(".")
    assert named is not None
    assert sorted(named[1].split(", ")) == sorted(known.split(", "))


@pytest.fixture
def rig(drifted_scene: Path) -> sr.StereoRig:
    found = load_scene(drifted_scene).rig
    assert found is not None
    return found


def short(rig: sr.StereoRig) -> sr.StereoRig:
    """With lenses of four coefficients, as Kalibr has them."""
    left, right = (sr.Camera(camera.size, camera.matrix, camera.distortion[:4]) for camera in (rig.left, rig.right))
    return sr.StereoRig(left, right, rig.extrinsics)


@pytest.fixture
def sides(drifted_scene: Path) -> tuple[object, ...]:
    return "--left", drifted_scene / "left.png", "--right", drifted_scene / "right.png"


# --- convert ------------------------------------------------------------------------------------------------


def test_convert_round_and_round(command, rig: sr.StereoRig, tmp_path: Path):
    save_rig(rig, tmp_path / "a.json", format="stereorecal")
    ros = f"{tmp_path}/left.yaml,{tmp_path}/right.yaml"
    steps = [
        (tmp_path / "a.json", tmp_path / "b.xml"),
        (tmp_path / "b.xml", ros, "--to", "ros", "--unit", "m"),
        (ros, tmp_path / "oak.json", "--to", "depthai"),
        (tmp_path / "oak.json", tmp_path / "d.yaml", "--to", "boofcv"),
        (tmp_path / "d.yaml", tmp_path / "e.json", "--from", "boofcv", "--unit", "m"),
    ]
    for step in steps:
        answer = command("convert", *step)
        assert (answer.code, answer.err) == (0, "")
        unsaid = step[1] in (tmp_path / "b.xml", tmp_path / "d.yaml")  # formats without a unit
        assert answer.out == f"{step[1]}: written{' (translation in m)' if unsaid else ''}\n"
    assert load_rig(tmp_path / "e.json").source.format == "stereorecal"
    np.testing.assert_allclose(load_rig(tmp_path / "e.json").extrinsics, rig.extrinsics, atol=1e-12)


def test_a_template_for_what_is_unknown(command, tmp_path: Path):
    (tmp_path / "a.yaml").write_text("fast: [1.0, 2.0, 3.0]\n")
    words = ("convert", tmp_path / "a.yaml", tmp_path / "calib.json")
    command(*words).refuses("the format is unknown", "It has fast (3)", "--template")
    answer = command(*words, "--template")
    assert (answer.code, answer.err) == (0, "")
    assert "fill in its nulls" in answer.out
    command("convert", tmp_path / "calib.json", tmp_path / "b.json").refuses("image_size contains null")
    command(*words, "--template").refuses("exists already")


def test_a_file_that_is_only_read_is_not_replaced(command, rig: sr.StereoRig, sides, unworked, tmp_path: Path):
    settings = tmp_path / "b.yaml"
    camera = "Camera.fx: 50.0\nCamera.fy: 50.0\nCamera.cx: 79.5\nCamera.cy: 59.5\nCamera.bf: 5.0\n"
    settings.write_text("%YAML:1.0\n---\n" + camera)
    words = ("recalibrate", *sides, "--calibration", settings, *unworked)
    command(*words, "--output", settings, "--force").refuses("is read, not written; write the rig as opencv")


def test_the_right_camera_first(command, rig: sr.StereoRig, tmp_path: Path):
    """--cameras says so, and what is written from it begins with the left; so is the unit that was inferred."""
    path, new, other = tmp_path / "a.npz", tmp_path / "new.json", tmp_path / "other.json"
    cameras = {"K1": rig.right.matrix, "D1": rig.right.distortion, "K2": rig.left.matrix, "D2": rig.left.distortion}
    np.savez(path, **cameras, R=rig.R.T, T=-rig.R.T @ rig.T, imageSize=np.array(rig.left.size))
    command("convert", path, new, "--unit", "m").refuses("--cameras right,left")
    answer = command("convert", path, new, "--cameras", "right,left")
    assert (answer.code, answer.err.count("\n")) == (0, 1)
    assert "taken to be in m" in answer.err
    np.testing.assert_allclose(load_rig(new).extrinsics, rig.extrinsics, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(load_rig(new).left.matrix, rig.left.matrix)
    command("convert", path, other, "--cameras", "cam1").refuses("--cameras is 'cam1'")
    assert not other.exists()


@pytest.mark.parametrize("options", [(), ("--to", "opencv")])
@pytest.mark.parametrize("source", ["a.json", "a.yaml"])
def test_the_unit_of_a_new_file(command, rig: sr.StereoRig, tmp_path: Path, source: str, options: tuple[str, ...]):
    """--unit is that of whichever file says none."""
    save_rig(rig, tmp_path / "a.json", format="stereorecal")
    save_rig(rig, tmp_path / "a.yaml", format="opencv", unit="mm")
    target = tmp_path / "b.xml"
    answer = command("convert", tmp_path / source, target, *options, "--unit", "mm")
    assert (answer.code, answer.out, answer.err) == (0, f"{target}: written (translation in mm)\n", "")
    for path in (tmp_path / "a.yaml", target):
        assert load_rig(path, unit="mm").baseline == pytest.approx(rig.baseline, rel=1e-12)
    assert command("convert", tmp_path / "a.yaml", tmp_path / "c.json", "--unit", "mm").code == 0
    command("convert", tmp_path / "a.json", tmp_path / "d.json", "--unit", "mm").refuses("(baseline_m), not in mm")


def test_a_unit_for_files_that_have_one(command, rig: sr.StereoRig, tmp_path: Path):
    """That of the file that is read, if both have one; diff takes it for the other, if only one has."""
    long = rig.with_extrinsics(rig.extrinsics * [1, 1, 1, 1000, 1000, 1000])
    save_rig(short(long), tmp_path / "a.yaml", format="kalibr")
    answer = command("convert", tmp_path / "a.yaml", tmp_path / "b.json", "--unit", "mm")
    assert (answer.code, answer.err) == (0, "")
    assert load_rig(tmp_path / "b.json").baseline == pytest.approx(float(rig.baseline), rel=1e-12)
    save_rig(rig, tmp_path / "c.yaml", format="opencv", unit="mm")
    for pair in (("b.json", "c.yaml"), ("c.yaml", "b.json")):
        answer = command("diff", *(tmp_path / name for name in pair), "--unit", "mm")
        assert (answer.code, answer.err) == (0, "")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("{tmp}/a.json", "{tmp}/a.json"), "this is what is converted"),
        (("{tmp}/a.json", "{tmp}/old.yaml"), "the file exists already; choose another or add --force"),
        (("{tmp}/a.json", "{tmp}/b.yaml", "--to", "kalibra"), "did you mean kalibr?"),
        (("{tmp}/a.json", "{tmp}/b.yaml", "--from", "kalibr"), "a.json"),
        (("{tmp}/a.json", "{tmp}/b.yaml", "--unit", "miles"), "unknown unit 'miles'"),
        (("{tmp}/a.json", "{tmp}/b.yaml", "--size", "big"), "--size is 'big'"),
        (("{tmp}/a.json", "{tmp}/b.yaml,{tmp}/c.yaml"), "is written as one file"),
        (("{tmp}/none.json", "{tmp}/b.yaml"), "none.json: there is no such file"),
        (("{tmp}/l.yaml", "{tmp}/r.yaml", "{tmp}/b.json"), "b.json (the two files of a calibration are named as LEFT"),
    ],
)
def test_convert_refuses(command, rig: sr.StereoRig, tmp_path: Path, words, said: str):
    save_rig(rig, tmp_path / "a.json", format="stereorecal")
    (tmp_path / "old.yaml").write_text("precious")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    command("convert", *(word.format(tmp=tmp_path) for word in words)).refuses(said)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


# --- diff and score -----------------------------------------------------------------------------------------


def test_diff_of_two_files_or_their_folder(command, rig: sr.StereoRig, drifted_scene: Path, sides, tmp_path: Path):
    files = (tmp_path / "left.yaml", tmp_path / "right.yaml")
    save_rig(rig, files, format="ros")
    pair = ",".join(map(str, files))
    for place in (pair, tmp_path):
        answer = command("diff", drifted_scene, place)
        assert (answer.code, answer.err) == (0, "")
        assert "pitch +0.000, yaw +0.000, roll +0.000" in answer.out
    command("score", *sides, "--calibration", *files, files[0]).refuses("--calibration takes one file, or two")


def test_a_folder_of_images_and_another_format(command, rig: sr.StereoRig, drifted_scene: Path, tmp_path: Path):
    """The refusal names the options that work."""
    for side in ("left", "right"):
        (tmp_path / f"{side}.png").write_bytes((drifted_scene / f"{side}.png").read_bytes())
    save_rig(rig, tmp_path / "stereo.yaml", format="opencv")
    said = "calib.json: there is no such file; check the path, or write a calib.json there; or, for a calibration in "
    command("score", tmp_path).refuses(f"{said}another format, say --left, --right and --calibration")
    words = ("--left", tmp_path / "left.png", "--right", tmp_path / "right.png", "--calibration", tmp_path)
    assert command("score", *words, "--unit", "m") == command("score", drifted_scene)


def test_cameras_one_above_the_other_with_another_calibration(command, clean_scene: Path, tmp_path: Path):
    scene = load_scene(clean_scene)
    assert scene.rig is not None
    pairs = tuple(sr.Pair(np.rot90(pair.left, -1), np.rot90(pair.right, -1)) for pair in scene.pairs)
    save_scene(replace(scene, rig=None, pairs=pairs), tmp_path / "scene")
    save_rig(replace(scene.rig, turns=(1, 1), source=None), tmp_path / "scene" / "calib.json", overwrite=True)
    save_rig(load_rig(tmp_path / "scene" / "calib.json"), tmp_path / "other.yaml", format="opencv")
    answer = command("score", tmp_path / "scene", "--calibration", tmp_path / "other.yaml", "--unit", "m")
    expected = command("score", tmp_path / "scene")
    assert (answer.code, answer.err) == (expected.code, expected.err) == (0, answer.err)
    assert answer.out.startswith("Good. Epipolar error 0.0")


# --- recalibrate --------------------------------------------------------------------------------------------


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", ["opencv", "ros"])
def test_the_form_in_which_it_came(command, rig: sr.StereoRig, drifted_scene: Path, sides, tmp_path: Path, name: str):
    files = [tmp_path / "a.yaml"] if name == "opencv" else [tmp_path / "l.yaml", tmp_path / "r.yaml"]
    place = files[0] if len(files) == 1 else tuple(files)
    save_rig(rig, place, format=name)
    files[0].write_text(files[0].read_text() + "# the boat's\n")
    new = [tmp_path / f"new-{path.name}" for path in files]
    output, maps = ",".join(map(str, new)), tmp_path / "maps.npz"
    words = (*sides, "--calibration", *files, "--unit", "m", *COUNT)
    answer = command("recalibrate", *words, "--output", output, "--maps", maps)
    assert (answer.code, answer.err) == (0, "")
    assert new[0].read_text().endswith("# the boat's\n")
    scene = load_scene(drifted_scene)
    command("recalibrate", drifted_scene, *COUNT, "--output", tmp_path / "expected.json")
    expected = load_rig(tmp_path / "expected.json")
    again = load_rig(*new, unit="m")
    assert again.source.format == name
    np.testing.assert_allclose(again.extrinsics, expected.extrinsics, atol=1e-6)
    assert np.abs(again.extrinsics - scene.rig.extrinsics).max() > np.radians(0.1)
    made = sr.rectification(again)
    with np.load(maps) as stored:
        np.testing.assert_allclose(stored["Q"], made.Q, atol=1e-9)
        np.testing.assert_allclose(stored["right_y"], made.maps[1][1], atol=1e-3)
    old = [path.read_bytes() for path in files]
    answer = command("recalibrate", *words, "--output", ",".join(map(str, files)), "--force")
    assert answer.code == 0
    copies = [path.with_name(f"{path.name}.bak") for path in files]
    assert [path.read_bytes() for path in copies] == old
    said = " (translation in m)" if name == "opencv" else ""
    expected = [f"{path}: written{said}; the old one is {copy}" for path, copy in zip(files, copies, strict=True)]
    assert answer.out.splitlines()[-len(files) - 1 : -1] == expected
    assert [path.read_bytes() for path in files] == [path.read_bytes() for path in new]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--output", "{tmp}/l.yaml", "{tmp}/r.yaml"), "r.yaml is taken for a scene folder (the two files"),
        (("--maps", "{tmp}/maps.txt"), "maps are written as .npz"),
        (("--output", "{tmp}/new.yaml", "--json", "{tmp}/new.yaml"), "name the same file"),
    ],
)
def test_places_that_make_no_sense(command, rig: sr.StereoRig, sides, tmp_path: Path, unworked, words, said: str):
    save_rig(short(rig), tmp_path / "a.yaml", format="kalibr")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    options = [word.format(tmp=tmp_path) for word in words]
    repair = ("recalibrate", *sides, "--calibration", tmp_path / "a.yaml", *unworked)
    command(*repair, *options).refuses(said)
    with write_protected("a.yaml"):
        command(*repair, "--output", tmp_path / "a.yaml", "--force").refuses("allow writing")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_maps_of_a_calibration_that_is_good(command, clean_scene: Path, tmp_path: Path):
    """They were asked for; a calibration file is there already."""
    words = (clean_scene, "--maps", tmp_path / "maps.npz", "--output", tmp_path / "new.json")
    answer = command("recalibrate", *words)
    assert (answer.code, answer.err) == (0, "")
    assert f"{tmp_path}/maps.npz: written for the initial calibration\n" in answer.out
    assert "new.json: not written" in answer.out
    with np.load(tmp_path / "maps.npz") as stored:
        np.testing.assert_allclose(stored["Q"], sr.rectification(load_scene(clean_scene).rig).Q, atol=1e-12)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("coefficients", [5, 12])  # of twelve all programs are others
def test_a_file_keeps_its_number_of_coefficients(
    command, drifted_scene: Path, sides, tmp_path: Path, coefficients: int
):
    """Thin prisms are no news to a file that has them; one of five would be another file to other programs."""
    given = load_scene(drifted_scene).rig
    cameras = {side: getattr(given, side) for side in ("left", "right")}
    longer = {
        side: replace(one, distortion=np.append(one.distortion, [1e-6] * (coefficients - 5)))
        for side, one in cameras.items()
    }
    places = [tmp_path / name for name in ("given.yaml", "new.yaml")]
    save_rig(replace(given, **longer), places[0], format="opencv")
    answer = command("recalibrate", *sides, "--calibration", places[0], "--unit", "m", "--output", places[1])
    assert answer.code == 0
    before, after = (load_rig(place, unit="m", size=given.left.size).left.distortion for place in places)
    assert len(before) == len(after) == coefficients
    assert (after != before)[:5].all()
