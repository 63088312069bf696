"""Pairs that are read when they are used: a recording may be larger than the memory."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, overload

from stereorecal.recordings._pair import Pair

if TYPE_CHECKING:
    PairSequence = Sequence[Pair]
else:
    PairSequence = Sequence  # a run-time type checker would read a pair to check it


class LazyPairs(PairSequence):
    """Pairs that are read each time they are used; a slice is as lazy.

    Attributes:
        names, times: of the pairs, known without reading them; None for a time that is not known.
    """

    def __init__(
        self, reads: Sequence[Callable[[], Pair]], names: Sequence[str], times: Sequence[float | None] | None = None
    ):
        self._reads, self.names = reads, tuple(names)
        self.times = (None,) * len(self.names) if times is None else tuple(times)

    def __len__(self) -> int:
        return len(self._reads)

    @overload
    def __getitem__(self, index: int) -> Pair: ...
    @overload
    def __getitem__(self, index: slice) -> "LazyPairs": ...
    def __getitem__(self, index: int | slice) -> "Pair | LazyPairs":
        if isinstance(index, slice):
            return self.picked(range(len(self))[index])
        return self._reads[index]()

    def picked(self, numbers: Sequence[int]) -> "LazyPairs":
        """Those of these numbers."""
        return LazyPairs(
            [self._reads[number] for number in numbers],
            [self.names[number] for number in numbers],
            [self.times[number] for number in numbers],
        )

    def mapped(self, function: Callable[[Pair], Pair]) -> "LazyPairs":
        """What a function, of a module so that it travels to workers, makes of each pair when it is read."""
        return LazyPairs([partial(_mapped, read, function) for read in self._reads], self.names, self.times)


def _mapped(read: Callable[[], Pair], function: Callable[[Pair], Pair]) -> Pair:
    return function(read())


def names_of(pairs: PairSequence) -> tuple[str, ...]:
    """The names of pairs, without reading them."""
    return pairs.names if isinstance(pairs, LazyPairs) else tuple(pair.name for pair in pairs)


def times_of(pairs: PairSequence) -> tuple[float | None, ...]:
    """When pairs were taken, in seconds, without reading them; None where that is not known."""
    return pairs.times if isinstance(pairs, LazyPairs) else tuple(pair.time for pair in pairs)


def picked(pairs: PairSequence, numbers: Sequence[int]) -> PairSequence:
    """The pairs of these numbers, read or not as they were."""
    return pairs.picked(numbers) if isinstance(pairs, LazyPairs) else tuple(pairs[number] for number in numbers)
