"""Help, the version and mistyped options do not wait for JAX; and the help, written without it, says what there is."""

from pathlib import Path

import pytest
from parts_of_repairs import COMMANDS

from stereorecal.cli import options_of
from stereorecal.recalibration import HEALTH_LIMITS, SCHEDULES
from stereorecal.synthetic import KINDS

VERBS = [name for name in COMMANDS.names() if "." not in name]  # those of plug-ins, too


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--version"], 0),
        (["--help"], 0),
        *(([verb, "--help"], 0) for verb in VERBS),
        (["strategies", "check", "--help"], 0),
        ([], 2),
        (["repair"], 2),
        (["score", "--nonsense"], 2),
        (["diff", "one"], 2),
        (["compare", "--draws", "many"], 2),
    ],
    ids=lambda value: " ".join(value) or "nothing" if isinstance(value, list) else str(value),
)
def test_answers_at_once(words: list[str], code: int, at_once):
    answer, loaded = at_once(*words)
    assert (answer.code, loaded) == (code, set()), answer
    assert ("stereorecal" in answer.out) == (code == 0)
    assert ("; see stereorecal" in answer.err) == (code == 2)


@pytest.mark.parametrize(
    "words",
    [
        "recalibrate nowhere",
        "recalibrate --left nothing.png --right nothing.png --calibration nothing.yaml",
        "recalibrate . --output {there}",
        "recalibrate . --strategy compas",
        "recalibrate . --reach 3",
        "score . --pairs few",
        "score nowhere",
        "score . --json {there}",
        "monitor nowhere",
        "compare --scene nowhere",
        "compare --strategies compass,compas",
        "compare --html {there}",
        "diff nothing.yaml {there}",
        "convert nothing.yaml new.yaml",
        "strategies check compas",
    ],
)
def test_a_wrong_name_or_number_is_said_at_once(words: str, tmp_path: Path, at_once):
    (there := tmp_path / "there.json").touch()
    answer, loaded = at_once(*words.format(there=there).split())
    assert (answer.code, answer.err.count("\n")) == (2, 1), answer
    assert loaded <= {"numpy"}  # which the names of strategies cost


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("diff here", "the following arguments are required: B; see stereorecal diff --help"),
        ("strategies 7", "unknown action '7' (choose one of: list, check); see stereorecal strategies --help"),
        ("recalibrate --maps", "argument --maps: expected one argument; see stereorecal recalibrate --help"),
        ("recalibrate --seed some", "argument --seed: invalid int value: 'some'; see stereorecal recalibrate --help"),
        ("score scene --jsno out.json", "unrecognized arguments: --jsno out.json (did you mean --json?); see"),
        (
            "recalibrate scene --in-palce",
            "unrecognized arguments: --in-palce (did you mean --in-place?); see",
        ),
        ("compare --drwas=3", "unrecognized arguments: --drwas=3 (did you mean --draws?); see"),
        ("score scene --zzzz", "unrecognized arguments: --zzzz; see"),
        ("--verison score", "unrecognized arguments: --verison (did you mean --version?); see"),
        ("recalibrate sc --quite also", "unrecognized arguments: --quite also (did you mean --quiet?); see"),
        ("diff a b c --jsno", "unrecognized arguments: c --jsno (did you mean --json?); see"),
        ("scoer scene", "unknown command 'scoer' (did you mean score?); see stereorecal --help"),
        (
            "repair scene",
            "unknown command 'repair' (choose one of: recalibrate, score, monitor, diff, convert, compare,",
        ),
        ("matchers chek sad", "unknown action 'chek' (did you mean check?); see stereorecal matchers --help"),
        ("matchers check", "matchers check needs a name; matchers list shows those that are installed; see"),
        ("strategies list compass", "unrecognized arguments: compass; see"),
        ("compare harbour", "unrecognized arguments: harbour; see"),
        ("diff a.yaml b.yaml c.yaml", "unrecognized arguments: c.yaml (the two files of a calibration are named"),
    ],
)
def test_an_option_that_is_written_wrongly(words: str, said: str, capsys):
    with pytest.raises(SystemExit) as end:
        options_of(words.split())
    assert end.value.code == 2
    line = capsys.readouterr().err
    assert said in line
    assert line.startswith("stereorecal: ")
    assert line.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "what", "distribution"),
    [("compare --judge walk", "--judge", "field"), ("compare --preset=field", "--preset", "field")],
)
def test_what_comes_with_another_distribution(words: str, what: str, distribution: str, capsys, nothing_installed):
    with pytest.raises(SystemExit):
        options_of(words.split())
    said = capsys.readouterr().err
    assert what in said
    assert f"pip install stereorecal-{distribution} (in" in said


def help_of(verb: str, capsys) -> str:
    with pytest.raises(SystemExit):
        options_of([verb, "--help"])
    return " ".join(capsys.readouterr().out.split())


def test_help_says_what_there_is(capsys):
    assert f"render a scene: {', '.join(KINDS)}" in help_of("compare", capsys)
    assert all(name in help_of("recalibrate", capsys) for name in SCHEDULES)
    text = help_of("score", capsys)
    limits = HEALTH_LIMITS
    assert f"within {limits['good_rows_px']} px with {100 * limits['good_surely']:.0f} %" in text
    assert f"{100 * limits['harm']:.0f} %" in help_of("recalibrate", capsys)


def test_a_command_that_is_not_installed_says_the_install_line(nothing_installed, capsys):
    with pytest.raises(SystemExit) as end:
        options_of(["reproduce"])
    assert end.value.code == 2
    said = "reproduce is not installed; run: pip install stereorecal-paper (in a clone: pip install -e plugins/paper)"
    assert said in capsys.readouterr().err


def test_a_command_that_cannot_be_loaded_costs_no_other(command, install, capsys):
    install("stereorecal.commands", {"broken": "nosuchmodule:Options"}, "broken-plug-in")
    assert command("--version").code == 0
    assert "broken" in command("--help").out
    assert command("broken").code == 3
