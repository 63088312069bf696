"""Which two images belong together, by the stamps of their headers."""

from dataclasses import dataclass, replace
from typing import Any, TypeVar

MOST = 5  # images of a side that wait for their partner
_BACK = 1_000_000_000  # nanoseconds: images may overtake each other by less; by more, time has jumped back
LEFT, RIGHT = 0, 1
SIDES = ("left", "right")

_T = TypeVar("_T")


@dataclass(frozen=True)
class Frame:
    """An image that waits.

    Attributes:
        stamp: nanoseconds.
        item: the message.
    """

    stamp: int
    item: Any


Frames = tuple[Frame, ...]


@dataclass(frozen=True)
class Pairing:
    """What waits, and what became of what came. Never changed: an image makes another one.

    Attributes:
        tolerance: nanoseconds by which two stamps of a pair may differ; less than half of the time between images.
        waiting: of the left and the right side, the oldest first; at most MOST each.
        newest: the newest stamp of each side.
        paired: pairs so far.
        unpaired: images that were given up without a partner.
        late: images that came after a newer one of their side, or twice.
        jumps: how often time has jumped back.
        apart: nanoseconds to the nearest image of the other side, of the last that found no partner.
    """

    tolerance: int
    waiting: tuple[Frames, Frames] = ((), ())
    newest: tuple[int | None, int | None] = (None, None)
    paired: int = 0
    unpaired: int = 0
    late: int = 0
    jumps: int = 0
    apart: int | None = None

    def with_image(self, side: int, stamp: int, item: Any) -> tuple["Pairing", tuple[Any, Any] | None]:
        """With one more image: LEFT or RIGHT, its stamp in nanoseconds; and the pair that it completes, if it does."""
        newest = self.newest[side]
        if newest is not None and stamp <= newest:
            if newest - stamp < _BACK:
                return replace(self, late=self.late + 1), None
            given_up = sum(map(len, self.waiting))
            empty = replace(self, waiting=((), ()), newest=(None, None))
            again = replace(empty, jumps=self.jumps + 1, unpaired=self.unpaired + given_up)
            return again.with_image(side, stamp, item)
        new = replace(self, newest=_with(self.newest, side, stamp))
        others = self.waiting[1 - side]
        nearest = min(others, key=lambda frame: abs(frame.stamp - stamp), default=None)
        if nearest is not None and abs(nearest.stamp - stamp) <= self.tolerance:
            return new._matched(side, Frame(stamp, item), nearest)
        apart = self.apart if nearest is None else abs(nearest.stamp - stamp)
        own = (*self.waiting[side], Frame(stamp, item))
        given_up = max(len(own) - MOST, 0)
        waiting = _with(self.waiting, side, own[given_up:])
        return replace(new, waiting=waiting, unpaired=self.unpaired + given_up, apart=apart), None

    def _matched(self, side: int, frame: Frame, other: Frame) -> tuple["Pairing", tuple[Any, Any]]:
        """All that is older than a pair has no partner any more, since the images of a side come in order."""
        newer = tuple(one for one in self.waiting[1 - side] if one.stamp > other.stamp)
        given_up = len(self.waiting[side]) + len(self.waiting[1 - side]) - len(newer) - 1
        waiting = _with(_with(self.waiting, side, ()), 1 - side, newer)
        items = (frame.item, other.item) if side == LEFT else (other.item, frame.item)
        return replace(self, waiting=waiting, paired=self.paired + 1, unpaired=self.unpaired + given_up), items


def _with(both: tuple[_T, _T], side: int, value: _T) -> tuple[_T, _T]:
    """The two with another one on a side."""
    return (value, both[1]) if side == LEFT else (both[0], value)
