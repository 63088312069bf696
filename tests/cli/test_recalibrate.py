"""`recalibrate` on small scenes: exit codes, what is printed, what is written, and what is not."""

import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from machine import at_call

import stereorecal as sr
from stereorecal.io import load_rig, load_scene, save_scene

COUNT = ("--schedule", "count", "--scale", 0.5, "--budget", 40)  # improves the drifted scene
NOTHING = ("--schedule", "count", "--budget", 1)  # improves none


def finite(content) -> bool:
    """Whether a JSON text holds numbers that JSON has."""
    return not any(word in content for word in ("NaN", "Infinity"))


# --- the default schedule -----------------------------------------------------------------------------------


def test_default_schedule(command, clean_scene: Path, drifted_scene: Path, tmp_path: Path):
    """Alone and together with a good one; every number is in the JSON."""
    target, output = tmp_path / "all.json", tmp_path / "repaired.json"
    alone = command("recalibrate", drifted_scene, "--json", target, "--output", output)
    assert (alone.code, alone.err) == (0, "")
    assert alone.out.endswith(f"{output}: written\n")
    text = target.read_text()
    assert finite(text)
    content = json.loads(text)
    assert content["schema"] == "stereorecal.solution/2"
    assert {"python", "stereorecal", "jax", "numpy", "opencv"} <= content["versions"].keys()
    settings = content["settings"]
    assert settings["matcher"]["name"] == "sad"
    assert [stage["score"] for stage in settings["stages"]] == ["count", "epipolar", "epipolar"]
    assert settings["stages"][0]["strategy"] == "compass"
    assert settings["reach"] == {"degrees": 3.0, "baseline_fraction": 0.03}
    (repair,) = content["repairs"]
    scene = load_scene(drifted_scene)
    solution = sr.recalibrate(scene.rig, scene.pairs)
    assert (repair["accepted"], repair["healthy"], repair["reason"]) == (True, True, "improved")
    said = {name: repair[name] for name in ("verdict", "why", "advice", "message")}
    assert list(said.values()) == [solution.verdict, solution.reason.value, solution.advice, solution.message]
    assert alone.out.splitlines()[:2] == [solution.verdict, solution.advice]
    for when, said in (("before", solution.score_before), ("after", solution.score_after)):
        assert repair[f"score_{when}"] == {"count": said.count, "pixels": 160 * 120, "fraction": said.fraction}
        assert repair["row_error_px"][when] == getattr(solution.row_errors, when)
    for which, rig in (("before", scene.rig), ("candidate", solution.candidate), ("used", solution.rig)):
        angles = np.radians(list(repair["extrinsics"][which]["rotation_deg"].values()))
        np.testing.assert_allclose(angles, rig.extrinsics[:3], rtol=1e-14)
        assert list(repair["extrinsics"][which]["translation_m"].values()) == rig.extrinsics[3:].tolist()
    change = repair["change"]
    np.testing.assert_allclose(list(change["rotation_deg"].values()), np.degrees(solution.change[:3]))
    np.testing.assert_allclose(
        list(change["translation_percent"].values()), 100 * solution.change[3:] / float(scene.rig.baseline)
    )
    widths = repair["interval_95"]
    found = [*widths["rotation_deg"].values(), *widths["translation_percent"].values()]
    np.testing.assert_allclose(found, solution.uncertainty.interval)
    assert list(repair["observed"]) == repair["covariance"]["axes"] == ["pitch", "yaw", "roll", "y", "z"]
    assert list(repair["observed"].values()) == solution.uncertainty.observed.tolist()
    np.testing.assert_allclose(repair["covariance"]["matrix"], solution.covariance)
    assert list(repair["depth_error_percent"]) == ["5", "10", "30", "100"]
    assert repair["evaluations"] == solution.evaluations
    assert repair["cost"] == pytest.approx(solution.cost.budgeted)
    assert repair["cost_total"] == pytest.approx(solution.cost.total)
    assert repair["cost_of"] == pytest.approx(asdict(solution.cost))
    assert repair["seconds"] > 0
    assert sum(stage["evaluations"] for stage in repair["stages"]) == repair["evaluations"]
    assert repair["image_size"] == [160, 120]
    assert repair["frames"] == 1
    # What was written is a calibration to go on with, with the user's own keys.
    written = json.loads(output.read_text())
    assert written["boat"] == "Ladja"
    np.testing.assert_allclose(load_rig(output).extrinsics, solution.rig.extrinsics, rtol=0, atol=1e-12)

    both = command("recalibrate", drifted_scene, clean_scene, "--json", target, "--force")
    assert (both.code, both.err) == (0, "")
    assert "improved" in both.out
    assert "already good" in both.out
    repairs = json.loads(target.read_text())["repairs"]
    assert [r["accepted"] for r in repairs] == [True, False]
    assert repairs[1]["extrinsics"]["used"] == repairs[1]["extrinsics"]["before"]


