"""Conformance kits for authors of plug-ins: strategies and matchers."""

from stereorecal.testing._checks import CheckResult as CheckResult
from stereorecal.testing._matcher_checks import MatcherConformance as MatcherConformance, check_matcher as check_matcher
from stereorecal.testing._strategy_checks import (
    StrategyConformance as StrategyConformance,
    check_strategy as check_strategy,
)
