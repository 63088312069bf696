"""Strategies by name: found lazily, refused with a sentence that helps."""

import subprocess
import sys
from importlib.metadata import EntryPoint, EntryPoints

import pytest

from stereorecal._errors import InputError, StrategyError
from stereorecal.strategies import _registry, describe, origin_of, strategies, strategy
from stereorecal.strategies._registry import GROUP


class Distribution:
    """As much of a distribution as an entry point shows."""

    def __init__(self, name: str, version: str = "1.2") -> None:
        self.name, self.version = name, version


def point(name: str, value: str = "stereorecal_compass:Compass", distribution: str = "stereorecal-compass"):
    made = EntryPoint(name, value, GROUP)
    vars(made)["dist"] = Distribution(distribution)
    return made


@pytest.fixture
def installed(monkeypatch):
    """installed(points...): what is installed from now on."""

    def install(*points: EntryPoint) -> None:
        monkeypatch.setattr(_registry, "entry_points", lambda **wanted: EntryPoints(points).select(**wanted))

    return install


def test_what_is_installed():
    assert "compass" in strategies()
    made = strategy("compass", step=0.25)
    assert type(made).__name__ == "Compass"
    assert made.step == 0.25
    info = describe("compass")
    assert info.distribution == "stereorecal-compass"
    assert info.needs == "host"
    assert info.summary.startswith("Compass (pattern) search")
    assert origin_of(made) == f"{info.distribution} {info.version}"


def test_unknown_name_with_a_suggestion():
    with pytest.raises(InputError, match=r"unknown strategy 'compas'; did you mean compass\?"):
        strategy("compas")


def test_unknown_name_far_from_any():
    with pytest.raises(InputError, match=r"unknown strategy 'xyz'; installed: .*compass"):
        strategy("xyz")


def test_nothing_installed(installed):
    installed()
    assert strategies() == ()
    with pytest.raises(InputError, match="unknown strategy 'xyz'; installed: none"):
        strategy("xyz")


@pytest.mark.parametrize(
    ("name", "what", "folder"),
    [
        ("compass", r"'stereorecal\[default\]'", "compass"),
        ("secant", r"'stereorecal\[default\]'", "compass"),
        ("optimistix-bfgs", r"'stereorecal\[default\]'", "optimistix"),
        ("nlopt-bobyqa", "stereorecal-nlopt", "nlopt"),
        ("features", "stereorecal-features", "features"),
    ],
)
def test_a_missing_one_of_ours_gives_the_install_line(installed, name: str, what: str, folder: str):
    installed()
    with pytest.raises(InputError, match=f"strategy {name} is not installed; run: pip install {what} .*/{folder}"):
        strategy(name)


def test_doubled_name_says_both_distributions(installed):
    installed(point("compass", distribution="one"), point("compass", "other:Compass", "two"))
    assert strategies() == ("compass",)
    with pytest.raises(InputError, match="compass is claimed by one and two; uninstall all but one"):
        strategy("compass")


def test_the_same_distribution_found_twice_is_no_conflict(installed):
    """An editable install beside a stale one, both on the path."""
    installed(point("compass"), point("compass"))
    assert type(strategy("compass")).__name__ == "Compass"


@pytest.mark.parametrize("value", ["no_such_module:Thing", "stereorecal_compass:NoSuchThing"])
def test_broken_entry_point(installed, value):
    installed(point("shaky", value, "shaky-plugin"))
    with pytest.raises(StrategyError, match=r"shaky of shaky-plugin 1\.2 cannot be loaded .*reinstall or remove it"):
        strategy("shaky")


@pytest.mark.parametrize("value", ["json:dumps", "json:JSONDecoder"])
def test_entry_point_that_is_no_strategy(installed, value):
    installed(point("odd", value, "odd-plugin"))
    with pytest.raises(StrategyError, match=r"entry point odd of odd-plugin 1\.2 is no strategy class"):
        strategy("odd")


def test_a_broken_one_does_not_hide_the_others(installed):
    installed(point("compass"), point("shaky", "no_such_module:Thing", "shaky-plugin"))
    assert strategies() == ("compass", "shaky")
    assert type(strategy("compass")).__name__ == "Compass"


def test_unknown_option():
    with pytest.raises(InputError, match=r"strategy compass has no option 'stepp'; it has: step, min_step"):
        strategy("compass", stepp=1.0)


def test_listing_imports_no_plugin():
    code = (
        "import sys, stereorecal as sr; assert 'compass' in sr.strategies(); "
        "assert 'stereorecal_compass' not in sys.modules; sr.strategy('compass'); "
        "assert 'stereorecal_compass' in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
