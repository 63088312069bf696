"""`python -m stereorecal matchers`."""

import argparse

from stereorecal.cli._plugins import print_checks, print_list
from stereorecal.matching import MatcherInfo, matcher, overview


def run(options: argparse.Namespace) -> int:
    """List the installed matchers, or check one; returns the exit code."""
    return _check(options.name) if options.action == "check" else _list()


def _list() -> int:
    return print_list(overview(), MatcherInfo, ("name", "distribution", "version", "runs", "what it does"))


def _check(name: str) -> int:
    from stereorecal.testing import check_matcher  # a list of names does not wait for what it imports

    return print_checks(check_matcher(matcher(name)))
