"""`python -m stereorecal strategies`."""

import argparse

from rich import box
from rich.table import Table
from rich.text import Text

from stereorecal._errors import InputError
from stereorecal.cli._console import table_console
from stereorecal.cli._exit_codes import FAILURE
from stereorecal.cli._values import NONE_INSTALLED
from stereorecal.strategies import StrategyInfo, overview, strategy


def run(options: argparse.Namespace) -> int:
    """List the installed strategies, or check one; returns the exit code."""
    return _check(options.name) if options.action == "check" else _list()


def _list() -> int:
    found = overview()
    if not found:
        raise InputError(NONE_INSTALLED)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("name", "distribution", "version", "needs", "what it does"):
        table.add_column(heading, overflow="fold")
    for name, info in found.items():
        known = isinstance(info, StrategyInfo)
        cells = (info.distribution, info.version, info.needs, info.summary) if known else ("-", "-", "-", str(info))
        table.add_row(*map(Text, (name, *cells)))
    table_console(124).print(table)
    return 0 if all(isinstance(info, StrategyInfo) for info in found.values()) else FAILURE


def _check(name: str) -> int:
    from stereorecal.testing import check_strategy  # renders scenes: a list of names does not wait for that

    report = check_strategy(strategy(name))
    for result in report:
        print(f"{'pass' if result.passed else 'FAIL'}  {result.name}{'' if result.passed else ': ' + result.message}")
    return 0 if all(result.passed for result in report) else 1
