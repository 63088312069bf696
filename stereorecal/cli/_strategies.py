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
from stereorecal.testing import check_strategy


def add_to(verbs, common: argparse.ArgumentParser) -> None:
    """Add the command, with the options that are `common` to all, to an argparse subparsers object."""
    shared = [common]
    parser = verbs.add_parser("strategies", parents=shared, help="list the installed strategies, or check one")
    actions = parser.add_subparsers(metavar="ACTION")
    every = actions.add_parser("list", parents=shared, help="list the installed strategies (the default)")
    every.set_defaults(run=_list)
    check = actions.add_parser("check", parents=shared, help="run the conformance kit on a strategy")
    check.add_argument("name")
    check.set_defaults(run=_check)
    parser.set_defaults(run=_list)


def _list(options: argparse.Namespace) -> int:
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


def _check(options: argparse.Namespace) -> int:
    report = check_strategy(strategy(options.name))
    for result in report:
        print(f"{'pass' if result.passed else 'FAIL'}  {result.name}{'' if result.passed else ': ' + result.message}")
    return 0 if all(result.passed for result in report) else 1
