"""Lists that a reader can take in at a glance."""

from collections.abc import Sequence

MOST = 6


def short_list(names: Sequence[str], separator: str = ", ") -> str:
    """All of them, or, of more than `MOST`, the first and how many more there are."""
    if len(names) <= MOST:
        return separator.join(names)
    return separator.join([*names[: MOST - 1], f"{len(names) - MOST + 1} more"])
