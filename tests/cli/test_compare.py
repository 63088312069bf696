"""`compare` on a small scene: exit codes, what goes to stdout, to stderr and to the file."""

import json
from pathlib import Path

import pytest

SMALL = ("--schedule", "count", "--draws", 2, "--scale", 0.5, "--budget", 5)


def test_table_and_json(command, clean_scene: Path, tmp_path: Path):
    target = tmp_path / "out.json"
    answer = command("compare", "--scene", clean_scene, *SMALL, "--json", target)
    assert answer.code == 0
    assert answer.err == ""
    assert "compass" in answer.out
    content = json.loads(target.read_text())
    assert content["schema"] == "stereorecal.compare/1"
    assert len(content["trials"]) == 2
    assert content["scenes"][0]["name"].endswith("/clean")


@pytest.mark.slow
def test_both_schedules_side_by_side(command, clean_scene: Path, tmp_path: Path):
    page = tmp_path / "out.html"
    answer = command("compare", "--scene", clean_scene, "--draws", 1, "--budget", 5, "--html", page)
    assert (answer.code, answer.err) == (0, "")
    rows = [line.split() for line in answer.out.splitlines() if line.split()[:1] in (["default"], ["count"])]
    names = [(row[0], row[1]) for row in rows if row[1] == "compass"]
    assert names == 2 * [("default", "compass"), ("count", "compass")]  # medians, and by the true rig
    assert "levenberg-marquardt" in answer.out
    assert "schedule count: the paper's way" in answer.out
    assert all(len(line) <= 120 for line in answer.out.splitlines())
    text = page.read_text(encoding="utf-8")
    assert "2 schedules on 1 scene" in text
    assert "compass + levenberg-marquardt" in text


def test_json_on_stdout_and_nothing_else(command, clean_scene: Path):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--json", "-")
    assert answer.code == 0
    assert answer.err == ""
    assert len(json.loads(answer.out)["trials"]) == 2


def test_intrinsics_in_the_box(command, clean_scene: Path):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--free", "extrinsics,left.k1", "--json", "-")
    assert answer.code == 0
    content = json.loads(answer.out)
    assert content["settings"]["free"] == ["pitch", "yaw", "roll", "y", "z", "left.k1"]
    assert {trial["status"] for trial in content["trials"]} == {"BUDGET"}
    answer = command("compare", "--scene", clean_scene, *SMALL, "--free", "left.k")
    assert answer.code == 2
    assert "unknown parameter 'left.k'; did you mean left.k" in answer.err


@pytest.mark.parametrize("to_file", [False, True])
def test_quiet(command, clean_scene: Path, tmp_path: Path, to_file: bool):
    target = tmp_path / "out.json"
    answer = command("compare", "--scene", clean_scene, *SMALL, "--quiet", *(["--json", target] if to_file else []))
    assert (answer.code, answer.out, answer.err) == (0, "", "")
    assert target.exists() == to_file


def test_an_existing_json_is_replaced_by_force(command, clean_scene: Path, tmp_path: Path):
    target = tmp_path / "out.json"
    target.write_text("old")
    words = ("compare", "--scene", clean_scene, *SMALL, "--quiet", "--json", target)
    answer = command(*words)
    assert answer.code == 2
    assert "the file exists already; choose another or add --force" in answer.err
    assert target.read_text() == "old"
    assert command(*words, "--force").code == 0
    assert json.loads(target.read_text())["settings"]["draws"] == 2
    assert list(tmp_path.iterdir()) == [target]


def test_3_when_every_row_failed(command, clean_scene: Path, crashing):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--strategies", "crashing", "--json", "-")
    assert answer.code == 3
    trials = json.loads(answer.out)["trials"]
    assert {trial["status"] for trial in trials} == {"FAILED"}
    assert "Traceback" not in answer.err


def test_0_when_only_some_failed(command, clean_scene: Path, crashing):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--strategies", "crashing,compass")
    assert answer.code == 0
    assert "FAILED" in answer.out
    assert "BUDGET" in answer.out


def test_all_strategies(command, clean_scene: Path, crashing):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--strategies", "all", "--json", "-")
    assert [t["strategy"] for t in json.loads(answer.out)["trials"]] == ["compass", "crashing"] * 2


@pytest.mark.parametrize("matcher", ["bm", "sgbm"])
def test_matchers(command, clean_scene: Path, matcher: str):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--matcher", matcher, "--json", "-")
    content = json.loads(answer.out)
    assert content["settings"]["matcher"]["name"] == matcher
    assert all(trial["score_reference"] > 500 for trial in content["trials"])


def test_threads(command, clean_scene: Path):
    plain, threads = (
        json.loads(command("compare", "--scene", clean_scene, *SMALL, "--executor", kind, "--json", "-").out)
        for kind in ("serial", "threads:2")
    )
    assert [t["score_final"] for t in threads["trials"]] == [t["score_final"] for t in plain["trials"]]


@pytest.mark.parametrize("there", [False, True])
def test_progress_only_on_a_terminal(command, clean_scene: Path, terminal, there: bool):
    terminal("stderr", there)
    answer = command("compare", "--scene", clean_scene, *SMALL)
    assert ("repairing" in answer.err) == there
    assert (answer.err == "") == (not there)
    assert "repairing" not in answer.out


def test_quiet_has_no_progress_on_a_terminal_either(command, clean_scene: Path, terminal):
    terminal("stderr")
    assert command("compare", "--scene", clean_scene, *SMALL, "--quiet").err == ""


def test_a_scale_for_the_default_schedule_is_refused(command):
    answer = command("compare", "--schedule", "default", "--scale", "0.5")
    assert (answer.code, answer.err) == (2, "stereorecal: --scale belongs to --schedule count; leave it out.\n")
