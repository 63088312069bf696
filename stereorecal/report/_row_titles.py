"""Who took part in a comparison, in words: what its tables and its page call a row."""

from collections.abc import Mapping
from typing import Any

Row = Mapping[str, Any]


def several_schedules(data: Mapping[str, Any]) -> bool:
    """Whether schedules stand side by side."""
    return len({entrant["schedule"] for entrant in data["settings"]["entrants"]}) > 1


def strategies_of(row: Row) -> str:
    """The strategies that a trial or a summary ran: "compass + optimistix-levenberg-marquardt"."""
    return " + ".join(row["strategies"])


def title_of(row: Row, data: Mapping[str, Any]) -> str:
    """A short name, different for each entrant: its schedule where schedules stand side by side, each with strategies
    of its own, else the requested strategy."""
    return row["schedule"] if several_schedules(data) else row["strategy"]
