"""Help, the version and mistyped options do not wait for JAX; and the help, written without it, says what there is."""

from pathlib import Path

import pytest
from parts_of_repairs import COMMANDS

from stereorecal.cli import options_of
from stereorecal.decision import LIMITS
from stereorecal.recalibration import SCHEDULES
from stereorecal.synthetic import KINDS

VERBS = [name for name in COMMANDS.names() if "." not in name]  # those of plug-ins, too


HELP = ["--version", "--help", *(f"{verb} --help" for verb in VERBS), "strategies check --help"]
MISTYPED = ["", "repair", "score --nonsense", "diff one", "compare --draws many"]
WRONG = [
    "recalibrate nowhere",
    "recalibrate --left nothing.png --right nothing.png --calibration nothing.yaml",
    "recalibrate . --output {there}",
    "recalibrate . --schedule count:compas",
    "score . --pairs few",
    "recalibrate . --matcher sagd",
    "monitor . --state /nowhere/state",
    "monitor . --state new --json new",
    "monitor nowhere",
    "compare --scene nowhere",
    "compare --strategies compass,compas",
    "compare --html {there}",
    "diff nothing.yaml {there}",
    "convert nothing.yaml new.yaml",
    "strategies check compas",
    "matchers check sagd",
]


def test_answers_at_once(at_once):
    for words, (answer, loaded) in zip(HELP + MISTYPED, at_once(*HELP, *MISTYPED), strict=True):
        helped = words in HELP
        assert (answer.code, loaded) == (0 if helped else 2, set()), (words, answer)
        assert ("stereorecal" in answer.out) == helped
        assert ("; see stereorecal" in answer.err) == (not helped)


def test_a_wrong_name_or_number_is_said_at_once(tmp_path: Path, at_once):
    (there := tmp_path / "there.json").touch()
    for words, (answer, loaded) in zip(WRONG, at_once(*(words.format(there=there) for words in WRONG)), strict=True):
        assert (answer.code, answer.err.count("\n")) == (2, 1), (words, answer)
        assert loaded <= {"numpy"}, words  # which the names of strategies cost


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("diff here", "the following arguments are required: B; see stereorecal diff --help"),
        ("strategies 7", "unknown action '7' (choose one of: list, check); see stereorecal strategies --help"),
        ("recalibrate --maps", "argument --maps: expected one argument; see stereorecal recalibrate --help"),
        ("compare --seed some", "argument --seed: invalid int value: 'some'; see stereorecal compare --help"),
        ("score scene --jsno out.json", "unrecognized arguments: --jsno out.json (did you mean --json?); see"),
        ("compare --drwas=3", "unrecognized arguments: --drwas=3 (did you mean --draws?); see"),
        ("monitor scene --until-sur", "unrecognized arguments: --until-sur (did you mean --until-sure?); see"),
        ("score scene --html out.html", "unrecognized arguments: --html out.html; see stereorecal score --help"),
        ("score scene --zzzz", "unrecognized arguments: --zzzz; see"),
        ("--verison score", "unrecognized arguments: --verison (did you mean --version?); see"),
        ("recalibrate sc --quite also", "unrecognized arguments: --quite also (did you mean --quiet?); see"),
        ("convert a b --format ros", "unrecognized arguments: --format ros (did you mean --from or --to?); see"),
        ("diff a b c --jsno", "unrecognized arguments: c --jsno (did you mean --json?); see"),
        ("scoer scene", "unknown command 'scoer' (did you mean score?); see stereorecal --help"),
        (
            "repair scene",
            "unknown command 'repair' (choose one of: recalibrate, score, monitor, diff, convert, compare,",
        ),
        ("strategies list compass", "unrecognized arguments: compass; see"),
        ("matchers check", "matchers check needs a name; matchers list shows those that are installed; see"),
        ("compare harbour", "unrecognized arguments: harbour; see"),
        ("diff a.yaml b.yaml c.yaml", "unrecognized arguments: c.yaml (the two files of a calibration are named"),
    ],
)
def test_an_option_that_is_written_wrongly(command, words: str, said: str):
    command(*words.split()).refuses(said)


def test_a_command_of_another_distribution(command, nothing_installed):
    install = "pip install stereorecal-paper (in a clone: pip install -e plugins/paper)"
    command("reproduce").refuses(f"reproduce is not installed; run: {install}")
    command("score", "scene", "--boards", "seen").refuses("--boards comes with: pip install stereorecal-boards (in")


def test_help_says_what_there_is(command):
    compare, recalibrate, score = (
        " ".join(command(verb, "--help").out.split()) for verb in ("compare", "recalibrate", "score")
    )
    assert f"render a scene: {', '.join(KINDS)}" in compare
    assert all(name in recalibrate for name in SCHEDULES)
    assert f"within {LIMITS['good_rows_px']} px with {100 * LIMITS['good_surely']:.0f} %" in score
    assert f"{100 * LIMITS['harm']:.0f} %" in recalibrate


def test_options_have_the_types_and_defaults_of_their_fields():
    words = "recalibrate here there --motion off --calibration a b --force --pairs 4: --tolerance 2.5"
    found = options_of(words.split())
    assert (found.scenes, found.motion) == (("here", "there"), "off")
    assert (found.calibration, found.force, found.tolerance) == (("a", "b"), True, 2.5)
    assert options_of(["compare", "--scene", "x", "--scene", "y"]).scene == ("x", "y")
    found = options_of(["recalibrate", "here"])
    assert (found.pairs, found.matcher, found.motion, found.force) == (None, "sad", "auto", False)
    assert (found.calibration, options_of(["compare"]).scene) == (None, ())


def test_a_command_that_cannot_be_loaded_costs_no_other(command, install):
    install("stereorecal.commands", {"broken": "nosuchmodule:Options"}, "broken-plug-in")
    assert command("--version").code == 0
    assert "broken" in command("--help").out
    assert command("broken").code == 3
