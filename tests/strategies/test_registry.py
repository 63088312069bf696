"""Strategies by name: found lazily, refused with a sentence that helps."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

from stereorecal import InputError, MatcherError, StrategyError, matching
from stereorecal.strategies import (
    AbstractStrategy,
    Need,
    describe,
    name_of,
    origin_of,
    overview,
    strategies,
    strategy,
)

GROUP = "stereorecal.strategies"


class Point(NamedTuple):
    """An entry point, and the distribution that has it."""

    name: str
    value: str = "stereorecal_compass:Compass"
    distribution: str = "stereorecal-compass"


@pytest.fixture
def installed(nothing_installed, install):
    """installed(points...): strategies that are installed, and no other."""

    def installed(*points: Point) -> None:
        for name, value, distribution in points:
            install(GROUP, {name: value}, distribution)

    return installed


def test_what_is_installed():
    assert "compass" in strategies()
    made = strategy("compass", step=0.25)
    assert type(made).__name__ == "Compass"
    assert made.step == 0.25
    info = describe("compass")
    assert info.distribution == "stereorecal-compass"
    assert info.cls.needs is Need.HOST
    assert info.summary.startswith("Compass (pattern) search")
    assert origin_of(made) == f"{info.distribution} {info.version}"


@pytest.mark.parametrize(
    ("name", "what", "folder"),
    [
        ("compass", r"'stereorecal\[default\]'", "compass"),
        ("levenberg-marquardt", "stereorecal-levenberg-marquardt", "levenberg-marquardt"),
        ("optimistix-bfgs", "stereorecal-optimistix", "optimistix"),
        ("nlopt-bobyqa", "stereorecal-nlopt", "nlopt"),
        ("xfeat", "stereorecal-features", "features"),
        ("colmap", "stereorecal-colmap", "colmap"),
    ],
)
def test_a_missing_one_of_ours_gives_the_install_line(installed, name: str, what: str, folder: str):
    installed()
    assert strategies() == ()
    with pytest.raises(InputError, match="unknown strategy 'xyz'; installed: none"):
        strategy("xyz")
    with pytest.raises(InputError, match=f"strategy {name} is not installed; run: pip install {what} .*/{folder}"):
        strategy(name)


def test_doubled_name_says_both_distributions(installed):
    installed(Point("compass", distribution="one"), Point("compass", "other:Compass", "two"))
    assert strategies() == ("compass",)
    with pytest.raises(InputError, match="compass is claimed by one and two; uninstall all but one"):
        strategy("compass")


def test_the_same_distribution_found_twice_is_no_conflict(installed):
    """An editable install beside a stale one, both on the path."""
    installed(Point("compass"), Point("compass"))
    assert type(strategy("compass")).__name__ == "Compass"


class Long(type(strategy("compass"))):
    def __repr__(self):
        return "Long" + 10_000 * "!"


RIGHT = "is no name of a strategy; give a string, such as sr.strategy('compass')."
NO_NAMES = {  # what is refused, and with which sentence
    "a strategy": (strategy("compass", step=0.25), "this Compass is a strategy already; pass it on as it is."),
    "a class": (type(strategy("compass")), "Compass is a strategy's class; make a strategy of it with Compass()."),
    "nothing": (None, f"None {RIGHT}"),
    "names": (["compass"], f"['compass'] {RIGHT}"),
    "another class": (
        object,
        "<class 'object'> is no name of a strategy; give a string, such as sr.strategy('compass').",
    ),
    "a typing error": ("compas", "unknown strategy 'compas'; did you mean compass?"),
}


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("function", [strategy, describe])
@pytest.mark.parametrize(("given", "said"), NO_NAMES.values(), ids=NO_NAMES)
def test_what_is_no_name_is_refused_with_the_right_call(function, given, said):
    with pytest.raises(InputError, match=f"^{re.escape(said)}$"):
        function(given)
    with pytest.raises(InputError, match=r"^.{1,200}$"):
        function(Long())
    with pytest.raises(InputError, match=r"unknown strategy 'xyz'; installed: .*compass"):
        function("xyz")


DOORS = {  # group, one that works, what makes one, what tells of all, and the error
    "strategy": (GROUP, "stereorecal_compass:Compass", strategy, overview, StrategyError),
    "matcher": ("stereorecal.matchers", "stereorecal.matching:BM", matching.matcher, matching.overview, MatcherError),
}


@pytest.mark.parametrize("kind", DOORS)
@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("no_such_module:Thing", "{} shaky of plug-in 1.2 cannot be loaded (ModuleNotFoundError"),
        ("stereorecal_compass:NoSuchThing", "{} shaky of plug-in 1.2 cannot be loaded (AttributeError"),
        ("json:dumps", "the entry point shaky of plug-in 1.2 is not a {} class."),
        ("json:JSONDecoder", "the entry point shaky of plug-in 1.2 is not a {} class."),
    ],
)
def test_a_broken_one_is_told_and_hides_no_other(nothing_installed, install, kind, value, said):
    group, own, make, look, error = DOORS[kind]
    install(group, {"shaky": value, "sound": own})
    with pytest.raises(error) as refusal:
        make("shaky")
    assert str(refusal.value).startswith(said.format(kind))
    assert str(look()["shaky"]) == str(refusal.value)
    assert look()["sound"].name == "sound"


def test_an_overview_has_each_description_or_its_error(installed, nothing_installed):
    """And looks up once what is installed."""
    installed(
        Point("compass"),
        Point("shaky", "no_such_module:Thing", "shaky-plugin"),
        Point("twice", distribution="one"),
        Point("twice", distribution="two"),
    )
    found = overview()
    assert len(nothing_installed) == 1
    assert list(found) == ["compass", "shaky", "twice"]
    assert found["compass"] == describe("compass")
    for name, kind in (("shaky", StrategyError), ("twice", InputError)):
        with pytest.raises(kind) as error:
            describe(name)
        assert isinstance(found[name], kind)
        assert str(found[name]) == str(error.value)


def test_listing_imports_no_plugin():
    code = (
        "import sys, stereorecal as sr; assert 'compass' in sr.strategies(); "
        "assert 'stereorecal_compass' not in sys.modules; sr.strategy('compass'); "
        "assert 'stereorecal_compass' in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@dataclass(frozen=True)
class Local(AbstractStrategy):
    step: float = 0.5

    def run(self, objective, start, seed):
        raise AssertionError("must not run")

    @dataclass(frozen=True)
    class Inner(AbstractStrategy):
        def run(self, objective, start, seed):
            raise AssertionError("must not run")


@pytest.mark.parametrize("name", strategies())
def test_every_installed_strategy_knows_its_name(name):
    assert name_of(strategy(name)) == name


def test_names_are_those_of_registered_classes():
    """Whatever their options; of another class its own name, also where it inherits from a registered one."""

    class Mine(type(strategy("compass"))):
        pass

    assert [name_of(one) for one in (strategy("compass", step=0.25), Local(), Mine())] == ["compass", "Local", "Mine"]


def test_the_name_of_a_class_that_is_registered_through_another_module_or_twice(installed, monkeypatch):
    """The first of two names is taken; a class inside a class has its own."""
    facade = ModuleType("facade")
    facade.Exported = Local
    monkeypatch.setitem(sys.modules, "facade", facade)
    installed(Point("other", "facade:Missing"), Point("zebra", f"{__name__}:Local"))
    assert name_of(Local()) == "zebra"
    installed(Point("exported", "facade:Exported"), Point("deep", "facade:Exported.Inner"))
    assert name_of(Local()) == "exported"
    assert name_of(Local.Inner()) == "deep"


@pytest.mark.parametrize("value", ["", ":", "no colon at all", f"{__name__}:", f"{__name__}:Local:Inner"])
def test_a_malformed_entry_point_hides_no_name(installed, value):
    installed(Point("bad", value), Point("local", f"{__name__}:Local [extra]"))
    assert name_of(Local()) == "local"
    assert origin_of(Local()) in ("stereorecal-compass 1.2", __name__)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"step": -2.0}, r": .*[^.]\.$"),
        ({"stepp": 1.0}, " has no option 'stepp'; it has: step, min_step"),
        ({"name": "x"}, " has no option 'name'; it has: step"),
    ],
    ids=str,
)
def test_what_is_said_of_options(options, said):
    with pytest.raises(InputError, match=f"^strategy compass{said}"):
        strategy("compass", **options)


@dataclass(frozen=True)
class Wanting(AbstractStrategy):
    """Has an option without a default, and a mistake."""

    step: float

    def __post_init__(self):
        if self.step < 0:
            raise ValueError
        len(self.step)

    def run(self, objective, start, seed):
        raise NotImplementedError


def test_what_a_strategy_does_with_its_options(installed):
    installed(Point("wanting", f"{__name__}:Wanting"))
    with pytest.raises(InputError, match=r"^strategy wanting needs the option 'step'; give it\.$"):
        strategy("wanting")
    with pytest.raises(InputError, match=r"^strategy wanting: ValueError\(\)\.$"):
        strategy("wanting", step=-1.0)
    with pytest.raises(StrategyError, match=r"strategy wanting of .* cannot be made .*has no len"):
        strategy("wanting", step=1.0)


def test_metadata_is_read_again_where_something_was_installed_or_removed(tmp_path: Path, nothing_installed):
    """And not otherwise: it takes milliseconds, many times in a repair."""

    def names() -> tuple[str, ...]:
        os.utime(tmp_path, (1e9, 1e9))
        strategies()
        before = len(nothing_installed)
        found = strategies()
        assert len(nothing_installed) == before
        return found

    def changed() -> tuple[str, ...]:
        """At once, in the second of the change."""
        os.utime(tmp_path)
        return strategies()

    assert "zen" not in names()
    info = tmp_path / "zen-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: zen\nVersion: 1.0\n")
    assert "zen" not in changed()
    (info / "entry_points.txt").write_text(f"[{GROUP}]\nzen = zen:Zen\n")
    assert "zen" in changed()
    shutil.rmtree(info)
    assert "zen" not in changed()
