"""Settings as a table of names and values."""

from collections.abc import Iterator, Mapping
from typing import Any


def flat(settings: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Nested settings as a flat list of names, such as "matcher block_size", and values."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{above}{key} ")
        else:
            text = "; ".join(map(str, value)) if isinstance(value, list) else "-" if value is None else str(value)
            yield above + key, text
