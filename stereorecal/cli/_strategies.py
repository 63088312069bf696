"""`python -m stereorecal strategies`."""

import argparse

from rich import box
from rich.table import Table
from rich.text import Text

from stereorecal._errors import InputError, StrategyError
from stereorecal.cli._console import table_console
from stereorecal.cli._exit_codes import FAILURE
from stereorecal.cli._values import NONE_INSTALLED
from stereorecal.strategies import describe, strategies, strategy


def run(options: argparse.Namespace) -> int:
    """List the installed strategies, or check one; returns the exit code."""
    return _check(options.name) if options.action == "check" else _list()


def _list() -> int:
    if not strategies():
        raise InputError(NONE_INSTALLED)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("name", "distribution", "version", "needs", "what it does"):
        table.add_column(heading, overflow="fold")
    broken = False
    for name in strategies():
        try:
            info = describe(name)
            cells = (info.name, info.distribution, info.version, info.needs, info.summary)
        except (InputError, StrategyError) as error:
            broken = True
            cells = (name, "-", "-", "-", str(error))
        table.add_row(*map(Text, cells))
    table_console(124).print(table)
    return FAILURE if broken else 0


def _check(name: str) -> int:
    from stereorecal.testing import check_strategy  # renders scenes: a list of names does not wait for that

    report = check_strategy(strategy(name))
    for result in report:
        print(f"{'pass' if result.passed else 'FAIL'}  {result.name}{'' if result.passed else ': ' + result.message}")
    return 0 if all(result.passed for result in report) else 1
