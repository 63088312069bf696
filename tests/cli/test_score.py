"""`score` on small scenes: the verdict, the exit code, and the JSON."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from spoiled import turned

import stereorecal as sr
from stereorecal.decision import LIMITS
from stereorecal.io import load_scene, save_scene
from stereorecal.recalibration import HEALTH_LIMITS, health

SIZE = (320, 240)  # smaller images do not determine yaw


@pytest.fixture(scope="module")
def clean_scene(scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes") / "clean"
    save_scene(scene("harbour", 0, SIZE), folder)
    return folder


@pytest.fixture(scope="module")
def drifted_scene(scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, shown = tmp_path_factory.mktemp("scenes") / "drifted", scene("harbour", 0, SIZE)
    save_scene(replace(shown, rig=turned(shown.rig, 0.8, 0.3, -0.9, 0.003, -0.003)), folder)
    return folder


def test_healthy(command, clean_scene: Path, tmp_path: Path):
    target = tmp_path / "out.json"
    answer = command("score", clean_scene, "--json", target)
    assert (answer.code, answer.err) == (0, "")
    scene = load_scene(clean_scene)
    found = health(scene.rig, scene.pairs)
    assert answer.out == f"{found}\n"
    assert str(sr.score(scene.rig, scene.pairs)) in answer.out
    assert f"rows differ by {found.row_errors.before:.2f} px in the median" in answer.out
    content = json.loads(target.read_text())
    assert content["schema"] == "stereorecal.health/4"
    assert {"python", "stereorecal", "jax", "numpy", "opencv"} <= content["versions"].keys()
    *names, last = content["settings"]
    assert (names, last) == (sorted(names), "thresholds")  # one order in every process
    assert content["settings"]["thresholds"] == {**HEALTH_LIMITS, **LIMITS, "distances": [5.0, 10.0, 30.0]}
    assert content["interrupted"] is False
    (said,) = content["scenes"]
    about = {"scene": scene.name, "frames": 1, "image_size": list(SIZE), "error": None}
    expected = {**about, **json.loads(json.dumps(found.to_dict(), allow_nan=False))}
    assert {**said, "seconds": None} == {**expected, "seconds": None}


@pytest.mark.parametrize("finished", [0, 1])
def test_interrupted(command, clean_scene: Path, drifted_scene: Path, tmp_path: Path, moody_matcher, finished: int):
    searches = moody_matcher()
    if finished:
        command("score", clean_scene, "--matcher", "moody", "--quiet")
    before = len(searches)

    def interrupt(search: int) -> None:
        if search > before:
            raise KeyboardInterrupt

    moody_matcher(interrupt)
    target = tmp_path / "out.json"
    answer = command("score", clean_scene, drifted_scene, "--matcher", "moody", "--json", target)
    assert answer.code == 130
    assert f"interrupted; {finished} of 2 recordings were finished" in answer.err
    assert target.exists() == ("Good" in answer.out) == bool(finished)
    if finished:
        content = json.loads(target.read_text())
        assert content["interrupted"] is True
        assert [scene["healthy"] for scene in content["scenes"]] == [True]


def test_tolerances_are_taken_and_told(command, drifted_scene: Path):
    answer = command("score", drifted_scene, "--json", "-", "--tolerances", "harm=0.001,distances=8:3")
    settings = json.loads(answer.out)["settings"]
    assert settings["thresholds"]["harm"] == 0.001
    assert settings["thresholds"]["distances"] == [3.0, 8.0]


def test_a_scene_is_checked_with_another_calibration(command, clean_scene: Path, drifted_scene: Path):
    """Such as the one that a repair wrote; how its file is read can be said, too."""
    assert command("score", drifted_scene).code != 0
    theirs = ("--calibration", clean_scene / "calib.json", "--format", "stereorecal")
    both = command("score", clean_scene, drifted_scene, *theirs, "--json", "-")
    assert both.code == 0
    assert [scene["healthy"] for scene in json.loads(both.out)["scenes"]] == [True, True]
    assert "belong to --calibration" in command("score", drifted_scene, "--unit", "mm").err


def test_depth_is_reported_where_it_is_asked_for(command, clean_scene: Path):
    answer = command("score", clean_scene, "--json", "-", "--distances", "2m,40cm,30")
    (scene,) = json.loads(answer.out)["scenes"]
    baseline = load_scene(clean_scene).rig.baseline
    assert [one["distance_m"] for one in scene["depth"]] == pytest.approx([2.0, 0.4, 30 * baseline])
    for one in scene["depth"]:
        error = one["before"]
        assert error["metres"]["low"] == pytest.approx(0.01 * error["percent"]["low"] * one["distance_m"])
    text = command("score", clean_scene, "--distances", "2m,40cm,200cm").out
    assert [line.split()[:5] for line in text.splitlines() if line.startswith("depth ")] == [
        ["depth", "error", "at", "2", "m"],
        ["depth", "error", "at", "40", "cm"],
    ]


@pytest.mark.slow(after=3)
def test_what_is_fixed_is_said_and_written(command, clean_scene: Path, tmp_path: Path):
    scene = load_scene(clean_scene)
    (pair,) = scene.pairs
    swapped, doubled = tmp_path / "swapped", tmp_path / "doubled"
    save_scene(replace(scene, pairs=(replace(pair, left=pair.right, right=pair.left, origin=None),)), swapped)
    left, right = (replace(of, matrix=np.diag([2.0, 2.0, 1.0]) @ of.matrix) for of in (scene.rig.left, scene.rig.right))
    save_scene(replace(scene, rig=replace(scene.rig, left=left, right=right)), doubled)
    assert command("score", swapped).code == 2
    answer = command("score", swapped, "--fix", "exchanged", "--json", tmp_path / "out.json")
    assert answer.code == 0
    assert "left and right exchanged (--fix exchanged)" in answer.err
    assert json.loads((tmp_path / "out.json").read_text())["settings"]["fix"] == "exchanged"
    answer = command("recalibrate", doubled, "--fix", "scaled", "--output", tmp_path / "calib.json")
    assert answer.code == 0
    assert "K scaled by 0.5 (--fix scaled)" in answer.err
    assert "calib.json: written" in answer.out, "though nothing is repaired, the file had another K"
    written = sr.io.load_rig(tmp_path / "calib.json")
    np.testing.assert_allclose(written.left.focal, scene.rig.left.focal, rtol=0.01)
    for words in ((swapped, doubled), (swapped, "--pairs", "::2"), (swapped,)):
        fix = "late" if "--pairs" in words else "exchanged" if len(words) > 1 else "early"
        assert command("score", *words, "--fix", fix).code == 2