# --- verdicts and exit codes --------------------------------------------------------------------------------


def test_0_repaired(command, drifted_scene: Path):
    answer = command("recalibrate", drifted_scene, *COUNT)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith("Repaired: ")


def test_1_not_improved_and_nothing_is_written(command, drifted_scene: Path, tmp_path: Path):
    target = tmp_path / "repaired.json"
    answer = command("recalibrate", drifted_scene, *NOTHING, "--output", target)
    assert (answer.code, answer.err) == (1, "")
    assert answer.out.startswith("Not repaired: ")
    assert answer.out.endswith(f"{target}: not written, since the initial calibration stays\n")
    assert list(tmp_path.iterdir()) == []


def test_an_old_file_stays_when_nothing_is_better(command, drifted_scene: Path, tmp_path: Path):
    target = tmp_path / "repaired.json"
    target.write_text("precious")
    assert command("recalibrate", drifted_scene, *NOTHING, "--output", target, "--force").code == 1
    assert target.read_text() == "precious"


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("order", [1, -1])
def test_4_when_one_of_several_cannot_be_told(command, drifted_scene: Path, tmp_path: Path, order: int):
    fog = np.full((120, 160), 128.0, np.float32)
    fog[0, 0] = 129.0
    save_scene(replace(load_scene(drifted_scene), pairs=(sr.Pair(fog, fog[::-1].copy()),)), tmp_path / "fog")
    answer = command("recalibrate", *(drifted_scene, tmp_path / "fog")[::order], *COUNT)
    assert (answer.code, answer.err) == (4, "")
    assert "more matches" in answer.out
    assert "too little texture" in answer.out


def test_3_when_a_strategy_crashes(command, drifted_scene: Path, tmp_path: Path, crashing):
    places = ("--json", tmp_path / "out.json", "--output", tmp_path / "repaired.json")
    answer = command("recalibrate", drifted_scene, *COUNT, "--strategy", "crashing", *places)
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.count("\n") == 1
    assert "drifted: strategy crashing" in answer.err
    assert "Traceback" not in answer.err
    assert list(tmp_path.iterdir()) == []
    asked = command("--traceback", "recalibrate", drifted_scene, *COUNT, "--strategy", "crashing")
    assert 'raise KeyError("a bug")' in asked.err
    assert asked.err.splitlines()[-1] == answer.err.strip()


def test_2_when_one_of_several_turns_out_bad(command, folder: Path, drifted_scene: Path, tmp_path: Path):
    """Swapped images are seen only while matching; what is finished by then is kept."""
    left, right = (folder / f"{side}.png" for side in ("left", "right"))
    swapped = left.read_bytes()
    left.write_bytes(right.read_bytes())
    right.write_bytes(swapped)
    answer = command("recalibrate", folder, drifted_scene, *COUNT, "--json", tmp_path / "out.json")
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "look swapped" in answer.err
    assert "failed (input)" in answer.out
    repairs = json.loads((tmp_path / "out.json").read_text())["repairs"]
    assert [repair["fault"] for repair in repairs] == ["input", None]
    assert repairs[1]["accepted"]


# --- input --------------------------------------------------------------------------------------------------


def test_files_that_lie_anywhere(command, drifted_scene: Path, tmp_path: Path):
    scene, loose = tmp_path / "scene.json", tmp_path / "loose.json"
    words = [f"--{side}={drifted_scene}/{side}.*" for side in ("left", "right")]
    assert command("recalibrate", drifted_scene, *COUNT, "--output", scene).code == 0
    calibration = ("--calibration", drifted_scene / "calib.json")
    assert command("recalibrate", *words, *calibration, *COUNT, "--output", loose).code == 0
    assert json.loads(scene.read_text()) == json.loads(loose.read_text())


