"""`matchers` and `strategies` list what is installed, and check one; `--matcher` takes what is installed."""

import sys
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from stereorecal.matching import BM, AbstractMatcher, Disparity


@dataclass(frozen=True)
class Mine(BM):
    """BM under another name."""


@dataclass(frozen=True)
class Blind(AbstractMatcher):
    """Finds nothing."""

    def search(self, left, right):
        return Disparity(np.zeros(left.shape, np.float32), np.zeros(left.shape, bool))


@dataclass(frozen=True)
class Rough(Blind):
    """Pure, and has no soft match."""

    traceable = True


@dataclass(frozen=True)
class Crashing(AbstractMatcher):
    """Has a bug."""

    def search(self, left, right):
        raise KeyError("a bug")


@pytest.fixture
def plugins(install, monkeypatch: pytest.MonkeyPatch) -> None:
    """Matchers of somebody else's, beside all strategies that are installed."""
    names = {"mine": "Mine", "blind": "Blind", "rough": "Rough", "crashing": "Crashing", "shaky": "Missing"}
    install("stereorecal.matchers", {name: f"{__name__}:{cls}" for name, cls in names.items()})
    monkeypatch.setitem(sys.modules, __name__, sys.modules[Mine.__module__])


def test_list(command, plugins):
    answer = command("matchers")
    assert (answer.code, answer.err) == (3, "")  # shaky cannot be loaded
    lines = {line.split()[0]: line for line in answer.out.splitlines() if line.strip()}
    assert "stereorecal" in lines["sad"]
    assert "in JAX, smooth" in lines["sad"]
    assert "in JAX " in lines["rough"]
    assert "on the host" in lines["mine"]
    assert "BM under another name." in lines["mine"]
    assert "cannot be loaded" in answer.out


def test_lists_of_ours_alone(command):
    answer = command("matchers", "list")
    assert (answer.code, answer.err) == (0, "")
    assert "block matching" in answer.out
    answer = command("strategies")
    assert (answer.code, answer.err) == (0, "")
    (line,) = [line for line in answer.out.splitlines() if line.split()[:1] == ["compass"]]
    for word in ("stereorecal-compass", version("stereorecal-compass"), "host", "Compass (pattern) search"):
        assert word in line


@pytest.mark.parametrize(
    ("kind", "installed", "good", "bad", "fails"),
    [
        ("matchers", "plugins", "mine", "blind", "FAIL  finds known shifts: "),
        ("strategies", "moody", "compass", "moody", "FAIL  climbs a smooth bowl: "),
    ],
)
def test_check(command, request, kind: str, installed: str, good: str, bad: str, fails: str):
    request.getfixturevalue(installed)
    answer = command(kind, "check", good)
    assert answer.code == 0
    assert all(line.startswith("pass  ") for line in answer.out.splitlines())
    assert len(answer.out.splitlines()) >= 8
    answer = command(kind, "check", bad)
    assert answer.code == 1
    assert fails in answer.out
    assert "pass  travels" in answer.out or kind == "matchers"
    command(kind, "check", good[:-1]).refuses(f"; did you mean {good}?")


@pytest.mark.parametrize("verb", ["compare --scene", "score", "recalibrate", "monitor"])
def test_a_broken_one_is_a_sentence_wherever_it_is_named(command, plugins, clean_scene: Path, verb: str):
    answer = command(*verb.split(), clean_scene, "--matcher", "shaky")
    assert (answer.code, answer.out) == (3, "")
    assert "matcher shaky of plug-in 1.2 cannot be loaded" in answer.err
    assert answer.err.count("\n") == 1


def test_a_watch_keeps_its_matcher(command, plugins, clean_scene: Path, tmp_path: Path, monkeypatch):
    state = tmp_path / "state"
    watch = ("monitor", clean_scene, "--once", "--quiet", "--state", state)
    first = command(*watch, "--matcher", "mine")
    assert first.err == ""
    assert command(*watch) == first  # one pair tells neither more nor less than one
    monkeypatch.undo()
    command(*watch).refuses("state: unknown matcher 'mine'; installed: ")
