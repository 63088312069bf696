"""Who takes part in a comparison: a strategy in a schedule."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError, StrategyError
from stereorecal.recalibration import SCHEDULES, Schedule
from stereorecal.strategies import AbstractStrategy, Objective, Outcome, name_of, strategy

_CLIMBER = "compass"  # the strategy of the paper


@dataclass(frozen=True)
class Entrant:
    """A strategy in a schedule.

    Attributes:
        name: of the strategy that was asked for.
        schedule: with it in the stages of its kind.
        running: every strategy that the schedule runs, by name.
    """

    name: str
    schedule: Schedule
    running: Mapping[str, AbstractStrategy]


def entrants_of(
    strategies: Sequence[str] | Mapping[str, AbstractStrategy] | None, schedule: str | None, scale: float
) -> tuple[Entrant, ...]:
    """The entrants that the arguments of `compare` ask for.

    Raises:
        InputError: if a name is unknown.
    """
    if schedule is None:
        schedules = SCHEDULES if strategies is None else ("count",)
    elif schedule in SCHEDULES:
        schedules = (schedule,)
    else:
        raise InputError(f"unknown schedule {schedule!r}; choose one of: {', '.join(SCHEDULES)}.")
    if isinstance(strategies, str):
        raise InputError(f"strategies is the text {strategies!r}; give a list of names, such as [{strategies!r}].")
    named = strategies if isinstance(strategies, Mapping) else load_strategies(strategies or (_CLIMBER,))
    return tuple(
        _entrant(name, plugin, kind, scale, kept=strategies is None)
        for kind in schedules
        for name, plugin in named.items()
    )


def _entrant(name: str, plugin: AbstractStrategy, kind: str, scale: float, *, kept: bool) -> Entrant:
    """The entrant of a schedule; a schedule that is `kept` runs the strategies that it comes with."""
    if kind == "count":
        return Entrant(name, Schedule.count(plugin, scale), {name: plugin})
    schedule = Schedule.default() if kept else Schedule.default().using(plugin)
    running = {name if s.strategy is plugin else name_of(s.strategy): s.strategy for s in schedule.stages}
    return Entrant(name, schedule, running)


@dataclass(frozen=True)
class _Unloadable(AbstractStrategy):
    """Stands for a strategy that is installed but broken, so that its rows are FAILED and the others live."""

    message: str = ""

    def run(self, objective: Objective, start: Float[np.ndarray, "n"], seed: int) -> Outcome:
        raise StrategyError(self.message)


def load_strategies(names: Sequence[str]) -> dict[str, AbstractStrategy]:
    """The strategies of these names with their default options. One that is installed but broken fails when it runs.

    Raises:
        InputError: if a name is unknown.
    """
    return {name: _load(name) for name in names}


def _load(name: str) -> AbstractStrategy:
    try:
        return strategy(name)
    except StrategyError as error:
        return _Unloadable(str(error))