@pytest.mark.parametrize(("words", "frames"), [((), 2), (("--pairs", 0), 1)])
def test_frames(command, drifted_scene: Path, tmp_path: Path, words, frames: int):
    for side in ("left", "right"):
        for name in ("0", "1"):
            (tmp_path / "s" / side).mkdir(parents=True, exist_ok=True)
            shutil.copy(drifted_scene / f"{side}.png", tmp_path / "s" / side / f"{name}.png")
    shutil.copy(drifted_scene / "calib.json", tmp_path / "s")
    content = json.loads(command("recalibrate", tmp_path / "s", *NOTHING, *words, "--json", "-").out)
    assert content["repairs"][0]["frames"] == frames


@pytest.mark.parametrize("matcher", ["bm", "sgbm"])
def test_matchers(command, drifted_scene: Path, matcher: str):
    answer = command("recalibrate", drifted_scene, *COUNT, "--matcher", matcher, "--json", "-")
    content = json.loads(answer.out)
    assert content["settings"]["matcher"]["name"] == matcher
    assert content["repairs"][0]["score_before"]["count"] > 500


@pytest.mark.slow
def test_strategy_goes_into_the_stages_of_its_kind(command, drifted_scene: Path):
    def settings(*words):
        return json.loads(command("recalibrate", drifted_scene, *words, "--json", "-").out)["settings"]

    asked = settings("--strategy", "nlopt-bobyqa", "--seed", 7, "--reach", "2,0.01", "--budget", 1)
    kinds = [(stage["score"], stage["strategy"]) for stage in asked["stages"]]
    assert kinds[0] == ("count", "nlopt-bobyqa")
    assert {name for kind, name in kinds if kind == "epipolar"} == {"levenberg-marquardt"}
    assert (asked["seed"], asked["reach"]) == (7, {"degrees": 2.0, "baseline_fraction": 0.01})
    asked = settings("--schedule", "count", "--scale", 0.25, "--budget", 9)
    (stage,) = asked["stages"]
    assert (stage["strategy"], stage["scale"]) == ("compass", 0.25)
    assert asked["budget"]["evaluations"] == 9


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
def test_intrinsics_of_several_recordings(command, drifted_scene: Path, tmp_path: Path):
    """What is said of them is said once; they leave no more than the extrinsics alone would."""
    target = tmp_path / "solution.json"
    words = ("--free", "extrinsics,intrinsics", "--extrinsics", "one", "--json", target)
    answer = command("recalibrate", drifted_scene, drifted_scene, *words, "--output", tmp_path / "new.json")
    assert answer.code in (0, 1)
    assert "new.json: " in answer.out
    for found in (repair["intrinsics"] for repair in json.loads(target.read_text())["repairs"]):
        assert answer.out.count(found["verdict"]) == 1
        assert found["freed_px"] < found["fixed_px"] + 0.05


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--free", "extrinsic"], "did you mean extrinsics"),
        (["--free", "intrinsics"], "free them as well"),
        (["--free", ""], "--free is empty; give"),
        (["--extrinsics", "two"], "kind of extrinsics"),
        (["--ranges", "/none.csv"], "no such file"),
    ],
)
def test_what_is_free_is_checked(command, drifted_scene: Path, words, said):
    answer = command("recalibrate", drifted_scene, *words)
    assert answer.code == 2
    assert said in answer.err


def test_ranges_of_other_pairs(command, drifted_scene: Path, tmp_path: Path):
    table = tmp_path / "ranges.csv"
    table.write_text("pair,column,row,metres\nnobody,10,10,3.5\n")
    answer = command("recalibrate", drifted_scene, "--ranges", table)
    assert answer.code == 2
    assert "nobody" in answer.err


# --- output -------------------------------------------------------------------------------------------------


