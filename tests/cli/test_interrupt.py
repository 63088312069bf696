"""SIGINT and SIGTERM: exit code 130, and what is finished is printed and saved."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

# The first runs end at once, as many as SLOW_RUNS says; the next sleeps until the signal comes.
SLOW = """
import os, time
from dataclasses import dataclass
from pathlib import Path
from stereorecal.strategies import AbstractStrategy, Outcome, Status

runs = []

@dataclass(frozen=True)
class Slow(AbstractStrategy):
    def run(self, objective, start, seed):
        objective.value(start)
        runs.append(seed)
        if len(runs) > int(os.environ["SLOW_RUNS"]):
            Path(os.environ["SLOW_STARTED"]).touch()
            time.sleep(600)
        return Outcome(start, Status.CONVERGED)
"""

# A shell that runs the suite in the background has its children ignore SIGINT; the program under test must not.
PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from stereorecal.cli import main
sys.exit(main())
"""


@pytest.fixture
def planted(tmp_path: Path) -> dict[str, str]:
    """An environment in which a strategy "slow" is installed."""
    site = tmp_path / "site"
    info = site / "slow-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "slow_strategy.py").write_text(SLOW)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: slow\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[stereorecal.strategies]\nslow = slow_strategy:Slow\n")
    return os.environ | {"PYTHONPATH": str(site), "SLOW_STARTED": str(tmp_path / "started"), "SLOW_RUNS": "1"}


def interrupted(planted: dict[str, str], number: signal.Signals, *words: object) -> tuple[str, str]:
    """stdout and stderr of a command that is sent a signal as soon as it sleeps, and ends with 130."""
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *map(str, words)],
        env=planted,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while not Path(planted["SLOW_STARTED"]).exists():
            assert process.poll() is None, process.communicate()[1]
            time.sleep(0.05)
        process.send_signal(number)
        out, err = process.communicate(timeout=120)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "interrupted" in err
    return out, err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_finished_is_kept(planted: dict[str, str], clean_scene: Path, tmp_path: Path, number: signal.Signals):
    words = ["compare", "--scene", clean_scene, "--scale", "0.5", "--draws", "3", "--strategies", "slow"]
    target = tmp_path / "out.json"
    out, _ = interrupted(planted, number, *words, "--json", target)
    assert "slow" in out
    content = json.loads(target.read_text())
    assert content["interrupted"] is True
    assert [(trial["draw"], trial["status"]) for trial in content["trials"]] == [(0, "CONVERGED")]
    assert content["versions"]["strategy slow"] == "slow 1.0"


SLOWLY = ("--schedule", "count", "--scale", "0.5", "--strategy", "slow")


def test_recordings_that_are_finished_are_kept(
    planted: dict[str, str], clean_scene: Path, drifted_scene: Path, tmp_path: Path
):
    target = tmp_path / "out.json"
    out, err = interrupted(
        planted, signal.SIGTERM, "recalibrate", drifted_scene, clean_scene, *SLOWLY, "--json", target
    )
    assert "not improved" in out
    assert "failed (interrupted)" in out
    assert err.count("\n") == 1
    assert "clean: interrupted before it was finished" in err
    content = json.loads(target.read_text())
    assert content["interrupted"] is True
    assert [repair["fault"] for repair in content["repairs"]] == [None, "interrupted"]
    assert content["repairs"][0]["score_after"]["count"] > 0


def test_nothing_is_written_when_nothing_is_finished(planted: dict[str, str], drifted_scene: Path, tmp_path: Path):
    before = {**planted, "SLOW_RUNS": "0"}
    places = ("--json", tmp_path / "out.json", "--output", tmp_path / "repaired.json")
    out, _ = interrupted(before, signal.SIGINT, "recalibrate", drifted_scene, *SLOWLY, *places)
    assert out == ""
    assert not any(path.exists() for path in places[1::2])


@pytest.mark.parametrize("executor", ["serial", "threads:1", "processes:1"])
def test_ctrl_c_inside_a_worker(planted: dict[str, str], clean_scene: Path, tmp_path: Path, executor: str):
    """The second recording's worker is interrupted: the first is printed and saved."""
    strategy = Path(planted["PYTHONPATH"]) / "slow_strategy.py"
    strategy.write_text(strategy.read_text().replace("time.sleep(600)", "raise KeyboardInterrupt"))
    target, again = tmp_path / "out.json", shutil.copytree(clean_scene, tmp_path / "again")
    words = ["recalibrate", clean_scene, again, *SLOWLY, "--executor", executor, "--json", target]
    run = [sys.executable, "-c", PROGRAM, *map(str, words)]
    ended = subprocess.run(run, env=planted, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 130, ended.stderr
    assert "Traceback" not in ended.stderr
    assert "internal error" not in ended.stderr
    assert "again: interrupted before it was finished" in ended.stderr
    assert "not improved" in ended.stdout
    faults = [repair["fault"] for repair in json.loads(target.read_text())["repairs"]]
    assert faults == [None, "interrupted"]
