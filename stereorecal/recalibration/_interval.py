"""An estimate with its 95 % interval."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float]:
        """Plain data for JSON."""
        return asdict(self)

    @property
    def farthest(self) -> float:
        """The largest magnitude within the interval."""
        return max(abs(self.low), abs(self.high))