def test_nothing_is_overwritten_without_force(command, drifted_scene: Path, tmp_path: Path, moody):
    target = tmp_path / "repaired.json"
    target.write_text("precious")
    moody(lambda run: pytest.fail("worked before it looked"))
    answer = command("recalibrate", drifted_scene, *COUNT, "--strategy", "moody", "--output", target)
    assert (answer.code, answer.out) == (2, "")
    assert "repaired.json: the file exists already; choose another or add --force" in answer.err
    assert target.read_text() == "precious"
    assert command("recalibrate", drifted_scene, *COUNT, "--output", target, "--force").code == 0
    assert load_rig(target).left.size == (160, 120)
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_that_appears_meanwhile_is_not_overwritten(command, drifted_scene: Path, tmp_path: Path):
    target = tmp_path / "repaired.json"
    with at_call("fsync", lambda _: target.write_text("precious")):
        answer = command("recalibrate", drifted_scene, *COUNT, "--output", target)
    assert answer.code == 2
    assert "the file exists already" in answer.err
    assert target.read_text() == "precious"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["{scene}", "--output={tmp}"], "cannot be written there"),
        (["{scene}", "--output={tmp}/a.json", "--json={tmp}/../{name}/a.json"], "name the same file"),
        (["{scene}", "{scene}", "--output={tmp}/a.json"], "--output takes the calibration of one recording"),
    ],
    ids=["folder", "the file of --json", "several recordings"],
)
def test_places_that_make_no_sense(command, drifted_scene: Path, tmp_path: Path, words: list[str], said: str):
    answer = command(
        "recalibrate", *(w.format(scene=drifted_scene, tmp=tmp_path, name=tmp_path.name) for w in words), *COUNT
    )
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    assert answer.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_the_calibration_in_use_is_replaced_in_place_only(command, drifted_scene: Path, tmp_path: Path):
    folder = Path(shutil.copytree(drifted_scene, tmp_path / "scene"))
    old, before = (folder / "calib.json").read_bytes(), load_scene(folder)
    for words in (("--output", folder / "calib.json"), ("--output", folder / "calib.json", "--force")):
        answer = command("recalibrate", folder, *COUNT, *words)
        assert (answer.code, answer.out) == (2, "")
        assert (folder / "calib.json").read_bytes() == old
    assert "this is an input file of the run and will not be overwritten; replace it with --in-place" in answer.err
    assert command("recalibrate", folder, *COUNT, "--in-place").code == 0
    assert (folder / "calib.json.bak").read_bytes() == old
    after = load_scene(folder)
    assert after.info == before.info
    assert np.abs(after.rig.extrinsics - before.rig.extrinsics).max() > np.radians(0.1)


def test_json_on_stdout_and_nothing_else(command, drifted_scene: Path):
    answer = command("recalibrate", drifted_scene, *COUNT, "--json", "-")
    assert (answer.code, answer.err) == (0, "")
    (repair,) = json.loads(answer.out)["repairs"]
    assert repair["row_error_px"] is repair["covariance"] is None


@pytest.mark.parametrize("count", [1, 2])
def test_quiet(command, drifted_scene: Path, tmp_path: Path, count: int, terminal):
    terminal("stderr")
    target = tmp_path / "out.json"
    answer = command("recalibrate", *[drifted_scene] * count, *COUNT, "--quiet", "--json", target)
    assert (answer.code, answer.out, answer.err) == (0, "", "")
    assert len(json.loads(target.read_text())["repairs"]) == count


@pytest.mark.parametrize("there", [False, True])
def test_progress_only_on_a_terminal(command, drifted_scene: Path, terminal, there: bool):
    terminal("stderr", there)
    answer = command("recalibrate", drifted_scene, *COUNT)
    assert ("repairing" in answer.err) == there
    assert (answer.err == "") == (not there)
    assert "repairing" not in answer.out


def test_threads(command, clean_scene: Path, drifted_scene: Path):
    plain, threads = (
        json.loads(command("recalibrate", drifted_scene, clean_scene, *COUNT, "--executor", kind, "--json", "-").out)
        for kind in ("serial", "threads:2")
    )
    for one, two in zip(plain["repairs"], threads["repairs"], strict=True):
        assert {**one, "seconds": 0} == {**two, "seconds": 0}


def test_an_endless_budget_is_no_number_for_json(command, drifted_scene: Path):
    answer = command("recalibrate", drifted_scene, *COUNT, "--budget", "inf", "--json", "-")
    assert answer.code == 0
    assert json.loads(answer.out)["settings"]["budget"] == {"evaluations": None, "seconds": None}
    assert finite(answer.out)
