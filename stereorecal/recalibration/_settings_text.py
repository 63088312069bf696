"""Settings as people read them: with the calibration and the images, all that is needed to repeat a repair."""

from dataclasses import asdict
from typing import Any

from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._schedule import Stage
from stereorecal.recalibration._settings import Settings

_UNLIMITED = "no limit"


def settings_as_text(settings: Settings) -> dict[str, Any]:
    """By name; a disparity range that is to be measured is None."""
    limits = {
        name: _UNLIMITED if limit is None else f"{limit:g}"
        for name, limit in (("units", settings.budget.evaluations), ("seconds", settings.budget.seconds))
    }
    return {
        "free": ", ".join(settings.free.names),
        "matcher": matcher_as_text(settings.matcher),
        "schedule": settings.schedule.name,
        "stage": {str(number): _stage(stage) for number, stage in enumerate(settings.schedule.stages, 1)},
        "budget": limits,
        "seed": settings.seed,
        "tolerances": ", ".join(f"{name} {value}" for name, value in asdict(settings.tolerances).items()),
    }


def matcher_as_text(matcher: AbstractMatcher) -> str:
    """As it can be made again: SAD(num_disparities=96, …); a range that is to be measured is None."""
    return f"{type(matcher).__name__}({_options(matcher)})"


def _stage(stage: Stage) -> str:
    kind = f"{stage.score.name.lower()} at scale {stage.scale:g}"
    others = {"rounds": stage.rounds, "frames": stage.frames, "rows": stage.rows, "pixels": stage.pixels}
    more = ", ".join(f"{name} {value}" for name, value in others.items() if value is not None)
    how = stage.solver if stage.strategy is None else f"{stage.solver}({_options(stage.strategy)})"
    return f"{kind}, {more}, by {how}"


def _options(some: Any) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in asdict(some).items())
