"""Strategies by name: found lazily, refused with a sentence that helps."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

from stereorecal import InputError, StrategyError
from stereorecal.strategies import (
    AbstractStrategy,
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
    assert info.needs == "host"
    assert info.summary.startswith("Compass (pattern) search")
    assert origin_of(made) == f"{info.distribution} {info.version}"


@pytest.mark.parametrize(
    ("name", "said"), [("compas", r"'compas'; did you mean compass\?"), ("xyz", "'xyz'; installed: .*compass")]
)
def test_unknown_name(name, said):
    with pytest.raises(InputError, match=f"unknown strategy {said}"):
        strategy(name)


@pytest.mark.parametrize(
    ("name", "what", "folder"),
    [
        ("compass", r"'stereorecal\[default\]'", "compass"),
        ("levenberg-marquardt", r"'stereorecal\[default\]'", "levenberg-marquardt"),
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


@pytest.mark.parametrize("value", ["no_such_module:Thing", "stereorecal_compass:NoSuchThing"])
def test_broken_entry_point(installed, value):
    installed(Point("shaky", value, "shaky-plugin"))
    with pytest.raises(StrategyError, match=r"shaky of shaky-plugin 1\.2 cannot be loaded .*reinstall or remove it"):
        strategy("shaky")


@pytest.mark.parametrize("value", ["json:dumps", "json:JSONDecoder"])
def test_entry_point_that_is_no_strategy(installed, value):
    installed(Point("odd", value, "odd-plugin"))
    with pytest.raises(StrategyError, match=r"entry point odd of odd-plugin 1\.2 is not a strategy class"):
        strategy("odd")


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
    """Of two names it is the first; a class inside a class has its own."""
    facade = ModuleType("facade")
    facade.Exported = Local
    monkeypatch.setitem(sys.modules, "facade", facade)
    installed(Point("other", "facade:Missing"), Point("zebra", f"{__name__}:Local"))
    assert name_of(Local()) == "zebra"
    installed(Point("exported", "facade:Exported"), Point("deep", "facade:Exported.Inner"))
    assert name_of(Local()) == "exported"
    assert name_of(Local.Inner()) == "deep"


def test_finding_a_name_imports_nothing(installed, monkeypatch):
    lazy, asked = ModuleType("lazy"), []

    def attribute(name):
        asked.append(name)
        raise AttributeError(name)

    lazy.__getattr__ = attribute
    monkeypatch.setitem(sys.modules, "lazy", lazy)
    installed(
        Point("absent", "no_such_module:Thing"),
        Point("lazy", "lazy:Local"),
        Point("whole", "lazy"),
        Point("stdlib", "this:Zen"),
    )
    assert name_of(Local()) == "Local"
    assert "Local" not in asked
    assert "this" not in sys.modules


@pytest.mark.parametrize("value", ["", ":", "no colon at all", f"{__name__}:", f"{__name__}:Local:Inner"])
def test_a_malformed_entry_point_hides_no_name(installed, value):
    installed(Point("bad", value), Point("local", f"{__name__}:Local [extra]"))
    assert name_of(Local()) == "local"
    assert origin_of(Local()) in ("stereorecal-compass 1.2", __name__)


WHAT_IS_NO_NAME = """
from stereorecal.strategies import describe, strategy

class Long(type(strategy("compass"))):
    def __repr__(self):
        return "Long" + 10_000 * "!"

compass = strategy("compass", step=0.25)
for given in (compass, type(compass), None, 5, b"compass", ["compass", "secant"], object, Long()):
    for function in (strategy, describe):
        try:
            function(given)
        except Exception as error:
            print(type(error).__name__, error)
"""


def test_what_is_no_name_is_refused_with_the_right_call():
    """In a process of its own: the type checker of the test suite would be the first to refuse it."""
    command = [sys.executable, "-c", WHAT_IS_NO_NAME]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *sentences, long = done.stdout.splitlines()[::2]
    assert done.stdout.splitlines()[1::2] == [*sentences, long]
    right = "is no name of a strategy; give a string, such as sr.strategy('compass')."
    assert sentences == [
        "InputError this Compass is a strategy already; pass it on as it is.",
        "InputError Compass is a strategy's class; make a strategy of it with Compass().",
        f"InputError None {right}",
        f"InputError 5 {right}",
        f"InputError b'compass' {right}",
        f"InputError ['compass', 'secant'] {right}",
        f"InputError <class 'object'> {right}",
    ]
    assert len(long) < 200


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
