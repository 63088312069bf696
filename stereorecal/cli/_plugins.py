"""What the commands about plug-ins print: a list with what could not be loaded in it, and the results of checks."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, fields
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table
from rich.text import Text

from stereorecal.cli._console import table_console
from stereorecal.cli._exit_codes import FAILURE

if TYPE_CHECKING:
    from stereorecal.testing import CheckResult  # which renders scenes: a list of names does not wait for that


def print_list(found: Mapping[str, Any], info: type, headings: Sequence[str]) -> int:
    """One row for each plug-in, `info` under its headings or the error it has; returns the exit code."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for name, one in found.items():
        cells = astuple(one) if isinstance(one, info) else (name, *["-"] * (len(fields(info)) - 2), str(one))
        table.add_row(*map(Text, cells))
    table_console(124).print(table)
    return 0 if all(isinstance(one, info) for one in found.values()) else FAILURE


def print_checks(report: "Iterable[CheckResult]") -> int:
    """One line for each check; returns the exit code."""
    passed = True
    for result in report:
        passed &= result.passed
        print(f"{'pass' if result.passed else 'FAIL'}  {result.name}{'' if result.passed else ': ' + result.message}")
    return 0 if passed else 1
