"""The conformance kit in its two library forms: a function, and a pytest class to inherit from."""

from dataclasses import dataclass
from typing import ClassVar

from stereorecal.strategies import AbstractStrategy
from stereorecal.testing import _checks


@dataclass(frozen=True)
class CheckResult:
    """One check: its name, whether it passed, and if not, why."""

    name: str
    passed: bool
    message: str = ""


def check_strategy(strategy: AbstractStrategy) -> tuple[CheckResult, ...]:
    """Run every conformance check that is meant for a strategy of its need, without pytest."""
    return tuple(_result(check, strategy) for check in _checks.checks_for(strategy))


def _result(check, strategy: AbstractStrategy) -> CheckResult:
    name = check.__name__.replace("_", " ")
    try:
        check(strategy)
    except Exception as error:  # whatever a bad strategy raises is its failure, not the kit's
        return CheckResult(name, False, str(error) or repr(error))
    return CheckResult(name, True)


class StrategyConformance:
    """Inherit, give `strategy`, and pytest runs every check that is meant for a strategy of its need::

    class TestMine(StrategyConformance):
        strategy = Mine()
    """

    strategy: ClassVar[AbstractStrategy]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        for check in _checks.checks_for(cls.strategy):
            setattr(cls, f"test_{check.__name__}", _as_test(check))


def _as_test(check):
    def test(self) -> None:
        check(self.strategy)

    test.__doc__ = check.__doc__
    return test
