"""A strategy that does as the machine of a test has it: works, fails, or is interrupted."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from stereorecal.strategies import AbstractStrategy, Outcome, Status


@dataclass(frozen=True)
class Moody(AbstractStrategy):
    """Stays where it starts, unless it is in a mood."""

    runs: ClassVar[list[int]] = []
    mood: ClassVar[Callable[[int], None]] = lambda run: None

    def run(self, objective, start, seed):
        self.runs.append(seed)
        type(self).mood(len(self.runs))
        objective.value(start)
        return Outcome(start, Status.STALLED)
