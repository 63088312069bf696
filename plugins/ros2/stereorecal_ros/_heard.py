"""When which input was heard last."""

from collections.abc import Iterable
from dataclasses import dataclass, field


@dataclass
class Heard:
    """Inputs by name.

    Attributes:
        patience: seconds without a message, after which an input is missing.
    """

    patience: float
    _at: dict[str, float] = field(default_factory=dict)

    def note(self, name: str, now: float) -> None:
        """It is heard now."""
        self._at[name] = now

    def missing(self, names: Iterable[str], now: float) -> list[str]:
        """Those of the names that are silent."""
        return [name for name in names if name not in self._at or now - self._at[name] > self.patience]
