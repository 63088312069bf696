"""The field's table in a terminal, from the plain data of its JSON."""

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report.number_text import number

Row = Mapping[str, Any]


def field_tables(data: Mapping[str, Any]) -> Group:
    """A table for each judge, and what was skipped or failed."""
    parts: list[Any] = []
    for panel in dict.fromkeys(map(panel_of, data["summary"])):
        rows = [row for row in data["summary"] if panel_of(row) == panel]
        table = Table(
            title=f"{panel}: {data.get('judges', {}).get(rows[0]['judge'], '')}",
            title_justify="left",
            box=box.SIMPLE_HEAD,
        )
        table.add_column("method", no_wrap=True)
        for head in ("epipolar px", "10 B %", "30 B %", "covered", "harmful", "kept", "refused", "s", "MiB"):
            table.add_column(head, justify="right", no_wrap=True)
        for row in rows:
            table.add_row(row["method"], *cells(row))
        parts.append(table)
    matcher = data["settings"]["matcher"]
    parts.append(Text(f"matcher {matcher['name']} of {matcher.get('origin', 'an unknown version')}"))
    parts += [
        Text(f"{method}, {status} {times}x: {message}") for (method, status, message), times in troubles(data).items()
    ]
    return Group(*parts)


def panel_of(row: Row) -> str:
    """What a row is compared under: its judge, and whether it began with calibrations as they are stored."""
    return f"{row['judge']}, as stored" if row["start"] == "stored" else row["judge"]


def cells(row: Row) -> list[str]:
    """The cells of one row of the summary, in the order of the columns."""
    return [
        before_and_after(row["row_error_px"], 2),
        *(before_and_after(depth_at(row, at), 1) for at in ("10", "30")),
        f"{row['covered']} of {row['stated']}" if row["stated"] else "-",
        f"{row['harmful']} of {row['trials']}" if row["trials"] else "-",
        f"{row['good']}",
        f"{row['refused'] + row['failed']}",
        number(row["seconds"], 1),
        number(row["memory_mib"], 0),
    ]


def before_and_after(values: Mapping[str, float | None] | None, digits: int) -> str:
    """Such as "3.73, 0.05"; what is infinite, None in JSON, is said as such."""
    if values is None:
        return "-"
    return ", ".join("∞" if values[when] is None else number(values[when], digits) for when in ("start", "final"))


def depth_at(row: Row, at: str) -> dict[str, float | None] | None:
    """The errors of depth in a row, before and after, at a distance; None where the judge tells none."""
    depths = row["depth_error_percent"]
    return None if depths is None else {when: depths[when][at] for when in ("start", "final")}


def troubles(data: Mapping[str, Any]) -> dict[tuple[str, str, str], int]:
    """Number of trials that were skipped or failed, by method, status and message."""
    found: dict[tuple[str, str, str], int] = {}
    for row in data["trials"]:
        if row["status"] in ("skipped", "failed"):
            key = row["method"], row["status"], row["message"]
            found[key] = found.get(key, 0) + 1
    return found
