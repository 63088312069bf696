"""A strategy and a matcher that do as the machine of a test has it: work, fail, or are interrupted; and a strategy that
always fails."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from stereorecal.matching import BM
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


@dataclass(frozen=True)
class Crashing(AbstractStrategy):
    """Has a bug; what must not run inherits from it."""

    def run(self, objective, start, seed):
        raise KeyError("a bug")


@dataclass(frozen=True)
class MoodyMatcher(BM):
    """Matches as BM does, unless it is in a mood."""

    searches: ClassVar[list[tuple[int, int]]] = []
    mood: ClassVar[Callable[[int], None]] = lambda search: None

    def search(self, left, right):
        self.searches.append(left.shape)
        type(self).mood(len(self.searches))
        return super().search(left, right)
