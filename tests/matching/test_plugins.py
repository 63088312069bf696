"""Matchers as plug-ins: through the door of strategies, with the core's own behind it too."""

import sys
import tomllib
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from parts_of_repairs import Plugin

import stereorecal as sr
from stereorecal.matching import (
    AbstractMatcher,
    Disparity,
    as_matcher,
    name_of,
    origin_of,
    overview,
)
from stereorecal.strategies import strategies

GROUP = "stereorecal.matchers"
OWN = {"bm": "stereorecal.matching:BM", "sad": "stereorecal.matching:SAD", "sgbm": "stereorecal.matching:SGBM"}


@dataclass(frozen=True)
class Nothing(AbstractMatcher):
    """Finds nothing.

    At all.
    """

    patience: float = 1.0

    def search(self, left, right):
        return Disparity(np.zeros(left.shape, np.float32), np.zeros(left.shape, bool))


@dataclass(frozen=True)
class Traced(Nothing):
    traceable = True


@pytest.fixture
def installed(nothing_installed, install, monkeypatch):
    """installed(names and values): matchers of the distribution plug-in, and no other."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[Nothing.__module__])
    return partial(install, GROUP)


def test_ours_come_through_the_door_as_declared():
    """And are there with older metadata, too, as the next test has it."""
    declared = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    assert declared["project"]["entry-points"] == {GROUP: OWN}


@pytest.mark.parametrize("metadata", [(), ("sad",), ("sad", "bm", "sgbm")], ids=len)
def test_ours_are_there_whatever_the_metadata_says(installed, metadata):
    installed({name: OWN[name] for name in metadata}, "stereorecal")
    assert sr.matchers() == ("bm", "sad", "sgbm")
    assert sr.matcher("sgbm", num_disparities=32) == sr.SGBM(num_disparities=32)
    found = overview()
    assert all(isinstance(info, Plugin) and info.distribution == "stereorecal" for info in found.values())
    assert [name_of(one) for one in (sr.SAD(), sr.BM(), sr.SGBM())] == ["sad", "bm", "sgbm"]
    assert origin_of(sr.BM()).startswith("stereorecal ")


def test_a_plugin_is_one_of_them(installed):
    installed({"nothing": f"{__name__}:Nothing", "traced": f"{__name__}:Traced"})
    assert sr.matchers() == ("bm", "nothing", "sad", "sgbm", "traced")
    made = sr.matcher("nothing", patience=2.0, num_disparities=16)
    assert made == Nothing(patience=2.0, num_disparities=16)
    assert name_of(made) == "nothing"
    assert origin_of(made) == "plug-in 1.2"
    assert as_matcher("nothing") == Nothing()
    found = overview()
    assert found["nothing"] == Plugin("nothing", "plug-in", "1.2", Nothing)
    assert found["nothing"].summary == "Finds nothing."
    assert [found[name].cls for name in ("sad", "traced")] == [sr.SAD, Traced]
    assert "nothing" not in strategies()


def test_a_name_of_ours_that_somebody_else_claims(installed):
    installed({"sad": f"{__name__}:Nothing"})
    with pytest.raises(sr.InputError, match="matcher sad is claimed by plug-in and stereorecal; uninstall all but one"):
        sr.matcher("sad")
