"""`python -m stereorecal strategies`."""

import argparse

from stereorecal._errors import InputError
from stereorecal.cli._plugins import print_checks, print_list
from stereorecal.cli._values import NONE_INSTALLED
from stereorecal.strategies import StrategyInfo, overview, strategy


def run(options: argparse.Namespace) -> int:
    """List the installed strategies, or check one; returns the exit code."""
    return _check(options.name) if options.action == "check" else _list()


def _list() -> int:
    found = overview()
    if not found:
        raise InputError(NONE_INSTALLED)
    return print_list(found, StrategyInfo, ("name", "distribution", "version", "needs", "what it does"))


def _check(name: str) -> int:
    from stereorecal.testing import check_strategy  # renders scenes: a list of names does not wait for that

    return print_checks(check_strategy(strategy(name)))
