"""Ctrl-C, SIGTERM and SIGHUP from the first second on: one line and 130."""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import pytest
from parts_of_repairs import _signals
from slow import terminal

from stereorecal import InputError, recalibrate_many
from stereorecal.io import load_scene


@pytest.mark.parametrize(
    ("module", "name"), [("argparse", "SIGINT"), ("numpy", "SIGTERM"), ("jax._src.core", "SIGHUP")]
)
def test_while_libraries_are_imported(clean_scene: Path, module: str, name: str):
    """The signal comes as soon as that module is there."""
    run = terminal("-X", "importtime", "-m", "stereorecal", "score", clean_scene)
    with subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        said = []
        for line in process.stderr:
            said.append(line)
            if line.startswith("import time:") and line.split("|")[-1].strip() == module:
                process.send_signal(getattr(signal, name))
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


@pytest.fixture
def ended_by() -> Iterator[Callable[[Callable[[], None]], bool]]:
    """ended_by(work): whether a signal has ended it; SIGTERM does, also where the suite runs in the background."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)

    def run(work: Callable[[], None]) -> bool:
        try:
            with _signals.interruptible():
                work()
        except KeyboardInterrupt:
            return _signals.interrupted()
        return False

    yield run
    assert signal.signal(signal.SIGTERM, before) is signal.default_int_handler


def terminate() -> None:
    signal.raise_signal(signal.SIGTERM)


@pytest.mark.parametrize("when", ["before", "while"])
def test_a_signal_waits_until_results_are_saved(ended_by, when: str):
    """And those that come together, as when a terminal is closed, are one."""
    saved = []

    def save() -> None:
        _signals.hold()
        if when == "before":
            terminate()
        with _signals.held():
            for _ in range(3):
                terminate()
            saved.append(when)
        pytest.fail("went on")

    assert ended_by(save)
    assert saved == [when]


def test_the_first_of_several_signals_leaves_time_to_save(ended_by):
    def save() -> None:
        with pytest.raises(KeyboardInterrupt):
            terminate()
        with _signals.held():
            terminate()

    assert not ended_by(save)


def test_a_second_signal_does_not_wait(ended_by, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(_signals, "_TOGETHER_S", -1.0)

    def save() -> None:
        with _signals.held():
            terminate()
            terminate()
            pytest.fail("went on")

    assert ended_by(save)


def test_a_swallowed_signal_comes_again(ended_by):
    """An exception in a finaliser is printed and forgotten by Python."""

    class Swallows:
        def __del__(self):
            terminate()

    def swallow() -> None:
        Swallows()
        time.sleep(5)
        pytest.fail("went on")

    assert ended_by(swallow)


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
