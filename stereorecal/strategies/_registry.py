"""Strategies by name, from the entry-point group `stereorecal.strategies`; each is imported when it is asked for."""

import dataclasses
import difflib
import inspect
import reprlib
import sys
from collections.abc import Collection
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, entry_points, packages_distributions, version
from typing import Any

from stereorecal._errors import InputError, StrategyError
from stereorecal.strategies._contract import AbstractStrategy

GROUP = "stereorecal.strategies"
# importlib.metadata's; on Python 3.11 its backport's, once anything (Dask does) has imported that.
_EntryPoint = Any
# Our own strategies, by name or by prefix: what to install if one is missing, and its folder in a clone.
_KNOWN = {
    "compass": ("'stereorecal[default]'", "compass"),
    "gradient-descent": ("'stereorecal[default]'", "compass"),
    "secant": ("'stereorecal[default]'", "compass"),
    "levenberg-marquardt": ("'stereorecal[default]'", "levenberg-marquardt"),
    "optimistix-": ("stereorecal-optimistix", "optimistix"),
    "nlopt-": ("stereorecal-nlopt", "nlopt"),
    "features": ("stereorecal-features", "features"),
}


@dataclass(frozen=True)
class StrategyInfo:
    """One line of `python -m stereorecal strategies`."""

    name: str
    distribution: str
    version: str
    needs: str
    summary: str


def strategies() -> tuple[str, ...]:
    """The names of all installed strategies, sorted; imports none of them."""
    return tuple(sorted({point.name for point in entry_points(group=GROUP)}))


def strategy(name: str, /, **options: Any) -> AbstractStrategy:
    """The strategy registered as `name`, with the given options.

    Raises:
        InputError: if no such strategy is installed, two distributions claim the name, or an option is unknown or
            refused by the strategy.
        StrategyError: if it cannot be imported, or crashes when it is made.
    """
    point = _entry_point(name)
    cls = _load(point)
    fields = dataclasses.fields(cls)
    known = [field.name for field in fields]
    if unknown := sorted(set(options) - set(known)):
        raise InputError(f"strategy {name} has no option {unknown[0]!r}; it has: {', '.join(known) or 'none'}.")
    if missing := [field.name for field in fields if _is_needed(field) and field.name not in options]:
        raise InputError(f"strategy {name} needs the option {missing[0]!r}; give it.")
    try:
        return cls(**options)
    except ValueError as error:  # its own check of its options
        raise InputError(f"strategy {name}: {(str(error) or repr(error)).rstrip('.')}.") from error
    except Exception as error:
        raise StrategyError(
            f"strategy {name} of {' '.join(_distribution(point))} cannot be made ({error!r})."
        ) from error


def describe(name: str) -> StrategyInfo:
    """What the strategy registered as `name` does, what it needs and which distribution it comes from.

    Raises:
        InputError, StrategyError: as `strategy` does.
    """
    return _described(_entry_point(name))


def overview() -> dict[str, StrategyInfo | InputError | StrategyError]:
    """What `describe` returns or raises for each installed strategy; what is installed is looked up once for all."""
    points = entry_points(group=GROUP)
    return {name: _described_or_error(points.select(name=name)) for name in sorted(points.names)}


def name_of(instance: AbstractStrategy) -> str:
    """The name under which the strategy's class is registered, or the class's name if it is not; imports nothing."""
    cls = type(instance)
    return min((point.name for point in entry_points(group=GROUP) if _registers(point, cls)), default=cls.__name__)


def origin_of(instance: AbstractStrategy) -> str:
    """The distribution of the strategy's class and its version, or the class's module if it is not installed."""
    package = type(instance).__module__.partition(".")[0]
    # An editable install does not list its packages, but its entry points name them.
    for point in entry_points(group=GROUP):
        if point.dist and _place(point)[0].partition(".")[0] == package:
            return " ".join(_distribution(point))
    for distribution in packages_distributions().get(package, []):
        try:
            return f"{distribution} {version(distribution)}"
        except PackageNotFoundError:
            continue
    return type(instance).__module__


def _is_needed(field: dataclasses.Field) -> bool:
    return field.init and field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


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


def _described(point: _EntryPoint) -> StrategyInfo:
    cls = _load(point)
    summary = (inspect.getdoc(cls) or "").partition("\n")[0]
    return StrategyInfo(point.name, *_distribution(point), cls.needs.name.lower(), summary)


def _described_or_error(points: Collection[_EntryPoint]) -> StrategyInfo | InputError | StrategyError:
    try:
        return _described(_the_one(points))
    except (InputError, StrategyError) as error:
        return error


def _load(point: _EntryPoint) -> type[AbstractStrategy]:
    try:
        cls = point.load()
    except Exception as error:
        distribution, number = _distribution(point)
        raise StrategyError(
            f"strategy {point.name} of {distribution} {number} cannot be loaded ({error!r}); reinstall or remove it."
        ) from error
    if not (isinstance(cls, type) and issubclass(cls, AbstractStrategy)):
        raise StrategyError(
            f"the entry point {point.name} of {' '.join(_distribution(point))} is not a strategy class."
        )
    return cls


def _entry_point(name: str) -> _EntryPoint:
    if not isinstance(name, str):
        raise InputError(_no_name(name))
    points = entry_points(group=GROUP, name=name)
    if not points:
        raise InputError(_missing(name))
    return _the_one(points)


def _the_one(points: Collection[_EntryPoint]) -> _EntryPoint:
    point, *_ = points
    owners = sorted({_distribution(point)[0] for point in points})
    if len(owners) > 1:
        raise InputError(f"strategy {point.name} is claimed by {' and '.join(owners)}; uninstall all but one.")
    return point


def _no_name(given: Any) -> str:
    if isinstance(given, AbstractStrategy):
        return f"this {type(given).__name__} is a strategy already; pass it on as it is."
    if isinstance(given, type) and issubclass(given, AbstractStrategy):
        return f"{given.__name__} is a strategy's class; make a strategy of it with {given.__name__}()."
    return f"{reprlib.repr(given)} is no name of a strategy; give a string, such as sr.strategy('compass')."


def _missing(name: str) -> str:
    installed = strategies()
    for known, (what, folder) in _KNOWN.items():
        family = known.endswith("-") and name.startswith(known)
        if name == known or (family and not any(other.startswith(known) for other in installed)):
            line = f"pip install {what} (in a clone: pip install -e plugins/{folder})"
            return f"strategy {name} is not installed; run: {line}"
    close = difflib.get_close_matches(name, installed, 1)
    hint = f"did you mean {close[0]}?" if close else f"installed: {', '.join(installed) or 'none'}."
    return f"unknown strategy {name!r}; {hint}"


def _distribution(point: _EntryPoint) -> tuple[str, str]:
    return (point.dist.name, point.dist.version) if point.dist else ("unknown distribution", "")
