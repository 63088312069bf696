"""Strategies: the contract of a plug-in, objectives and budgets, the registry, and how a strategy is run and judged."""

import sys
from types import ModuleType

from stereorecal._errors import (
    BudgetExhausted as BudgetExhausted,
    NeedNotMet as NeedNotMet,
    StrategyError as StrategyError,
)
from stereorecal.strategies._contract import AbstractStrategy as AbstractStrategy, Outcome as Outcome, Status as Status
from stereorecal.strategies._objective import (
    Budget as Budget,
    Need as Need,
    Objective as Objective,
    Problem as Problem,
    Trace as Trace,
    Traced as Traced,
    as_budget as as_budget,
)
from stereorecal.strategies._run_strategy import Run as Run, run_strategy as run_strategy
from stereorecal.strategies._strategy_registry import (
    check_installed as check_installed,
    describe as describe,
    name_of as name_of,
    origin_of as origin_of,
    overview as overview,
    strategies as strategies,
    strategy as strategy,
)


class _Callable(ModuleType):
    """`sr.strategies` is this package and the function of that name in one, so it can be called."""

    def __call__(self) -> tuple[str, ...]:
        return strategies()


sys.modules[__name__].__class__ = _Callable
