"""`python -m stereorecal strategies` and `matchers`: what is installed, loadable or not, or checks of one."""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table
from rich.text import Text

from stereorecal._errors import InputError
from stereorecal._plugins import Plugin
from stereorecal.cli._experiment_commands import PluginOptions
from stereorecal.cli._option_values import NONE_INSTALLED
from stereorecal.cli._signals import FAILURE
from stereorecal.cli._terminal import table_console
from stereorecal.matching import AbstractMatcher, matcher, overview as matchers_found
from stereorecal.strategies import overview as strategies_found, strategy

if TYPE_CHECKING:
    from stereorecal.testing import CheckResult  # which renders scenes: a list of names does not wait for that


def run(options: PluginOptions) -> int:
    """List the installed plug-ins, or check one; returns the exit code."""
    of_strategies, name = options.verb == "strategies", options.name
    if name is not None:
        from stereorecal.testing import check_matcher, check_strategy  # a list of names does not wait for scenes

        return _print_checks(check_strategy(strategy(name)) if of_strategies else check_matcher(matcher(name)))
    if not of_strategies:
        return _print_list(matchers_found(), "runs", _where_it_runs)
    if not (found := strategies_found()):
        raise InputError(NONE_INSTALLED)
    return _print_list(found, "needs", lambda cls: cls.needs.name.lower())


def _where_it_runs(cls: type[AbstractMatcher]) -> str:
    if not cls.traceable:
        return "on the host"
    return "in JAX, smooth" if cls.smooth else "in JAX"  # the soft count can use it


def _print_list(found: Mapping[str, Plugin[Any] | Exception], heading: str, trait: Callable[[Any], str]) -> int:
    """One row for each plug-in, with the trait of its class, or the error it has; returns the exit code."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in ("name", "distribution", "version", heading, "what it does"):
        table.add_column(column, overflow="fold")
    failed = False
    for name, one in found.items():
        if isinstance(one, Plugin):
            cells = name, one.distribution, one.version, trait(one.cls), one.summary
        else:
            cells, failed = (name, "-", "-", "-", str(one)), True
        table.add_row(*map(Text, cells))
    table_console(124).print(table)
    return FAILURE if failed else 0


def _print_checks(report: "Iterable[CheckResult]") -> int:
    """One line for each check; returns the exit code."""
    passed = True
    for result in report:
        passed &= result.passed
        print(f"{'pass' if result.passed else 'FAIL'}  {result.name}{'' if result.passed else ': ' + result.message}")
    return 0 if passed else 1
