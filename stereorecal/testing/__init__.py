"""Conformance kits for authors of plug-ins."""

from stereorecal.testing._kit import (
    CheckResult as CheckResult,
    StrategyConformance as StrategyConformance,
    check_strategy as check_strategy,
)
