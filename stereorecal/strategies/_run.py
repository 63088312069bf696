"""Running a strategy, and judging what it brings back."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._errors import BudgetExhausted, NeedNotMet, StrategyError
from stereorecal.strategies._budget import Budget, Trace
from stereorecal.strategies._contract import AbstractStrategy, Outcome, Status
from stereorecal.strategies._objective import Objective, require
from stereorecal.strategies._registry import origin_of


@dataclass(frozen=True, eq=False)
class Run:
    """A judged run.

    Attributes:
        best: (n,) the best of the strategy's nomination, the best point recorded, and the start.
        value: the score there.
        start_value: the score at the start.
        status, message: how the run ended.
        trace: every evaluation that the strategy made.
    """

    best: Float[np.ndarray, "n"]
    value: float
    start_value: float
    status: Status
    message: str
    trace: Trace


def run_strategy(
    strategy: AbstractStrategy,
    objective: Objective,
    start: Float[np.ndarray, "n"],
    budget: Budget | None = None,
    seed: int = 0,
) -> Run:
    """Run `strategy` on a freshly metered `objective` and judge its nomination by the objective's own values.

    The judge's evaluations (start and nomination, where the strategy did not evaluate them) are not charged.

    Raises:
        NeedNotMet: if the objective does not offer what the strategy needs.
        StrategyError: if the strategy crashes; names its distribution and version.
    """
    name = type(strategy).__name__
    require(objective, strategy.needs, name)
    if objective.dim < strategy.min_dim:
        raise NeedNotMet(f"strategy {name} needs at least {strategy.min_dim} free parameters, not {objective.dim}.")
    if strategy.max_dim is not None and objective.dim > strategy.max_dim:
        raise NeedNotMet(f"strategy {name} takes at most {strategy.max_dim} free parameters, not {objective.dim}.")
    budget = Budget() if budget is None else budget
    metered = objective.with_budget(budget)
    start = np.array(start, float)
    try:
        outcome = strategy.run(metered, start.copy(), budget, seed)
    except BudgetExhausted:
        outcome = Outcome(start, Status.BUDGET)
    except StrategyError:
        raise
    except Exception as error:
        raise StrategyError(f"strategy {name} ({origin_of(strategy)}) crashed: {error!r}") from error
    if not isinstance(outcome, Outcome) or not _in_box(outcome.best, start.shape):
        raise StrategyError(f"strategy {name} ({origin_of(strategy)}) nominated no point of the unit box: {outcome!r}")
    return _judge(objective, metered.trace, start, outcome)


def _in_box(point: object, shape: tuple[int, ...]) -> bool:
    try:
        point = np.asarray(point, float)
    except (TypeError, ValueError):
        return False
    return point.shape == shape and bool(np.isfinite(point).all()) and bool(np.abs(point).max() <= 1 + 1e-9)


def _judge(objective: Objective, trace: Trace, start: np.ndarray, outcome: Outcome) -> Run:
    nominated = np.array(outcome.best, float)
    # Points whose values are only charged are unknown; the last one is the best of that kind.
    charged = trace.points[np.isnan(trace.values)][-1:]
    known = {p.tobytes(): v for p, v in zip(trace.points, trace.values, strict=True) if np.isfinite(v)}
    candidates = [start, *charged, nominated]
    if known:
        candidates.append(trace.points[np.nanargmax(trace.values)])
    judged = dict(known)
    for p in candidates:
        if p.tobytes() not in judged:  # a point may be nominated and charged, or be the start
            judged[p.tobytes()] = float(objective.problem.values(p[None])[0])
    values = [judged[p.tobytes()] for p in candidates]
    winner = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))  # the start wins ties
    seen = {point: value for point, value in judged.items() if np.isfinite(value)}
    status = Status.NO_SIGNAL if len(seen) > 2 and len(set(seen.values())) == 1 else outcome.status
    return Run(candidates[winner], values[winner], values[0], status, outcome.message or status.value, trace)
