"""Pairs that need not fit into memory."""

from collections.abc import Callable, Sequence
from typing import overload

from stereorecal.recordings import Pair


class LazyPairs(Sequence):  # of Pair; said so, a checker of types would read one to look at it
    """Pairs that are read each time they are asked for; a slice is as lazy."""

    def __init__(self, reads: Sequence[Callable[[], Pair]]):
        self._reads = reads

    def __len__(self) -> int:
        return len(self._reads)

    @overload
    def __getitem__(self, index: int) -> Pair: ...
    @overload
    def __getitem__(self, index: slice) -> "LazyPairs": ...
    def __getitem__(self, index: int | slice) -> "Pair | LazyPairs":
        return LazyPairs(self._reads[index]) if isinstance(index, slice) else self._reads[index]()
