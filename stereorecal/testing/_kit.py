"""The conformance kit in its two library forms: a function, and a pytest class to inherit from."""

from dataclasses import dataclass

from stereorecal.strategies import AbstractStrategy
from stereorecal.testing import _checks


@dataclass(frozen=True)
class CheckResult:
    """One check: its name, whether it passed, and if not, why."""

    name: str
    passed: bool
    message: str = ""


def check_strategy(strategy: AbstractStrategy) -> tuple[CheckResult, ...]:
    """Run every conformance check on a strategy, without pytest."""
    return tuple(_result(check, strategy) for check in _checks.CHECKS)


def _result(check, strategy: AbstractStrategy) -> CheckResult:
    name = check.__name__.replace("_", " ")
    try:
        check(strategy)
    except Exception as error:  # whatever a bad strategy raises is its failure, not the kit's
        return CheckResult(name, False, str(error) or repr(error))
    return CheckResult(name, True)


class StrategyConformance:
    """Inherit, give `strategy`, and pytest runs every check::

    class TestMine(StrategyConformance):
        strategy = Mine()
    """

    strategy: AbstractStrategy


def _as_test(check):
    def test(self) -> None:
        check(self.strategy)

    test.__doc__ = check.__doc__
    return test


for _check in _checks.CHECKS:
    setattr(StrategyConformance, f"test_{_check.__name__}", _as_test(_check))
