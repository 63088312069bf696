"""Strategies by name, from the entry-point group `stereorecal.strategies`; loaded when asked for, not before."""

import dataclasses
import difflib
import inspect
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, entry_points, packages_distributions, version
from typing import Any

from stereorecal._errors import InputError, StrategyError
from stereorecal.strategies._contract import AbstractStrategy

GROUP = "stereorecal.strategies"
# Of importlib.metadata; on Python 3.11, of its backport from the moment that something (Dask) imports that.
_EntryPoint = Any
# Names, or how they begin, of strategies that may be missing: what to install, and its folder in a clone.
_KNOWN = {
    "compass": ("'stereorecal[default]'", "compass"),
    "gradient-descent": ("'stereorecal[default]'", "compass"),
    "secant": ("'stereorecal[default]'", "compass"),
    "optimistix-": ("'stereorecal[default]'", "optimistix"),
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
    """The names of all installed strategies, sorted. Imports none of them."""
    return tuple(sorted({point.name for point in entry_points(group=GROUP)}))


def strategy(name: str, **options: Any) -> AbstractStrategy:
    """The strategy called `name`, with its options.

    Raises:
        InputError: if no such strategy is installed, two distributions claim the name, or it has no such option.
        StrategyError: if its distribution cannot be imported.
    """
    cls = _load(name)
    known = [field.name for field in dataclasses.fields(cls)]
    if unknown := sorted(set(options) - set(known)):
        raise InputError(f"strategy {name} has no option {unknown[0]!r}; it has: {', '.join(known) or 'none'}.")
    return cls(**options)


def describe(name: str) -> StrategyInfo:
    """What the strategy called `name` is and where it comes from.

    Raises:
        InputError, StrategyError: as `strategy`.
    """
    cls, point = _load(name), _entry_point(name)
    summary = (inspect.getdoc(cls) or "").partition("\n")[0]
    return StrategyInfo(name, *_distribution(point), cls.needs.name.lower(), summary)


def origin_of(instance: AbstractStrategy) -> str:
    """ "distribution version" of a strategy's class, or its module if it is not installed."""
    package = type(instance).__module__.partition(".")[0]
    # An editable install does not say which packages are its own, but its entry points do.
    for point in entry_points(group=GROUP):
        if point.dist and point.module.partition(".")[0] == package:
            return " ".join(_distribution(point))
    for distribution in packages_distributions().get(package, []):
        try:
            return f"{distribution} {version(distribution)}"
        except PackageNotFoundError:
            continue
    return type(instance).__module__


def _load(name: str) -> type[AbstractStrategy]:
    point = _entry_point(name)
    try:
        cls = point.load()
    except Exception as error:
        distribution, number = _distribution(point)
        raise StrategyError(
            f"strategy {name} of {distribution} {number} cannot be loaded ({error!r}); reinstall or remove it."
        ) from error
    if not (isinstance(cls, type) and issubclass(cls, AbstractStrategy)):
        raise StrategyError(f"the entry point {name} of {' '.join(_distribution(point))} is no strategy class.")
    return cls


def _entry_point(name: str) -> _EntryPoint:
    points = tuple(entry_points(group=GROUP, name=name))
    if not points:
        raise InputError(_missing(name))
    owners = sorted({_distribution(point)[0] for point in points})
    if len(owners) > 1:
        raise InputError(f"strategy {name} is claimed by {' and '.join(owners)}; uninstall all but one.")
    return points[0]


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
