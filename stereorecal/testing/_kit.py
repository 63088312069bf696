"""The conformance kits in their two library forms: a function, and a pytest class to inherit from."""

from typing import ClassVar

from stereorecal.matching import AbstractMatcher
from stereorecal.strategies import AbstractStrategy
from stereorecal.testing._checks import checks_for
from stereorecal.testing._matcher_checks import matcher_checks_for
from stereorecal.testing._report import CheckResult, add_tests, run_checks


def check_strategy(strategy: AbstractStrategy) -> tuple[CheckResult, ...]:
    """Run every conformance check that is meant for a strategy of its need, without pytest."""
    return run_checks(checks_for(strategy), strategy)


def check_matcher(matcher: AbstractMatcher) -> tuple[CheckResult, ...]:
    """Run every conformance check that is meant for a matcher of its kind, without pytest.

    The range is the kit's own: `min_disparity` and `num_disparities` are replaced.
    """
    return run_checks(matcher_checks_for(matcher), matcher)


class StrategyConformance:
    """Inherit, give `strategy`, and pytest runs every check that is meant for a strategy of its need::

    class TestMine(StrategyConformance):
        strategy = Mine()
    """

    strategy: ClassVar[AbstractStrategy]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        add_tests(cls, checks_for(cls.strategy), cls.strategy)


class MatcherConformance:
    """Inherit, give `matcher`, and pytest runs every check that is meant for a matcher of its kind::

    class TestMine(MatcherConformance):
        matcher = Mine()
    """

    matcher: ClassVar[AbstractMatcher]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        add_tests(cls, matcher_checks_for(cls.matcher), cls.matcher)
