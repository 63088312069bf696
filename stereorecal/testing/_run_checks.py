"""Running checks and reporting them; a check is a function that raises AssertionError with a sentence."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class CheckResult:
    """The result of a check: its name, whether it passed, and if not, why."""

    name: str
    passed: bool
    message: str = ""


def run_checks(checks: Iterable[Callable[[Any], None]], subject: Any) -> tuple[CheckResult, ...]:
    """Run every check on `subject`; an exception fails that check, and the others still run."""
    return tuple(_result(check, subject) for check in checks)


def _result(check: Callable[[Any], None], subject: Any) -> CheckResult:
    name = check.__name__.replace("_", " ")
    try:
        check(subject)
    except Exception as error:
        return CheckResult(name, False, str(error) or repr(error))
    return CheckResult(name, True)


def add_tests(cls: type, checks: Iterable[Callable[[Any], None]], subject: Any) -> None:
    """Add a test method for each check of `subject` to a test class."""
    for check in checks:
        setattr(cls, f"test_{check.__name__}", _as_test(check, subject))


def _as_test(check: Callable[[Any], None], subject: Any) -> Callable[[Any], None]:
    def test(self) -> None:
        check(subject)

    test.__doc__ = check.__doc__
    return test
