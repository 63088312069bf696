"""Strategies by name, from the entry-point group `stereorecal.strategies`; each is imported when it is used."""

from typing import Any

from stereorecal._errors import StrategyError
from stereorecal._plugins import Registry
from stereorecal.strategies._contract import AbstractStrategy

GROUP = "stereorecal.strategies"
_REGISTRY = Registry[AbstractStrategy](
    GROUP,
    kind="strategy",
    base=AbstractStrategy,
    error=StrategyError,
    example="compass",
    elsewhere={
        **dict.fromkeys(("compass", "gradient-descent", "secant"), "compass"),
        "levenberg-marquardt": "levenberg-marquardt",
        "optimistix-": "optimistix",
        "nlopt-": "nlopt",
        **dict.fromkeys(("essential-matrix", "features", "superpoint", "xfeat"), "features"),
        "colmap": "colmap",
    },
)


describe = _REGISTRY.find
overview = _REGISTRY.overview
check_installed = _REGISTRY.check
name_of = _REGISTRY.name_of
origin_of = _REGISTRY.origin_of


def strategies() -> tuple[str, ...]:
    """The names of all installed strategies, sorted; imports none of them."""
    return _REGISTRY.names()


def strategy(name: str, /, **options: Any) -> AbstractStrategy:
    """The strategy registered as `name`, with the given options.

    Raises:
        InputError: if no such strategy is installed, two distributions claim the name, or an option is unknown or
            refused by the strategy.
        StrategyError: if it cannot be imported, or crashes when it is made.
    """
    return _REGISTRY.make(name, options)
