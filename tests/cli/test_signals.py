"""Ctrl-C, SIGTERM and SIGHUP from the first second on: one line and 130."""

import os
import signal
import subprocess
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest
from slow import terminal

from stereorecal import InputError, _signals, recalibrate_many
from stereorecal.io import load_scene

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
