"""Conformance kits for authors of plug-ins: strategies and matchers."""

from stereorecal.testing._checks import CheckResult as CheckResult
from stereorecal.testing._kit import (
    MatcherConformance as MatcherConformance,
    StrategyConformance as StrategyConformance,
    check_matcher as check_matcher,
    check_strategy as check_strategy,
)
