"""Plug-ins by name: classes that distributions register in an entry-point group, each imported when it is used.

Strategies and matchers are registered in the same way; this module knows neither. The names of matchers stand here all
the same: matchers need JAX, for which a name that is mistyped on a command line does not wait.
"""

import dataclasses
import difflib
import importlib.metadata
import inspect
import os
import reprlib
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import EntryPoint, EntryPoints, PackageNotFoundError, packages_distributions, version
from typing import Any, Generic, TypeVar

from stereorecal._errors import InputError, MatcherError, PluginError
from stereorecal._version import __version__

T = TypeVar("T")
# importlib.metadata's; on Python 3.11 its backport's, once anything (Dask does) has imported that.
_EntryPoint = Any
_UNKNOWN_OWNER = ("unknown distribution", "")


def install_line(folder: str) -> str:
    """What installs a distribution of this project, named by its folder in a clone."""
    what = "'stereorecal[default]'" if folder == "compass" else f"stereorecal-{folder}"
    return f"pip install {what} (in a clone: pip install -e plugins/{folder})"


_AT_REST = 2e9  # nanoseconds without a change, after which an installation has ended


def entry_points(*, group: str) -> EntryPoints:
    """The entry points of a group, read anew where a folder of `sys.path` changed since, or just now."""
    places = tuple(map(_changed_at, sys.path))
    changing = max(changed for _, changed in places) > time.time_ns() - _AT_REST
    return (importlib.metadata.entry_points() if changing else _of_all_groups(places)).select(group=group)


@lru_cache(maxsize=8)
def _of_all_groups(places: tuple[tuple[str, int], ...]) -> Any:
    """What can select a group: to read one takes as long as to read all."""
    return importlib.metadata.entry_points()


def _changed_at(place: str) -> tuple[str, int]:
    try:
        return place, os.stat(place or os.curdir).st_mtime_ns
    except OSError:
        return place, 0


@dataclass(frozen=True)
class Plugin(Generic[T]):
    """A registered class, and the distribution that it came with."""

    name: str
    distribution: str
    version: str
    cls: type[T]

    @property
    def summary(self) -> str:
        """The first line of its docstring."""
        return (inspect.getdoc(self.cls) or "").partition("\n")[0]


