"""Running a strategy and judging what it nominates."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import BudgetExhausted, NeedNotMet, PluginError, StrategyError
from stereorecal.strategies._contract import AbstractStrategy, Outcome, Status
from stereorecal.strategies._objective import Objective, Trace
from stereorecal.strategies._strategy_registry import name_of, origin_of


@dataclass(frozen=True, eq=False)
class Run:
    """A judged run.

    Attributes:
        best: (n,) the best of the strategy's nomination, the best point recorded, and the start.
        value: the score at `best`.
        start_value: the score at the start.
        status, message: how the run ended.
        trace: every evaluation that the strategy made.
        judging_cost: units spent on judging, beyond the strategy's own evaluations.
    """

    best: Float[np.ndarray, "n"]
    value: float
    start_value: float
    status: Status
    message: str
    trace: Trace
    judging_cost: float


def run_strategy(strategy: AbstractStrategy, objective: Objective, start: Float[np.ndarray, "n"], seed: int = 0) -> Run:
    """Run `strategy` from `start` and judge the point that it nominates by the objective's own values.

    The strategy gets the objective's whole budget, whatever was spent before, and an empty trace. Judging evaluates the
    start and the nomination where the strategy has not; this is not charged to the budget, but counted in
    `Run.judging_cost`.

    Raises:
        NeedNotMet: if the objective does not offer what the strategy needs, or the strategy says so itself.
        StrategyError: if the strategy crashes or nominates no point of the box; the message names its distribution and
            version.
    """
    if reason := _unmet_need(strategy, objective):
        raise NeedNotMet(f"strategy {name_of(strategy)} {reason}.")
    metered = objective.with_budget(objective.budget)
    start = np.array(start, float)
    try:
        outcome = strategy.run(metered, start.copy(), seed)
    except BudgetExhausted:
        outcome = Outcome(start, Status.BUDGET)
    except (PluginError, NeedNotMet):  # as a matcher's, which names it; what a strategy finds missing only now
        raise
    except Exception as error:
        raise StrategyError(f"{_called(strategy)} crashed: {error!r}") from error
    if not isinstance(outcome, Outcome) or not _in_box(outcome.best, start.shape):
        raise StrategyError(f"{_called(strategy)} nominated no point of the unit box: {outcome!r}")
    return _judge(objective, metered.trace, start, outcome)


def _unmet_need(strategy: AbstractStrategy, objective: Objective) -> str | None:
    if missing := objective.missing(strategy.needs):
        return f"cannot serve here: {missing}"
    if objective.dim < strategy.min_dim:
        return f"needs at least {strategy.min_dim} free parameters, not {objective.dim}"
    if strategy.max_dim is not None and objective.dim > strategy.max_dim:
        return f"takes at most {strategy.max_dim} free parameters, not {objective.dim}"
    return None


def _called(strategy: AbstractStrategy) -> str:
    return f"strategy {name_of(strategy)} ({origin_of(strategy)})"


def _in_box(point: Any, shape: tuple[int, ...]) -> bool:
    try:
        point = np.asarray(point, float)
    except (TypeError, ValueError):
        return False
    return point.shape == shape and bool(np.isfinite(point).all()) and bool(np.abs(point).max() <= 1 + 1e-9)


def _judge(objective: Objective, trace: Trace, start: np.ndarray, outcome: Outcome) -> Run:
    # Points that were only charged for have no value yet; the last of them is the best of them.
    charged = trace.points[np.isnan(trace.values)][-1:]
    known = {p.tobytes(): v for p, v in zip(trace.points, trace.values, strict=True) if np.isfinite(v)}
    candidates = [start, *charged, np.array(outcome.best, float)]
    if known:
        candidates.append(trace.points[np.argmax(np.where(np.isfinite(trace.values), trace.values, -np.inf))])
    judged = dict(known)
    for p in candidates:
        if p.tobytes() not in judged:  # one point may be the start, charged and nominated
            judged[p.tobytes()] = float(objective.problem.values(p[None])[0])
    judging_cost = (len(judged) - len(known)) * objective.cost
    values = [judged[p.tobytes()] for p in candidates]
    winner = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))  # the start wins ties
    finite = [value for value in judged.values() if np.isfinite(value)]
    status = Status.NO_SIGNAL if len(finite) > 2 and len(set(finite)) == 1 else outcome.status
    return Run(
        candidates[winner], values[winner], values[0], status, outcome.message or status.value, trace, judging_cost
    )
