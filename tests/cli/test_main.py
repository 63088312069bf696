"""What all commands share: --version, --traceback, and one sentence for every error."""

import json
import re
import warnings
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest
from machine import at_call, raising
from parts_of_repairs import COMMANDS

from stereorecal import InputError


def test_version(command):
    answer = command("--version")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == f"stereorecal {version('stereorecal')}\n"


@pytest.fixture
def broken() -> Iterator[None]:
    """What is a bug wherever it comes from: an error that nobody expects of the machine."""
    with at_call("fsync", raising(KeyError("a bug"))):
        yield


def test_traceback_of_a_bug(command, broken, clean_scene: Path, tmp_path: Path):
    words = ("diff", clean_scene, clean_scene, "--json", tmp_path / "diff.json")
    short = command(*words)
    assert (short.code, short.err.count("\n")) == (3, 1)
    assert "--traceback" in short.err
    answer = command(*words, "--traceback")
    assert answer.code == 3
    assert answer.err.startswith("Traceback (most recent call last):\n")
    assert "in fail" in answer.err
    assert answer.err.splitlines()[-1].startswith("stereorecal: internal error (KeyError('a bug'))")


@pytest.mark.parametrize(
    "words", [("--traceback", "score", "{}"), ("score", "{}", "--traceback"), ("score", "--traceback", "{}")]
)
def test_traceback_of_bad_input(command, tmp_path: Path, words: tuple[str, ...]):
    """The option may stand anywhere; where nothing is wrong it changes nothing."""
    answer = command(*(word.format(tmp_path / "nowhere") for word in words))
    assert answer.code == 2
    assert answer.err.startswith("Traceback (most recent call last):\n")
    assert f"{InputError.__name__}: " in answer.err
    assert answer.err.splitlines()[-1].endswith("there is no such folder; check the path.")
    assert command("strategies", "list", "--traceback").code == 0


@pytest.fixture
def millimetres(folder: Path) -> Path:
    """The scene with a translation that was never converted."""
    path = folder / "calib.json"
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "T": [1000.0 * value for value in content["T"]]}))
    return folder


def test_units_that_look_wrong_are_one_line(command, clean_scene: Path, millimetres: Path):
    """On stderr; the work goes on, and its exit code is its own."""
    answer = command("score", millimetres, "--json", "-")
    assert answer.code == 0
    assert answer.err == (
        f"stereorecal: {millimetres}: the baseline is 356 m long; check that the translation is in metres, or give its "
        "unit (--unit).\n"
    )
    assert json.loads(answer.out)["scenes"][0]["condition"] == "healthy"  # rows know no unit
    for words in ((clean_scene, millimetres), (millimetres, clean_scene)):
        answer = command("diff", *words)
        assert answer.code == 0
        assert answer.err.count("\n") == answer.err.count("the baseline is 356 m long") == 1
    assert "length 1 000 times as long" in command("diff", clean_scene, millimetres).out
    assert command("diff", clean_scene, clean_scene).err == ""


def test_other_warnings_stay_pythons(command, clean_scene: Path, moody_matcher):
    moody_matcher(lambda search: warnings.warn("something else", UserWarning, stacklevel=1))
    with pytest.warns(UserWarning, match="something else"):
        answer = command("score", clean_scene, "--matcher", "moody", "--quiet")
    assert (answer.out, answer.err) == ("", "")


VERBS = [name for name in COMMANDS.names() if "." not in name]  # those of plug-ins, too


@pytest.mark.parametrize("verb", VERBS)
def test_help_fits_80_columns_and_names_defaults(verb: str, command, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = command(verb, "--help").out
    assert max(map(len, text.splitlines())) <= 80
    options = re.split(r"\n  (?=-)", text)
    for option in options:
        taken = re.match(
            r"(--(?:matcher|schedule|scale|reach|free|extrinsics|budget|seed|executor|every|frames)) ", option
        )
        if taken:
            assert "default" in option, option


def test_help_begins_with_what_is_typed(command, monkeypatch: pytest.MonkeyPatch):
    """Not with all options; these stand under headings, in the order of their use."""
    monkeypatch.setenv("COLUMNS", "80")
    usage, _, *sections = command("recalibrate", "--help").out.split("\n\n")
    assert usage.splitlines() == [
        "usage: stereorecal recalibrate [options] SCENE [SCENE …]",
        "       stereorecal recalibrate [options] --left L --right R --calibration FILE",
    ]
    firsts = re.findall(r"^(\S.*):\n  (\S+)", "\n".join(sections[:-1]), re.MULTILINE)
    assert firsts == [
        ("what to write", "--output"),
        ("what to read", "SCENE"),
        ("which pairs", "--pairs"),
        ("the rig, and what may move", "--free"),
        ("depth, from motion and ranges", "--ranges"),
        ("the decision", "--tolerances"),
        ("matching and search", "--schedule"),
        ("running", "-h,"),
    ]
    assert sections[-1].startswith("Exit code: 0 ")


def test_help_tells_defaults_once(command, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "300")
    text = command("recalibrate", "--help").out
    assert "every fifth (default: all)" in text  # which its text says
    assert "installed stereo matcher: sad, bm, sgbm, or a plug-in's (default: sad)" in text
    assert not re.search(r"default: [^\n]*\(default: (?!recognised)", text)
