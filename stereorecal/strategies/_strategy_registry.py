"""Strategies by name, from the entry-point group `stereorecal.strategies`; each is imported when it is used."""

from dataclasses import dataclass
from typing import Any

from stereorecal._errors import StrategyError
from stereorecal._plugins import Plugin, Registry
from stereorecal.strategies._contract import AbstractStrategy

GROUP = "stereorecal.strategies"
_REGISTRY = Registry[AbstractStrategy](
    GROUP,
    kind="strategy",
    base=AbstractStrategy,
    error=StrategyError,
    example="compass",
    elsewhere={
        "compass": ("'stereorecal[default]'", "compass"),
        "gradient-descent": ("'stereorecal[default]'", "compass"),
        "secant": ("'stereorecal[default]'", "compass"),
        "levenberg-marquardt": ("stereorecal-levenberg-marquardt", "levenberg-marquardt"),
        "optimistix-": ("stereorecal-optimistix", "optimistix"),
        "nlopt-": ("stereorecal-nlopt", "nlopt"),
        "essential-matrix": ("stereorecal-features", "features"),
        "features": ("stereorecal-features", "features"),
        "superpoint": ("stereorecal-features", "features"),
        "xfeat": ("stereorecal-features", "features"),
        "colmap": ("stereorecal-colmap", "colmap"),
    },
)


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
    return _REGISTRY.names()


def check_installed(name: str) -> None:
    """Refuse a name that no installed strategy has; imports none of them.

    Raises:
        InputError: as `strategy` does.
    """
    _REGISTRY.check(name)


def strategy(name: str, /, **options: Any) -> AbstractStrategy:
    """The strategy registered as `name`, with the given options.

    Raises:
        InputError: if no such strategy is installed, two distributions claim the name, or an option is unknown or
            refused by the strategy.
        StrategyError: if it cannot be imported, or crashes when it is made.
    """
    return _REGISTRY.make(name, options)


def describe(name: str) -> StrategyInfo:
    """What the strategy registered as `name` does, what it needs and which distribution it comes from.

    Raises:
        InputError, StrategyError: as `strategy` does.
    """
    return _info(_REGISTRY.find(name))


def overview() -> dict[str, StrategyInfo | Exception]:
    """What `describe` returns or raises for each installed strategy; the installed metadata is read once."""
    return {name: _info(found) if isinstance(found, Plugin) else found for name, found in _REGISTRY.overview().items()}


def name_of(instance: AbstractStrategy) -> str:
    """The name under which the strategy's class is registered, or the class's name if it is not; imports nothing."""
    return _REGISTRY.name_of(instance)


def origin_of(instance: AbstractStrategy) -> str:
    """The distribution of the strategy's class and its version, or the class's module if it is not installed."""
    return _REGISTRY.origin_of(instance)


def _info(found: Plugin[AbstractStrategy]) -> StrategyInfo:
    return StrategyInfo(found.name, found.distribution, found.version, found.cls.needs.name.lower(), found.summary)
