"""`reproduce` as a user meets it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from machine import raising
from stereorecal_paper import EXPERIMENTS, _command, save_calibrations, save_mission

from stereorecal.recordings import Mission
from stereorecal.synthetic import default_rig, render


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain log of one sequence of two pairs, with two calibrations."""
    folder = tmp_path_factory.mktemp("logs") / "log"
    scene = render("harbour", 0, rig=default_rig().resized((160, 120)), frames=2)
    assert scene.rig is not None
    other = scene.rig.with_extrinsics(scene.rig.extrinsics + np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0]))
    save_calibrations({"2020-01-01": scene.rig, "2020-06-01": other}, folder)
    pairs = tuple(replace(pair, name=f"{index}.png") for index, pair in enumerate(scene.pairs))
    save_mission(Mission("2020-01-02-quay", "2020-01-01", pairs, truth=scene.rig), folder)
    return folder


@pytest.fixture
def words(log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The arguments of a run on a log, which does even less than --quick asks for."""
    monkeypatch.setattr(_command, "QUICK", replace(_command.QUICK, points=3, iterations=2))
    return ["--log", log, "--quick", "--schedule", "count", "--output", tmp_path / "out"]


def test_tables_and_files(command, words, tmp_path: Path):
    found = command("reproduce", "validity", "ex-nihilo", *words)
    assert found.code == 0, found.err
    assert "own is highest" in found.out
    assert "ex nihilo: summary" in found.out
    assert "the paper" in found.out
    assert str(tmp_path / "out") in found.err
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"validity.json", "rows.jsonl", "validity.csv", "validity.png", "ex_nihilo.pdf", "sweeps.csv"} <= names
    assert not [name for name in names if name.startswith("repair")]


@pytest.mark.slow
def test_a_second_run_repeats_nothing(command, words, tmp_path: Path, moody):
    words, runs = [*words, "--strategy", "moody"], moody()
    first = command("reproduce", "ex-nihilo", *words, "--json", tmp_path / "one.json")
    assert runs
    moody(raising(RuntimeError("was run again")))
    again = command("reproduce", "ex-nihilo", *words, "--json", tmp_path / "two.json")
    assert (first.code, again.code, runs) == (0, 0, [])
    assert first.out == again.out
    assert (tmp_path / "one.json").read_text() == (tmp_path / "two.json").read_text()


@pytest.mark.slow
def test_json_to_a_pipe_is_nothing_but_json(command, words):
    found = command("reproduce", "ex-nihilo", *words, "--json", "-")
    content = json.loads(found.out)
    assert content["schema"] == "stereorecal.reproduce/1"
    assert len(content["rows"]["ex_nihilo"]) == 1


@pytest.mark.slow
def test_interrupted(command, words, moody):
    words = ("reproduce", "validity", "ex-nihilo", *words, "--strategy", "moody")
    moody(raising(KeyboardInterrupt))
    found = command(*words)
    assert found.code == 130
    assert "run it again" in found.err
    assert "own is highest" in found.out
    assert "ex nihilo" not in found.out
    moody()
    assert command(*words).code == 0


@pytest.mark.slow
def test_failures_are_named(command, words, moody):
    words = [*words, "--strategy", "moody"]
    moody(raising(RuntimeError("the disk is on fire")))
    found = command("reproduce", "ex-nihilo", *words)
    assert found.code == 3
    assert "ex_nihilo:2020-01-02-quay/0.png/none/count: strategy moody" in found.err
    assert "the disk is on fire" in found.err
    moody()
    assert command("reproduce", "ex-nihilo", "validity", *words).code == 0


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["validty"], "did you mean validity?"),
        (["--schedule", "fast"], "unknown --schedule"),
        (["--strategy", "compas"], "compas"),
        (["--reach", "3"], "--reach"),
        (["--seed", "-1"], "--seed"),
        (["--frames", "0"], "--frames"),
        (["--log", "nowhere"], "no such folder"),
        (["--log", "."], "the layout is unknown"),
        (["--executor", "processes"], "number of workers"),
        (["--output", "/proc/none/x"], "cannot become a folder"),
        (["--output", "-"], "the results are files in a folder"),
    ],
    ids=lambda value: str(value[0]) if isinstance(value, list) else "",
)
def test_bad_input(command, words, tmp_path: Path, monkeypatch, asked, said):
    monkeypatch.chdir(tmp_path)
    found = command("reproduce", *words, *asked)
    assert found.code == 2
    assert said in found.err
    assert found.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_frames_without_a_log(command, tmp_path: Path):
    found = command("reproduce", "--quick", "--frames", "2", "--output", tmp_path / "out")
    assert found.code == 2
    assert "--frames belongs to --log" in found.err


@pytest.mark.slow
def test_without_a_log_one_is_rendered_once(command, tmp_path: Path, small_synthetic_log, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    options = ["--quick", "--schedule", "count", "--output", tmp_path / "out"]
    found = command("reproduce", "validity", *options)
    assert found.code == 0, found.err
    missions = list((tmp_path / "cache").rglob("mission.json"))
    assert len(missions) == 2
    before = [path.stat().st_mtime_ns for path in missions]
    assert command("reproduce", "validity", *options).code == 0
    assert [path.stat().st_mtime_ns for path in missions] == before


def test_no_input_is_replaced(command, words, log: Path, tmp_path: Path):
    rows, link = tmp_path / "out" / "rows.jsonl", tmp_path / "link.json"
    rows.parent.mkdir()
    rows.touch()
    for path in (log / "calibrations" / "2020-01-01.json", rows):
        before = path.read_bytes()
        link.hardlink_to(path)
        found = command("reproduce", *words, "--json", link, "--force")
        link.unlink()
        assert (found.code, path.read_bytes()) == (2, before)
        assert "will not be overwritten" in found.err


def test_the_folder_takes_its_own_files_only(command, words, tmp_path: Path):
    """Under the names of its results, the JSON would be replaced by them."""
    found = command("reproduce", *words, "--output", tmp_path, "--json", tmp_path / "accuracy.json")
    assert (found.code, list(tmp_path.iterdir())) == (2, [])
    assert "takes its own files only" in found.err


def test_a_broken_matcher_is_a_sentence(command, words, install):
    install("stereorecal.matchers", {"shaky": "no_such_module:Matcher"})
    found = command("reproduce", *words, "--matcher", "shaky")
    assert (found.code, found.out, found.err.count("\n")) == (3, "", 1)
    assert "matcher shaky of plug-in 1.2 cannot be loaded" in found.err


def test_a_wrong_name_is_said_at_once(at_once):
    ((answer, loaded),) = at_once("reproduce --log nowhere")
    assert (answer.code, loaded) == (2, set()), answer


def test_help_says_what_there_is(command):
    assert f"{', '.join(EXPERIMENTS)}, all" in " ".join(command("reproduce", "--help").out.split())
