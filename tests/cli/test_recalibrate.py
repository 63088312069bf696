"""`recalibrate` on small scenes: exit codes, what is printed, what is written, and what is not."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.io import load_rig, load_scene

COUNT = ("--schedule", "count")  # improves the drifted scene
NOTHING = ("--schedule", "count:moody")  # improves none


# --- the default schedule -----------------------------------------------------------------------------------


def test_default_schedule(command, drifted_scene: Path, tmp_path: Path):
    """Every number is in the JSON. (Of several: test_every_command.)"""
    target, output = tmp_path / "all.json", tmp_path / "repaired.json"
    alone = command("recalibrate", drifted_scene, "--json", target, "--output", output)
    assert (alone.code, alone.err) == (0, "")
    assert alone.out.endswith(f"{output}: written\n")
    text = target.read_text()
    assert not any(word in text for word in ("NaN", "Infinity"))
    content = json.loads(text)
    assert content["schema"] == "stereorecal.solution/3"
    assert {"python", "stereorecal", "jax", "numpy", "opencv"} <= content["versions"].keys()
    settings = content["settings"]
    assert settings["matcher"]["name"] == "sad"
    assert [stage["score"] for stage in settings["stages"]] == ["count", "epipolar", "epipolar"]
    assert settings["stages"][0]["strategy"] == "compass"
    assert settings["reach"] == {"degrees": 3.0, "baseline_fraction": 0.03}
    (repair,) = content["repairs"]
    scene = load_scene(drifted_scene)
    solution = sr.recalibrate(scene.rig, scene.pairs)
    expected = json.loads(json.dumps(solution.to_dict(), allow_nan=False))
    told = {"scene", "error", "fault", "image_size", "frames"}
    assert {**repair, "seconds": None} == {**expected, **{name: repair[name] for name in told}, "seconds": None}
    assert (repair["reason"], repair["error"], repair["fault"]) == ("improved", None, None)
    assert alone.out.splitlines()[:2] == [solution.verdict, solution.advice]
    assert (repair["seconds"] > 0, repair["image_size"], repair["frames"]) == (True, [160, 120], 1)
    # What was written is a calibration to go on with, with the user's own keys.
    written = json.loads(output.read_text())
    assert written["boat"] == "Ladja"
    np.testing.assert_allclose(load_rig(output).extrinsics, solution.rig.extrinsics, rtol=0, atol=1e-12)


# --- verdicts and exit codes --------------------------------------------------------------------------------


@pytest.mark.parametrize("there", [False, True])
def test_1_not_improved_and_nothing_is_written(command, drifted_scene: Path, tmp_path: Path, moody, there: bool):
    """Nor is an old file replaced, though it might be."""
    target = tmp_path / "repaired.json"
    if there:
        target.write_text("precious")
    answer = command("recalibrate", drifted_scene, *NOTHING, "--output", target, "--force")
    assert (answer.code, answer.err) == (1, "")
    assert answer.out.startswith("Not repaired: ")
    assert answer.out.endswith(f"{target}: not written, since the initial calibration stays\n")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["precious"] * there


def test_3_when_a_strategy_crashes(command, drifted_scene: Path, tmp_path: Path, crashing):
    places = ("--json", tmp_path / "out.json", "--output", tmp_path / "repaired.json")
    answer = command("recalibrate", drifted_scene, "--schedule", "count:crashing", *places)
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.count("\n") == 1
    assert "drifted: strategy crashing" in answer.err
    assert "Traceback" not in answer.err
    assert list(tmp_path.iterdir()) == []
    asked = command("--traceback", "recalibrate", drifted_scene, "--schedule", "count:crashing")
    assert 'raise KeyError("a bug")' in asked.err
    assert asked.err.splitlines()[-1] == answer.err.strip()


# --- input --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_strategy_goes_into_the_stages_of_its_kind(command, drifted_scene: Path):
    words = ("--schedule", "default:nlopt-bobyqa", "--reach", "2,0.01")
    asked = json.loads(command("recalibrate", drifted_scene, *words, "--json", "-").out)["settings"]
    kinds = [(stage["score"], stage["strategy"]) for stage in asked["stages"]]
    assert kinds == [("count", "nlopt-bobyqa"), ("epipolar", "fit"), ("epipolar", "fit")]
    assert asked["reach"] == {"degrees": 2.0, "baseline_fraction": 0.01}


# --- what is free -------------------------------------------------------------------------------------------


def test_nothing_but_the_rotation_moves(command, drifted_scene: Path, tmp_path: Path):
    target = tmp_path / "solution.json"
    answer = command("recalibrate", drifted_scene, "--free", "rotation", "--json", target)
    content = json.loads(target.read_text())
    assert content["settings"]["free"] == ["pitch", "yaw", "roll"]
    (repair,) = content["repairs"]
    assert repair["change"]["translation_percent"] == {"x": 0.0, "y": 0.0, "z": 0.0}
    assert list(repair["interval_95"]["rotation_deg"]) == ["pitch", "yaw", "roll"]
    assert repair["interval_95"]["translation_percent"] == {}
    assert repair["expected"]["rows_px"] > 0
    assert answer.code in (0, 1)


@pytest.mark.slow
def test_folders_of_one_rig_as_one_recording(command, drifted_scene: Path, tmp_path: Path):
    """What is said of them is said once."""
    target = tmp_path / "solution.json"
    words = ("--free", "extrinsics,intrinsics", "--json", target)
    again = shutil.copytree(drifted_scene, tmp_path / "again")
    answer = command("recalibrate", f"{drifted_scene}+{again}", *words, "--output", tmp_path / "new.json")
    assert answer.code in (0, 1)
    assert "new.json: " in answer.out
    (repair,) = json.loads(target.read_text())["repairs"]
    assert repair["frames"] == 2
    found = repair["intrinsics"]
    assert answer.out.count(found["verdict"]) == 1
    assert repair["row_error_px"]["after"] < 0.3


def test_ranges_of_other_pairs(command, drifted_scene: Path, tmp_path: Path):
    table = tmp_path / "ranges.csv"
    table.write_text("pair,column,row,metres\nnobody,10,10,3.5\n")
    command("recalibrate", drifted_scene, "--ranges", table).refuses("nobody")


# --- output -------------------------------------------------------------------------------------------------


def test_the_calibration_of_one_recording_is_written(command, drifted_scene: Path, tmp_path: Path):
    answer = command("recalibrate", drifted_scene, drifted_scene, "--output", tmp_path / "a.json", *COUNT)
    answer.refuses("--output takes one recording")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("join", "words", "said"),
    [
        ("{0}+{0}", (), "name each once"),
        ("{0}+", (), "name each once"),
        ("{0}+{1}", ("--motion", "on"), "--motion on takes the pairs of one folder"),
        ("{0}+{1}", ("--fix", "late"), "--fix takes the pairs of one folder"),
        ("{0}+{1}", (), "has another calibration"),
    ],
)
def test_what_is_no_recording_of_several_folders(command, drifted_scene: Path, clean_scene: Path, join, words, said):
    command("recalibrate", join.format(drifted_scene, clean_scene), *words).refuses(said)
