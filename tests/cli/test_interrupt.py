"""SIGINT and SIGTERM: exit code 130, and what is finished is printed and saved."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

# The first trial ends at once, the second sleeps until the signal comes.
SLOW = """
import os, time
from dataclasses import dataclass
from pathlib import Path
from stereorecal.strategies import AbstractStrategy, Outcome, Status

@dataclass(frozen=True)
class Slow(AbstractStrategy):
    def run(self, objective, start, budget, seed):
        objective.value(start)
        if seed == 1:
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
    return os.environ | {"PYTHONPATH": str(site), "SLOW_STARTED": str(tmp_path / "started")}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_finished_is_kept(planted: dict[str, str], clean_scene: Path, tmp_path: Path, number: signal.Signals):
    words = ["compare", "--scene", str(clean_scene), "--scale", "0.5", "--draws", "3", "--strategies", "slow"]
    target = tmp_path / "out.json"
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words, "--json", str(target)],
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
    assert "slow" in out
    content = json.loads(target.read_text())
    assert content["interrupted"] is True
    assert [(trial["draw"], trial["status"]) for trial in content["trials"]] == [(0, "CONVERGED")]
    assert content["versions"]["strategy slow"] == "slow 1.0"
