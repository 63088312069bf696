"""Options as they are declared, and what the command line makes of them."""

import re

import pytest

from stereorecal.cli import options_of


def options(words: str):
    return options_of(words.split())


def test_what_is_not_given_has_the_default_of_its_field():
    found = options("recalibrate here")
    assert (found.scenes, found.pairs, found.matcher, found.motion) == (("here",), None, "sad", "auto")
    assert (found.calibration, found.tolerance) == (None, None)
    assert (found.in_place, found.traceback) == (False, False)
    assert options("compare").scene == ()


def test_values_have_the_types_of_their_fields():
    words = "recalibrate here there --seed 2 --motion off --maps m.npz --calibration a b --in-place --pairs 4:"
    found = options(f"{words} --tolerance 2.5 --traceback")
    assert (found.scenes, found.seed, found.motion) == (("here", "there"), 2, "off")
    assert (found.maps, found.calibration) == ("m.npz", ("a", "b"))
    assert (found.in_place, found.pairs, found.tolerance, found.traceback) == (True, "4:", 2.5, True)
    assert options("compare --scene x --scene y").scene == ("x", "y")


def test_help_tells_defaults_once_and_shared_options_under_their_title(command, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "300")
    text, _, titled = command("recalibrate", "--help").out.partition("which pairs:")
    assert "same seed, same result (default: 0)" in titled
    assert "every fifth (default: all)" in titled  # which its text says
    assert "installed stereo matcher: sad, bm, sgbm, or a plug-in's (default: sad)" in titled
    assert not re.search(r"default: [^\n]*\(default: (?!recognised)", text + titled)
    assert "--calibration FILE …  " in text
    assert text.index("--in-place") < text.index("SCENE  ") < text.index("--left FILES")
    assert titled.index("--matcher NAME") < titled.index("--traceback  ") < titled.index("Exit code: 0 ")
