"""Checks of plug-ins; a check is a function that raises AssertionError with a sentence."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Check = Callable[[Any], None]


@dataclass(frozen=True)
class CheckResult:
    """The result of a check: its name, whether it passed, and if not, why."""

    name: str
    passed: bool
    message: str = ""


class Checks:
    """The checks of one kind of plug-in, each with the plug-ins that it applies to."""

    def __init__(self) -> None:
        self._all: list[tuple[Check, Callable[[Any], bool]]] = []

    def add(self, applies: Callable[[Any], bool] = lambda plugin: True) -> Callable[[Check], Check]:
        """Decorate a check of those plug-ins that it applies to."""

        def register(check: Check) -> Check:
            self._all.append((check, applies))
            return check

        return register

    def of(self, plugin: Any) -> tuple[Check, ...]:
        """The checks that apply to a plug-in."""
        return tuple(check for check, applies in self._all if applies(plugin))

    def run(self, plugin: Any) -> tuple[CheckResult, ...]:
        """The results of all that apply; an exception fails a check, and the others still run."""
        results = []
        for check in self.of(plugin):
            name = check.__name__.replace("_", " ")
            try:
                check(plugin)
            except Exception as error:
                results.append(CheckResult(name, False, str(error) or repr(error)))
            else:
                results.append(CheckResult(name, True))
        return tuple(results)

    def add_tests(self, cls: type, plugin: Any) -> None:
        """Add a test method for each check that applies to a test class."""
        for check in self.of(plugin):

            def test(self, check: Check = check) -> None:
                check(plugin)

            test.__doc__ = check.__doc__
            setattr(cls, f"test_{check.__name__}", test)
