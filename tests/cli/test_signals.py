"""Ctrl-C, SIGTERM and SIGHUP from the first second on: one line and 130; one run in a folder of `reproduce`."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest
from machine import full_disk
from slow import terminal

from stereorecal import InputError, Log, Mission, _signals, recalibrate_many
from stereorecal.io import load_scene
from stereorecal.reproduction import Extent, reproduce

NUMBERS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


@pytest.mark.parametrize(
    ("module", "number"),
    [
        ("argparse", signal.SIGINT),
        ("numpy", signal.SIGTERM),
        ("jax._src.core", signal.SIGHUP),
        ("jax", signal.SIGINT),
    ],
)
def test_while_libraries_are_imported(clean_scene: Path, module: str, number: signal.Signals):
    """The signal comes as soon as that module is there."""
    run = terminal("-X", "importtime", "-m", "stereorecal", "score", clean_scene)
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        said = []
        for line in process.stderr:
            said.append(line)
            if line.startswith("import time:") and line.split("|")[-1].strip() == module:
                process.send_signal(number)
                break
        said += process.stderr.readlines()
        assert process.wait(60) == 130
    assert [line for line in said if not line.startswith("import time:")] == ["stereorecal: interrupted\n"]


def test_a_signal_that_is_ignored_stays_so():
    """Under nohup the end of the terminal is none of the run."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with _signals.interruptible(), _signals.held():
            os.kill(os.getpid(), signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("number", NUMBERS)
def test_results_are_saved_before_the_run_ends(number: signal.Signals):
    before, saved = signal.getsignal(number), []

    @_signals.interruptible()
    def save() -> None:
        signal.signal(number, _signals._interrupt)  # also where the suite runs in the background
        with _signals.held():
            signal.raise_signal(number)
            saved.append(1)

    with pytest.raises(KeyboardInterrupt):
        save()
    assert saved == [1]
    assert signal.getsignal(number) is before


def test_signals_that_come_together_are_one():
    """A terminal that is closed sends two; those after the first wait for what is finished to be saved."""
    saved = []

    @_signals.interruptible()
    def save() -> None:
        signal.signal(signal.SIGTERM, _signals._interrupt)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        with _signals.held():
            signal.raise_signal(signal.SIGTERM)
        saved.append(1)

    save()
    assert saved == [1]


def test_between_the_last_task_and_saving():
    saved = []

    @_signals.interruptible()
    def save() -> None:
        signal.signal(signal.SIGTERM, _signals._interrupt)
        _signals.hold()
        signal.raise_signal(signal.SIGTERM)
        with _signals.held():
            saved.append(1)
        pytest.fail("went on")

    with pytest.raises(KeyboardInterrupt):
        save()
    assert saved == [1]


@pytest.mark.parametrize("when", ["before", "while"])
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="has no such pipes")
def test_saving_has_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, when: str):
    """Nobody reads the pipe."""
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.setattr(_signals, "_SAVING_S", 0.1)

    @_signals.interruptible()
    def save() -> None:
        signal.signal(signal.SIGTERM, _signals._interrupt)
        if when == "before":
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
        else:
            _signals.hold()
            signal.raise_signal(signal.SIGTERM)
        with _signals.held():
            (tmp_path / "pipe").write_text("results")

    with pytest.raises(KeyboardInterrupt):
        save()


def test_a_second_signal_does_not_wait():
    @_signals.interruptible()
    @_signals.held()
    def save() -> None:
        signal.signal(signal.SIGTERM, _signals._interrupt)
        signal.raise_signal(signal.SIGTERM)
        time.sleep(1.1)  # those within a second are one
        signal.raise_signal(signal.SIGTERM)
        pytest.fail("went on")

    with pytest.raises(KeyboardInterrupt):
        save()


def test_a_swallowed_signal_comes_again():
    """An exception in a finaliser is printed and forgotten by Python."""

    class Swallows:
        def __del__(self):
            raise KeyboardInterrupt

    @_signals.interruptible()
    def swallow() -> None:
        thing = Swallows()
        del thing
        time.sleep(5)
        pytest.fail("went on")

    with pytest.raises(KeyboardInterrupt):
        swallow()


# --- one run in a folder ------------------------------------------------------------------------------------


LOCK = "import fcntl, sys; file = open(sys.argv[1], 'a'); fcntl.flock(file, 2); print('there', flush=True); input()"


@pytest.fixture
def run_in(clean_scene: Path):
    """run_in(folder): a reproduction of two tasks, whose results go there."""
    scene = load_scene(clean_scene)
    log = Log("log", {"2020-01-01": scene.rig}, (Mission("2020-01-02", "2020-01-01", scene.pairs),))

    def run(folder: Path):
        extent = Extent(sweeps=1, points=3, matchers=())
        return reproduce(log, ["validity"], schedules=("count",), extent=extent, output=folder)

    return run


def test_two_runs_in_one_folder(run_in, tmp_path: Path):
    """A killed one leaves no lock."""
    first = run_in(tmp_path / "out")
    (lock,) = (path for path in (tmp_path / "out").iterdir() if path.name.startswith("."))
    run = [sys.executable, "-c", LOCK, str(lock)]
    with subprocess.Popen(run, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "there\n"
        with pytest.raises(InputError, match="another run is working there"):
            run_in(tmp_path / "out")
        other.kill()
    assert run_in(tmp_path / "out").rows == first.rows


def test_what_a_killed_run_has_left_is_no_obstacle(run_in, tmp_path: Path):
    (tmp_path / ".settings.json.0123abcd.tmp").write_text("{")
    first = run_in(tmp_path)
    with open(tmp_path / "rows.jsonl", "a") as rows:
        rows.write('{"key": "l", "ro')
    assert run_in(tmp_path).rows == first.rows


def test_a_full_disk_stops_a_reproduction_in_a_sentence(run_in, tmp_path: Path):
    with full_disk(nth=2), pytest.raises(InputError, match=r"rows.jsonl: cannot be written \(No space left on device"):
        run_in(tmp_path)


# --- workers ------------------------------------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "fork"), reason="cannot fork")
@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning", "ignore:This process:DeprecationWarning")
def test_forked_workers_are_refused(clean_scene: Path):
    scene = load_scene(clean_scene)
    with (
        ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool,
        pytest.raises(InputError, match="forks its workers"),
    ):
        recalibrate_many([scene, replace(scene, name="another")], schedule="count", executor=pool)
