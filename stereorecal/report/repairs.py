"""Terminal tables of `recalibrate` and `score`, one row for each recording, from the plain data of their JSON."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report.cells import change, number, percent

_AXES = {"rotation_deg": ("pitch", "yaw", "roll"), "translation_percent": ("y", "z")}

_LEGEND = (
    "matched pixels and median epipolar (row) error: before and after; axes: change and, unless it was rejected, half "
    "width of its 95 % interval, translations in percent of the baseline"
)


def repairs_table(repairs: Sequence[Mapping[str, Any]]) -> Group:
    """One row for each recording: verdict, matched pixels and row error before and after, changes with intervals."""
    axes = [f"{name} {'°' if kind == 'rotation_deg' else '%'}" for kind, names in _AXES.items() for name in names]
    table = _table(("scene", "verdict"), ("matched", "row\nerror\npx", *axes, "s"))
    for repair in repairs:
        cells = [repair["scene"], *(_found(repair) if repair["error"] is None else [f"failed ({repair['fault']})"])]
        table.add_row(*map(Text, cells))
    return Group(table, Text(_LEGEND))


def scores_table(scenes: Sequence[Mapping[str, Any]]) -> Table:
    """One row for each recording: matched pixels, row error, yaw to mend, error of depth, verdict."""
    table = _table(("scene",), ("matched", "row error px", "yaw to mend °", "depth at 30 B"), ("verdict",))
    for scene in scenes:
        if scene["error"] is not None:
            table.add_row(*map(Text, (scene["scene"], "-", "-", "-", "-", "cannot be used")))
            continue
        rows, verdict, mending = number(scene["row_error_px"], 2), scene["verdict"], scene["mending"]
        yaw = depth = "-"
        if mending is not None:
            turn, error = mending["rotation_deg"]["yaw"], scene["depth_error_percent"]["30"]["value"]
            yaw = f"{turn['value']:+z.2f} ± {turn['high'] - turn['value']:.2f}"
            depth = change(float("inf") if error is None else error, "far")
        cells = (scene["scene"], percent(scene["fraction"]), rows, yaw, depth, verdict)
        table.add_row(*map(Text, cells))
    return table


def _table(words: Sequence[str], numbers: Sequence[str], last: Sequence[str] = ()) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in (*words, *numbers, *last):
        if heading in numbers:
            table.add_column(heading, justify="right", no_wrap=True)
        else:
            table.add_column(heading, overflow="fold")
    return table


def _found(repair: Mapping[str, Any]) -> list[str]:
    rows, widths = repair["row_error_px"], repair["interval_95"] if repair["healthy"] else None
    changes = [
        f"{repair['change'][kind][name]:+.3f}"
        + (f"\n±{widths[kind][name]:.3f}" if widths and name in widths[kind] else "")
        for kind, names in _AXES.items()
        for name in names
    ]
    return [
        repair["reason"].replace("_", " "),
        "\n".join(percent(repair[f"score_{when}"]["fraction"]) for when in ("before", "after")),
        "-" if rows is None else "\n".join(number(rows[when], 2) for when in ("before", "after")),
        *changes,
        number(repair["seconds"], 1),
    ]
