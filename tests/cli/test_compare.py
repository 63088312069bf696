"""`compare` on a small scene: exit codes, what goes to stdout, to stderr and to the file."""

import json
from pathlib import Path

import pytest

SMALL = ("--schedule", "count", "--draws", 2, "--scale", 0.5, "--budget", 5)


def test_intrinsics_in_the_box(command, clean_scene: Path):
    answer = command("compare", "--scene", clean_scene, *SMALL, "--free", "extrinsics,left.k1", "--json", "-")
    assert answer.code == 0
    content = json.loads(answer.out)
    assert content["settings"]["free"] == ["pitch", "yaw", "roll", "y", "z", "left.k1"]
    assert {trial["status"] for trial in content["trials"]} == {"BUDGET"}


FAILING = {  # exit code, and how each strategy ended
    "crashing": (3, {"crashing": "FAILED"}),
    "crashing,compass": (0, {"compass": "BUDGET", "crashing": "FAILED"}),
    "all": (0, {"compass": "BUDGET", "crashing": "FAILED"}),
}


@pytest.mark.parametrize(("names", "expected"), FAILING.items())
def test_3_when_every_row_failed_and_0_when_only_some(
    command, clean_scene: Path, tmp_path: Path, crashing, names, expected
):
    target, (code, ended) = tmp_path / "out.json", expected
    answer = command("compare", "--scene", clean_scene, *SMALL, "--strategies", names, "--json", target)
    assert answer.code == code
    assert "Traceback" not in answer.err
    assert all(status in answer.out for status in ended.values())
    trials = [(trial["strategy"], trial["status"]) for trial in json.loads(target.read_text())["trials"]]
    assert sorted(trials) == sorted([*ended.items()] * 2)


def test_a_scale_for_the_default_schedule_is_refused(command):
    command("compare", "--schedule=default", "--scale=0.5").refuses("--scale belongs to --schedule count; leave it out")
