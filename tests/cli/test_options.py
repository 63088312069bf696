"""Options as they are declared, and what the command line makes of them."""

import re

import pytest

from stereorecal.cli import options_of


def options(words: str):
    return options_of(words.split())


def test_what_is_not_given_has_the_default_of_its_field():
    found = options("recalibrate here")
    assert (found.scenes, found.first, found.every, found.matcher, found.motion) == (("here",), 0, 1, "sad", "auto")
    assert (found.boards, found.calibration, found.tolerance, found.stop) == (None, None, None, None)
    assert (found.in_place, found.traceback) == (False, False)
    assert options("compare").judge == ()
    assert options("reproduce").experiments == ("all",)


def test_values_have_the_types_of_their_fields():
    words = "recalibrate here there --every 2 --motion off --boards l r --calibration a b --in-place --from 4"
    found = options(f"{words} --tolerance 2.5 --traceback")
    assert (found.scenes, found.every, found.motion) == (("here", "there"), 2, "off")
    assert (found.boards, found.calibration) == (("l", "r"), ("a", "b"))
    assert (found.in_place, found.first, found.tolerance, found.traceback) == (True, 4, 2.5, True)
    assert options("compare --judge x --judge y").judge == ("x", "y")


def test_help_tells_defaults_once_and_shared_options_under_their_title(command, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "300")
    text, _, titled = command("recalibrate", "--help").out.partition("which pairs:")
    assert "number of the first pair (default: 0)" in titled
    assert "number of the pair to stop before (default: none)" in titled  # which its text says
    assert "image scale of --schedule count (default: 1)" in titled
    assert "installed stereo matcher: sad, bm, sgbm, or a plug-in's (default: sad)" in titled
    assert not re.search(r"default: [^\n]*\(default: (?!recognised)", text + titled)
    assert "--calibration FILE …  " in text
    assert text.index("--in-place") < text.index("SCENE  ") < text.index("--left FILES")
    assert titled.index("--matcher NAME") < titled.index("--traceback  ") < titled.index("Exit code: 0 ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("diff here", "the following arguments are required: B"),
        ("strategies chekc", "unknown action 'chekc' (did you mean check?)"),
        ("strategies 7", "unknown action '7' (choose one of: list, check)"),
        ("recalibrate --boards l", "argument --boards: expected 2 arguments"),
        ("recalibrate --every some", "argument --every: invalid int value: 'some'"),
        ("recalibrate --evrey 2", "unrecognized arguments: --evrey (did you mean --every?)"),
    ],
)
def test_one_sentence_says_what_is_wrong(words: str, said: str, capsys):
    with pytest.raises(SystemExit) as end:
        options(words)
    assert end.value.code == 2
    assert capsys.readouterr().err == f"stereorecal: {said}; see stereorecal {words.split()[0]} --help\n"