@dataclass(frozen=True)
class Registry(Generic[T]):
    """The plug-ins of one kind.

    Attributes:
        group: of the entry points.
        kind: what one of them is called in messages, such as "strategy".
        base: the class that each inherits from.
        error: raised, with a sentence, where an installed plug-in cannot be loaded or made.
        example: of a name, for a message.
        elsewhere: names, and beginnings of names that end in "-", of plug-ins of this project that are distributions of
            their own, with their folders in a clone.
        own: entry points of this very distribution, name to "module:Class". They are there as well where the installed
            metadata is older than the code (a clone that was updated but not reinstalled), or was not packed along.
    """

    group: str
    kind: str
    base: type[T]
    error: type[PluginError]
    example: str
    elsewhere: Mapping[str, str] = field(default_factory=dict)
    own: Mapping[str, str] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        """All names that are installed, sorted; imports nothing."""
        return tuple(sorted(self._points().names))

    def make(self, name: str, options: Mapping[str, Any]) -> T:
        """An instance of the class registered as `name`, with these options.

        Raises:
            InputError: if the name is not installed, or claimed by two distributions, or an option is unknown, missing
                or refused by the class.
            `error`: if it cannot be imported, or crashes when it is made.
        """
        found = self.find(name)
        fields = dataclasses.fields(found.cls)  # pyright: ignore[reportArgumentType]
        known = [option.name for option in fields]
        if unknown := sorted(set(options) - set(known)):
            raise InputError(f"{self.kind} {name} has no option {unknown[0]!r}; it has: {', '.join(known) or 'none'}.")
        needed = (f.name for f in fields if f.init and f.default is f.default_factory is dataclasses.MISSING)
        if missing := [option for option in needed if option not in options]:
            raise InputError(f"{self.kind} {name} needs the option {missing[0]!r}; give it.")
        try:
            return found.cls(**options)
        except ValueError as error:  # its own check of its options
            raise InputError(f"{self.kind} {name}: {(str(error) or repr(error)).rstrip('.')}.") from error
        except Exception as error:
            owner = f"{found.distribution} {found.version}"
            raise self.error(f"{self.kind} {name} of {owner} cannot be made ({error!r}).") from error

    def find(self, name: str) -> Plugin[T]:
        """The class registered as `name`, imported.

        Raises:
            InputError, `error`: as `make` does.
        """
        return self._load(self._point(name))

    def check(self, name: str) -> None:
        """Refuse a name that `find` would not find; imports nothing.

        Raises:
            InputError: as `make` does.
        """
        self._point(name)

    def overview(self) -> dict[str, Plugin[T] | Exception]:
        """What `find` returns or raises for each name; the installed metadata is read once."""
        points = self._points()
        return {name: self._found_or_error(points.select(name=name)) for name in sorted(points.names)}

    def name_of(self, instance: T) -> str:
        """The name under which its class is registered, or the class's name if it is not; imports nothing."""
        cls = type(instance)
        return min((point.name for point in self._points() if _registers(point, cls)), default=cls.__name__)

    def origin_of(self, instance: T) -> str:
        """The distribution of the instance's class and its version, or the class's module if it is not installed."""
        package = type(instance).__module__.partition(".")[0]
        # An editable install does not list its packages, but its entry points name them.
        for point in self._points():
            owner = self._owner(point)
            if owner != _UNKNOWN_OWNER and _place(point)[0].partition(".")[0] == package:
                return " ".join(owner)
        for distribution in packages_distributions().get(package, []):
            with suppress(PackageNotFoundError):
                return f"{distribution} {version(distribution)}"
        return type(instance).__module__

    def _point(self, name: str) -> _EntryPoint:
        if not isinstance(name, str):
            raise InputError(self._no_name(name))
        points = self._points().select(name=name)
        if not points:
            raise InputError(self._missing(name))
        return self._only(points)

    def _points(self) -> EntryPoints:
        installed = entry_points(group=self.group)
        known = {(point.name, point.value) for point in installed}
        lacking = [EntryPoint(*own, self.group) for own in self.own.items() if own not in known]
        return EntryPoints((*installed, *lacking)) if lacking else installed

    def _owner(self, point: _EntryPoint) -> tuple[str, str]:
        """Name and version of the distribution of an entry point."""
        if point.dist:
            return point.dist.name, point.dist.version
        return ("stereorecal", __version__) if self.own.get(point.name) == point.value else _UNKNOWN_OWNER

    def _only(self, points: EntryPoints) -> _EntryPoint:
        point, *_ = points
        owners = sorted({self._owner(point)[0] for point in points})
        if len(owners) > 1:
            raise InputError(f"{self.kind} {point.name} is claimed by {' and '.join(owners)}; uninstall all but one.")
        return point

    def _load(self, point: _EntryPoint) -> Plugin[T]:
        distribution, number = self._owner(point)
        owner = f"{point.name} of {distribution} {number}"
        try:
            cls = point.load()
        except Exception as error:
            raise self.error(f"{self.kind} {owner} cannot be loaded ({error!r}); reinstall or remove it.") from error
        if not (isinstance(cls, type) and issubclass(cls, self.base)):
            raise self.error(f"the entry point {owner} is not a {self.kind} class.")
        return Plugin(point.name, distribution, number, cls)

    def _found_or_error(self, points: EntryPoints) -> Plugin[T] | Exception:
        try:
            return self._load(self._only(points))
        except (InputError, self.error) as error:
            return error

    def _no_name(self, given: Any) -> str:
        if isinstance(given, self.base):
            return f"this {type(given).__name__} is a {self.kind} already; pass it on as it is."
        if isinstance(given, type) and issubclass(given, self.base):
            return f"{given.__name__} is a {self.kind}'s class; make a {self.kind} of it with {given.__name__}()."
        right = f"sr.{self.kind}({self.example!r})"
        return f"{reprlib.repr(given)} is no name of a {self.kind}; give a string, such as {right}."

    def _missing(self, name: str) -> str:
        installed = self.names()
        for known, folder in self.elsewhere.items():
            family = known.endswith("-") and name.startswith(known)
            if name == known or (family and not any(other.startswith(known) for other in installed)):
                return f"{self.kind} {name} is not installed; run: {install_line(folder)}"
        close = difflib.get_close_matches(name, installed, 1)
        hint = f"did you mean {close[0]}?" if close else f"installed: {', '.join(installed) or 'none'}."
        return f"unknown {self.kind} {name!r}; {hint}"


MATCHER_NAMES = Registry[Any](
    "stereorecal.matchers",
    kind="matcher",
    base=object,  # what a matcher is, is known where it is loaded
    error=MatcherError,
    example="sgbm",
    own={"sad": "stereorecal.matching:SAD", "bm": "stereorecal.matching:BM", "sgbm": "stereorecal.matching:SGBM"},
)


def _place(point: _EntryPoint) -> tuple[str, str]:
    """Module and attribute of an entry point; importlib.metadata raises on a malformed one."""
    module, _, attribute = point.value.partition("[")[0].partition(":")
    return module.strip(), attribute.strip()


def _registers(point: _EntryPoint, cls: type) -> bool:
    """Whether an entry point stands for `cls`: by its own path, or by that of a re-export in an imported module."""
    module, attribute = _place(point)
    if (module, attribute) == (cls.__module__, cls.__qualname__):
        return True
    found = sys.modules.get(module)
    for part in attribute.split("."):
        found = inspect.getattr_static(found, part, None)  # a lazy module would import something
    return found is cls
