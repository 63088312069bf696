"""`compare` on a small scene: exit codes, what goes to stdout, to stderr and to the file."""

import json
from pathlib import Path

import pytest

SMALL = ("--schedule", "count", "--draws", 2, "--scale", 0.5, "--budget", 5)


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


def test_intrinsics_in_the_box(command, clean_scene: Path):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--free", "extrinsics,left.k1", "--json", "-")
    assert answer.code == 0
    content = json.loads(answer.out)
    assert content["settings"]["free"] == ["pitch", "yaw", "roll", "y", "z", "left.k1"]
    assert {trial["status"] for trial in content["trials"]} == {"BUDGET"}


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


def test_a_scale_for_the_default_schedule_is_refused(command):
    answer = command("compare", "--schedule", "default", "--scale", "0.5")
    assert (answer.code, answer.err) == (2, "stereorecal: --scale belongs to --schedule count; leave it out.\n")
