"""How a repair was asked for: with the calibration and the images, all that is needed to repeat it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from stereorecal.decision import DEFAULT, Tolerances
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._schedule import Schedule, Stage
from stereorecal.strategies import Budget, name_of, origin_of

_UNLIMITED = "no limit"


@dataclass(frozen=True)
class Asked:
    """The settings of a repair, but for its reach and view, which a solution has anyway.

    Attributes:
        matcher: without its disparity range, if that was to be measured.
        schedule, budget, seed: as they were.
        free: names of the parameters that were free, whether or not all of them could be solved for.
        tolerances: by which it was decided.
    """

    matcher: AbstractMatcher
    schedule: Schedule
    budget: Budget
    seed: int
    free: Sequence[str]
    tolerances: Tolerances = DEFAULT

    def as_text(self) -> dict[str, Any]:
        """By name, as people read it."""
        limits = {
            name: _UNLIMITED if limit is None else f"{limit:g}"
            for name, limit in (("units", self.budget.evaluations), ("seconds", self.budget.seconds))
        }
        return {
            "free": ", ".join(self.free),
            "matcher": matcher_as_text(self.matcher),
            "schedule": self.schedule.name,
            "stage": {str(number): _stage(stage) for number, stage in enumerate(self.schedule.stages, 1)},
            "budget": limits,
            "seed": self.seed,
            "tolerances": ", ".join(f"{name} {value}" for name, value in asdict(self.tolerances).items()),
        }

    @property
    def origins(self) -> list[str]:
        """Distributions of the strategies, each with its version."""
        return sorted({origin_of(stage.strategy) for stage in self.schedule.stages})


def matcher_as_text(matcher: AbstractMatcher) -> str:
    """As it can be made again: SAD(num_disparities=96, …); a range that is to be measured is None."""
    return f"{type(matcher).__name__}({_options(matcher)})"


def _stage(stage: Stage) -> str:
    kind = f"{stage.score.name.lower()} at scale {stage.scale:g}"
    others = {"rounds": stage.rounds, "frames": stage.frames, "rows": stage.rows, "pixels": stage.pixels}
    more = ", ".join(f"{name} {value}" for name, value in others.items() if value is not None)
    return f"{kind}, {more}, by {name_of(stage.strategy)}({_options(stage.strategy)})"


def _options(some: Any) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in asdict(some).items())
