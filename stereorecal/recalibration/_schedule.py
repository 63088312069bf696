"""The schedule: which strategy maximises what, at which image scale, in which order."""

import enum
from dataclasses import dataclass, replace
from typing import Any

from stereorecal._errors import InputError
from stereorecal.objectives import Parameters
from stereorecal.strategies import AbstractStrategy, Need, name_of, strategy as named_strategy

SCHEDULES = ("count", "default")
_FINEST = (60_000, 480_000)  # pixels of a frame at which rows are measured at the end
_STEPPING_STONE = (60_000, 120_000)  # the same at half scale


class ScoreKind(enum.Enum):
    """What a stage maximises."""

    COUNT = "the number of pixels with a valid disparity (the paper's score)"
    EPIPOLAR = "minus half the squared epipolar residuals of dense correspondences"


@dataclass(frozen=True)
class Stage:
    """One stage: a strategy maximises one score at one image scale.

    Attributes:
        strategy: the optimiser; None, of an epipolar stage: the fit's own Gauss-Newton.
        scale: image scale, (0, 1].
        score: what is maximised.
        rounds: of an epipolar stage: how often the images are matched again, at most.
        pixels: least and most pixels of a frame: the scale bends to stay between them (but not above 1); None: it
            stays as it is.
        frames: at most so many are looked at, those with the most texture, spread over the recording; None: all.
        rows: share of the rows that a stage on the count counts, (0, 1], see `objective`.
    """

    strategy: AbstractStrategy | None
    scale: float = 1.0
    score: ScoreKind = ScoreKind.COUNT
    rounds: int = 1
    pixels: tuple[int, int] | None = None
    frames: int | None = None
    rows: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.scale <= 1.0:
            raise InputError(f"the scale {self.scale} makes no sense; give one within (0, 1].")

    @property
    def solver(self) -> str:
        """The name of the strategy; "fit" where there is none."""
        return "fit" if self.strategy is None else name_of(self.strategy)

    def scale_for(self, size: tuple[int, int]) -> float:
        """The scale at which images of `size` (width, height) are looked at."""
        if self.pixels is None:
            return self.scale
        lowest, highest = ((bound / (size[0] * size[1])) ** 0.5 for bound in self.pixels)
        return min(1.0, max(lowest, min(self.scale, highest)))


HALF = Stage(None, 0.5, ScoreKind.EPIPOLAR, rounds=2, pixels=_STEPPING_STONE)  # from degrees to a tenth of a pixel


@dataclass(frozen=True)
class Schedule:
    """Stages in order; each starts where the one before it ended.

    Attributes:
        name: what tables call it.
        stages: at least one.
        survey: whether the first stage starts where a coarse survey of the rotation finds more matches than at the
            initial calibration.
    """

    name: str
    stages: tuple[Stage, ...]
    survey: bool = False

    def __post_init__(self) -> None:
        if not self.stages:
            raise InputError("the schedule has no stage; give at least one.")

    @staticmethod
    def count(strategy: AbstractStrategy | str = "compass", scale: float = 1.0) -> "Schedule":
        """The paper's way: one strategy, or the one of that name, on the count alone, at one image scale.

        Raises:
            InputError: if no strategy of that name is installed.
        """
        return Schedule("count", (Stage(as_strategy(strategy), scale),))

    @staticmethod
    def default() -> "Schedule":
        """Coarse to fine: a survey, compass on the count at quarter scale, then matches and fits of their rows at half
        and full scale, until the rig settles. The pixels of a stage are bounded, so that large images cost no more than
        800x600 ones.

        Raises:
            InputError: if compass is not installed; it says the install line.
        """
        # From afar to a pixel of the next stage (at the default reach), on half of the rows: nearer, correspondences
        # know better than the count.
        climb = named_strategy("compass", step=1.0 / 8.0, min_step=1.0 / 16.0)
        coarse = Stage(climb, 0.25, ScoreKind.COUNT, pixels=(16_000, 30_000), frames=2, rows=0.5)
        return Schedule("default", (coarse, *LOOK.stages), survey=True)

    @property
    def on_rows(self) -> tuple[Stage, ...]:
        """The stages on the rows that it ends with."""
        count = [number for number, stage in enumerate(self.stages, 1) if stage.score is ScoreKind.COUNT]
        return self.stages[max(count, default=0) :]

    @property
    def strategies(self) -> tuple[str, ...]:
        """The names of the strategies that it runs, each once."""
        return tuple(dict.fromkeys(name_of(one.strategy) for one in self.stages if one.strategy is not None))

    def using(self, strategy: AbstractStrategy) -> "Schedule":
        """The same schedule with `strategy` in every stage of its kind: one that needs residuals in the epipolar
        stages, any other in those on the count."""
        kind = ScoreKind.EPIPOLAR if strategy.needs is Need.RESIDUALS else ScoreKind.COUNT
        return replace(self, stages=tuple(replace(s, strategy=strategy) if s.score is kind else s for s in self.stages))


# Of a look at the images, which needs no strategy.
LOOK = Schedule(
    "look",
    (replace(HALF, frames=2), Stage(None, 1.0, ScoreKind.EPIPOLAR, rounds=3, pixels=_FINEST)),
    survey=True,
)


def watching_scale(size: tuple[int, int]) -> float:
    """The scale of the last stage but one of the default schedule, for images of `size` (width, height): half, as a
    rule."""
    return HALF.scale_for(size)


def as_schedule(schedule: Any) -> Schedule:
    """The schedule itself, or the one of that name: "default" (also for None), or "count", compass at full scale.
    "count:NAME" and "default:NAME" have the strategy of that name in the stages of its kind.

    Raises:
        InputError: if the name is unknown, it is no schedule, or a strategy of it is not installed.
    """
    schedule = "default" if schedule is None else schedule
    name, colon, solver = schedule.partition(":") if isinstance(schedule, str) else ("", "", "")
    if name == "count":
        return Schedule.count(solver if colon else "compass")
    if name == "default":
        return Schedule.default().using(named_strategy(solver)) if colon else Schedule.default()
    if isinstance(schedule, Schedule):
        return schedule
    if isinstance(schedule, AbstractStrategy):
        raise InputError(f"schedule is the strategy {name_of(schedule)}; give sr.Schedule.count(strategy, scale=1.0).")
    described = repr(schedule) if isinstance(schedule, str) else f"a {type(schedule).__name__}"
    raise InputError(f"unknown schedule {described}; choose one of: {', '.join(SCHEDULES)}, or give an sr.Schedule.")


def as_strategy(strategy: AbstractStrategy | str | None) -> AbstractStrategy:
    """The strategy itself, or the one of that name with its default options.

    Raises:
        InputError: if no strategy of that name is installed.
    """
    if isinstance(strategy, str):
        return named_strategy(strategy)
    if not isinstance(strategy, AbstractStrategy):
        described = f"the class {strategy.__name__}" if isinstance(strategy, type) else f"a {type(strategy).__name__}"
        raise InputError(f"the strategy is {described}; give a name, or make one: sr.strategy('compass', step=0.25).")
    return strategy


def check_schedule(schedule: Schedule, free: Parameters) -> None:
    """Refuse to free what the count cannot see.

    Raises:
        InputError: if a schedule without rows is asked for intrinsics, the baseline or ranges.
    """
    if free.shared and not schedule.on_rows:
        raise InputError(
            "a schedule that ends on the count estimates neither intrinsics nor the length of the baseline; use the "
            "default schedule, or free only the extrinsics."
        )
