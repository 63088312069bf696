"""Commands that are interrupted: a strategy that sleeps once it has run; and processes that meet signals as those of a
terminal do."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# The first run ends at once; the next sleeps.
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
        if len(runs) > 1:
            Path(os.environ["SLOW_STARTED"]).touch()
            time.sleep(600)
        return Outcome(start, Status.CONVERGED)
"""

# A shell that runs the suite in the background, or nohup, has its children ignore signals; the program under test must
# not, whoever started the suite.
AS_IN_A_TERMINAL = """
import os, signal, sys
for name in ("SIGINT", "SIGTERM", "SIGHUP"):
    if hasattr(signal, name):
        signal.signal(getattr(signal, name), signal.SIG_DFL)
os.execv(sys.executable, [sys.executable, *sys.argv[1:]])
"""


def plant(site: Path) -> dict[str, str]:
    """Install the strategy "slow" in a folder; the environment in which it is found."""
    info = site / "slow-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "slow_strategy.py").write_text(SLOW)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: slow\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[stereorecal.strategies]\nslow = slow_strategy:Slow\n")
    path = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {"PYTHONPATH": path, "SLOW_STARTED": str(site / "started")}


def terminal(*words: object) -> list[str]:
    """The words that start Python as a terminal would."""
    return [sys.executable, "-c", AS_IN_A_TERMINAL, *map(str, words)]


@contextmanager
def sleeping(planted: dict[str, str], *words: object) -> Iterator[subprocess.Popen[str]]:
    """A command that runs until its strategy sleeps, in a process group of its own; killed afterwards."""
    run, env = terminal("-m", "stereorecal", *words), os.environ | planted
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(run, env=env, text=True, start_new_session=True, **pipes) as process:
        try:
            while not Path(planted["SLOW_STARTED"]).exists():
                assert process.poll() is None, process.communicate()[1]
                time.sleep(0.05)
            yield process
        finally:
            process.kill()
