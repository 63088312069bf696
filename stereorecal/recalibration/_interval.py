"""An estimate with its 95 % interval."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def farthest(self) -> float:
        """The largest magnitude within the interval."""
        return max(abs(self.low), abs(self.high))
