"""The schedule: which strategy maximises what, at which image scale, in which order."""

from dataclasses import dataclass

from stereorecal._errors import InputError
from stereorecal.strategies import AbstractStrategy


@dataclass(frozen=True)
class Stage:
    """One stage: a strategy maximises the count at one image scale.

    Attributes:
        strategy: the optimiser.
        scale: image scale, (0, 1].
    """

    strategy: AbstractStrategy
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.scale <= 1.0:
            raise InputError(f"the scale {self.scale} makes no sense; give one within (0, 1].")


@dataclass(frozen=True)
class Schedule:
    """Stages in order; each starts where the one before it ended.

    Attributes:
        name: what tables call it.
        stages: at least one.
    """

    name: str
    stages: tuple[Stage, ...]

    def __post_init__(self) -> None:
        if not self.stages:
            raise InputError("the schedule has no stage; give at least one.")

    @staticmethod
    def count(strategy: AbstractStrategy, scale: float = 1.0) -> "Schedule":
        """The paper's way: one strategy on the count alone, at one image scale."""
        return Schedule("count", (Stage(strategy, scale),))
