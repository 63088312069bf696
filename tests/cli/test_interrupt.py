"""Signals while it works: exit code 130, and what is finished is printed and saved; kill -9: it is on the disk."""

import json
import os
import signal
import time
from pathlib import Path

import pytest
from machine import raising
from slow import plant, sleeping

SLOWLY = ("--schedule", "count:slow")


@pytest.fixture
def planted(tmp_path: Path) -> dict[str, str]:
    return plant(tmp_path / "site")


def test_a_comparison_keeps_what_is_finished(planted: dict[str, str], clean_scene: Path, tmp_path: Path):
    """On the disk before the signal already, so that kill -9 would leave it; and printed after it."""
    target, page = tmp_path / "out.json", tmp_path / "out.html"
    words = ["compare", "--scene", clean_scene, "--scale", "0.5", "--draws", "3", "--strategies", "slow"]
    with sleeping(planted, *words, "--json", target, "--html", page) as process:
        before = json.loads(target.read_text())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert "slow" in out
    for content in (before, json.loads(target.read_text())):
        assert content["interrupted"] is True
        assert [(trial["draw"], trial["status"]) for trial in content["trials"]] == [(0, "CONVERGED")]
        assert content["versions"]["strategy slow"] == "slow 1.0"
    assert "1 trial was finished of 3." in page.read_text(encoding="utf-8")


def test_recordings_that_are_finished_are_kept(
    planted: dict[str, str], clean_scene: Path, drifted_scene: Path, tmp_path: Path
):
    """Also when several signals come at once."""
    target = tmp_path / "out.json"
    with sleeping(planted, "recalibrate", drifted_scene, clean_scene, *SLOWLY, "--json", target) as process:
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGTERM):
            process.send_signal(number)
            time.sleep(0.01)
        out, err = process.communicate(timeout=120)
    assert (process.returncode, err.count("\n")) == (130, 1), err
    assert "not improved" in out
    assert "failed (interrupted)" in out
    assert "clean: interrupted before it was finished" in err
    content = json.loads(target.read_text())
    assert content["interrupted"] is True
    assert [repair["fault"] for repair in content["repairs"]] == [None, "interrupted"]
    assert content["repairs"][0]["score_after"]["count"] > 0


def test_worker_processes_leave_nothing_to_complain_of(planted: dict[str, str], clean_scene: Path):
    """As a terminal and `timeout` send signals: to the whole group."""
    words = ["compare", "--scene", clean_scene, "--scale", "0.5", "--draws", "8", "--strategies", "slow"]
    with sleeping(planted, *words, "--executor", "processes:1") as process:
        os.killpg(process.pid, signal.SIGTERM)
        _, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert err.count("\n") == 1


def test_nothing_is_written_when_nothing_is_finished(command, moody, drifted_scene: Path, tmp_path: Path):
    moody(raising(KeyboardInterrupt))
    places = ("--json", tmp_path / "out.json", "--output", tmp_path / "repaired.json")
    answer = command("recalibrate", drifted_scene, "--schedule", "count:moody", *places)
    assert (answer.code, answer.out, "interrupted" in answer.err) == (130, "", True)
    assert not any(path.exists() for path in places[1::2])
