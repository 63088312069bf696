"""What all commands share: --version, --traceback, and one sentence for every error."""

from importlib.metadata import version
from pathlib import Path

import pytest

from stereorecal._errors import InputError
from stereorecal.cli import _score


def test_version(command):
    answer = command("--version")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == f"stereorecal {version('stereorecal')}\n"


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch) -> None:
    """`score` with a bug."""

    def bug(options):
        raise KeyError("a bug")

    monkeypatch.setattr(_score, "as_matcher", bug)


PLACES = pytest.mark.parametrize(
    "words", [("--traceback", "score", "{}"), ("score", "{}", "--traceback"), ("score", "--traceback", "{}")]
)


@PLACES
def test_traceback_of_a_bug(command, broken, clean_scene: Path, words: tuple[str, ...]):
    answer = command(*(word.format(clean_scene) for word in words))
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.startswith("Traceback (most recent call last):\n")
    assert "in bug" in answer.err
    assert answer.err.splitlines()[-1].startswith("stereorecal: internal error (KeyError('a bug'))")


def test_without_it_one_sentence_names_it(command, broken, clean_scene: Path):
    answer = command("score", clean_scene)
    assert (answer.code, answer.out) == (3, "")
    assert answer.err.count("\n") == 1
    assert "--traceback" in answer.err
    assert "Traceback" not in answer.err


@PLACES
def test_traceback_of_bad_input(command, tmp_path: Path, words: tuple[str, ...]):
    answer = command(*(word.format(tmp_path / "nowhere") for word in words))
    assert answer.code == 2
    assert answer.err.startswith("Traceback (most recent call last):\n")
    assert f"{InputError.__name__}: " in answer.err
    assert answer.err.splitlines()[-1].endswith("there is no such folder; check the path.")


@pytest.mark.parametrize("words", [("strategies", "--traceback"), ("strategies", "list", "--traceback")])
def test_every_command_takes_it(command, words: tuple[str, ...]):
    assert command(*words).code == 0
    for verb in ("compare", "recalibrate", "reproduce", "score", "strategies"):
        assert "--traceback" in command(verb, "--help").out


def test_traceback_of_a_strategy_that_is_checked(command):
    answer = command("strategies", "check", "compas", "--traceback")
    assert answer.code == 2
    assert "Traceback" in answer.err
    assert answer.err.splitlines()[-1] == "stereorecal: unknown strategy 'compas'; did you mean compass?"
