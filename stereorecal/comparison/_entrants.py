"""The entrants of a comparison: strategies in schedules."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError, StrategyError
from stereorecal.recalibration import SCHEDULES, Schedule
from stereorecal.strategies import AbstractStrategy, Objective, Outcome, name_of, strategy

_PAPERS = "compass"  # the paper's best strategy (section 3.3)


@dataclass(frozen=True)
class Entrant:
    """A strategy in a schedule.

    Attributes:
        name: of the strategy.
        schedule: with it in the stages of its kind.
        running: every strategy that the schedule runs, by name, in the order of its stages.
    """

    name: str
    schedule: Schedule
    running: Mapping[str, AbstractStrategy]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables."""
        return {"strategy": self.name, "schedule": self.schedule.name, "strategies": list(self.running)}


def entrants_of(strategies: Any, schedule: Any, scale: float) -> tuple[Entrant, ...]:
    """The entrants that the arguments of `compare` name, those of the default schedule first."""
    named = _by_name(strategies)
    return tuple(
        _entrant(name, plugin, kind, scale, own_strategies=strategies is None)
        for kind in _schedules(schedule, given=strategies is not None)
        for name, plugin in named.items()
    )


def _by_name(strategies: Any) -> Mapping[str, AbstractStrategy]:
    match strategies:
        case None:
            return load_strategies((_PAPERS,))
        case str():
            raise InputError(f"strategies is the text {strategies!r}; give a list of names, such as [{strategies!r}].")
        case AbstractStrategy():
            raise InputError(f"strategies is one strategy; give a mapping, such as {{'mine': {strategies!r}}}.")
        case Mapping():
            return strategies
    for one in strategies:
        if not isinstance(one, str):
            raise InputError(f"strategies is a list with {one!r} in it; give names, or a mapping: {{'mine': {one!r}}}.")
    return load_strategies(strategies)


def _schedules(schedule: Any, *, given: bool) -> Sequence[str]:
    if schedule is None:
        return ("count",) if given else sorted(SCHEDULES, key=lambda name: name != "default")
    if isinstance(schedule, str) and schedule in SCHEDULES:
        return (schedule,)
    if isinstance(schedule, Schedule):
        raise InputError("schedule is an sr.Schedule; give its name (count or default) and the strategies instead.")
    raise InputError(f"unknown schedule {schedule!r}; choose one of: {', '.join(SCHEDULES)}.")


def _entrant(name: str, plugin: AbstractStrategy, kind: str, scale: float, *, own_strategies: bool) -> Entrant:
    """The entrant of a schedule, which with `own_strategies` runs the strategies that it comes with."""
    if kind == "count":
        return Entrant(name, Schedule.count(plugin, scale), {name: plugin})
    schedule = Schedule.default() if own_strategies else Schedule.default().using(plugin)
    used = [stage.strategy for stage in schedule.stages if stage.strategy is not None]
    running = {name if one is plugin else name_of(one): one for one in used}
    return Entrant(name, schedule, running)


@dataclass(frozen=True)
class _Unloadable(AbstractStrategy):
    """A stand-in for a strategy that is installed but broken: its rows are FAILED, and the others run."""

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
