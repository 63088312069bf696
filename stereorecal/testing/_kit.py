"""The conformance kits, each as a function and as a pytest class to inherit from."""

from typing import ClassVar

from stereorecal.matching import AbstractMatcher
from stereorecal.strategies import AbstractStrategy
from stereorecal.testing._checks import CheckResult
from stereorecal.testing._matcher_checks import MATCHER_CHECKS
from stereorecal.testing._strategy_checks import STRATEGY_CHECKS


def check_strategy(strategy: AbstractStrategy) -> tuple[CheckResult, ...]:
    """Run the conformance checks that apply to the strategy, without pytest; one result for each check."""
    return STRATEGY_CHECKS.run(strategy)


def check_matcher(matcher: AbstractMatcher) -> tuple[CheckResult, ...]:
    """Run the conformance checks that apply to the matcher, without pytest; one result for each check.

    The kit sets the disparity range: it replaces `min_disparity` and `num_disparities`.
    """
    return MATCHER_CHECKS.run(matcher)


class StrategyConformance:
    """Inherit from it and set `strategy`; pytest then runs every check that applies as a test:
    `class TestMine(StrategyConformance): strategy = Mine()`.
    """

    strategy: ClassVar[AbstractStrategy]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        STRATEGY_CHECKS.add_tests(cls, cls.strategy)


class MatcherConformance:
    """Inherit from it and set `matcher`; pytest then runs every check that applies as a test:
    `class TestMine(MatcherConformance): matcher = Mine()`.
    """

    matcher: ClassVar[AbstractMatcher]

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        MATCHER_CHECKS.add_tests(cls, cls.matcher)
