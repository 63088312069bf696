"""Terminal tables of `recalibrate` and `score`, one row for each recording, from the plain data of their JSON."""

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from stereorecal.report._table_width import first_that_fits, width_of
from stereorecal.report.number_text import between, distance, number, percent

_AXES = {"rotation_deg": ("pitch", "yaw", "roll"), "translation_percent": ("y", "z")}
# Characters of a line of a name and of other words, from the widest layout to the narrowest.
_FOLDS = ((60, 60), (30, 30), (24, 16), (18, 12), (14, 10), (12, 8), (8, 6))

_LEGEND = (
    "matched pixels and median epipolar (row) error: before and after; axes: change and, unless it was rejected, half "
    "width of its 95 % interval, translations in percent of the baseline"
)

Rows = Sequence[Mapping[str, Any]]


def repairs_table(repairs: Rows, width: int) -> Group:
    """One row for each recording: verdict, matched pixels and row error before and after, changes with intervals; in
    two tables where `width` columns hold no more, with words folded until they fit."""

    def fitted(*parts: "_Part") -> Sequence[Table]:
        layouts = _FOLDS[:3] if len(parts) > 1 else _FOLDS
        return first_that_fits([partial(_repairs_table, repairs, parts, folds) for folds in layouts], width)

    tables = fitted(_VERDICTS, _CHANGES)
    if any(width_of(table) > width for table in tables):
        tables = [*fitted(_VERDICTS), *fitted(_CHANGES)]
    return Group(*tables, Text(_LEGEND))


def _repairs_table(repairs: Rows, parts: Sequence["_Part"], folds: tuple[int, int]) -> list[Table]:
    words = [head for part in parts for head in part.words]
    table = _table(("scene", *words), [head for part in parts for head in part.numbers])
    for repair in repairs:
        cells = [_wrapped_name(repair["scene"], folds[0])]
        for part in parts:
            cells += part.cells(repair, folds[1])
        table.add_row(*map(Text, cells))
    return [table]


def scores_table(scenes: Rows, width: int) -> Table:
    """One row for each recording: matched pixels, epipolar error, error of depth, verdict; words are folded until they
    fit into `width` columns."""
    [table] = first_that_fits([partial(_scores_table, scenes, folds) for folds in _FOLDS], width)
    return table


def _scores_table(scenes: Rows, folds: tuple[int, int]) -> list[Table]:
    heads = [_folded(head, folds[1]) for head in ("matched", "epipolar px", "depth error")]
    table = _table(("scene",), heads, ("verdict",))
    for scene in scenes:
        name = _wrapped_name(scene["scene"], folds[0])
        found = ("-", "-", "-", "cannot be used") if scene["error"] is not None else _score(scene)
        table.add_row(*map(Text, (name, *(_folded(cell, folds[1]) for cell in found))))
    return [table]


def _score(scene: Mapping[str, Any]) -> tuple[str, ...]:
    decision, depth = scene["decision"], "-"
    if depths := scene["depth"]:
        middle = depths[len(depths) // 2]
        ends = (middle["before"]["metres"][end] for end in ("low", "high"))
        error = between(*(math.inf if end is None else end for end in ends))
        depth = f"{error} at {distance(middle['distance_m'])}"
    rows = None if decision is None else decision["rows_px"]["before"]["value"]
    return percent(scene["score_before"]["fraction"]), number(rows, 2), depth, scene["verdict"]


def _folded(text: str, letters: int) -> str:
    """The text in lines of so many letters or, where a word is longer, of that."""
    whole = text.replace("± ", "±\u00a0")  # stays on one line
    return "\n".join(textwrap.wrap(whole, letters, break_long_words=False)).replace("\u00a0", " ")


def _wrapped_name(name: str, letters: int) -> str:
    """The name in lines of so many letters."""
    return "\n".join(textwrap.wrap(name, letters))


def _table(words: Sequence[str], numbers: Sequence[str], last: Sequence[str] = ()) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for heading in (*words, *numbers, *last):
        table.add_column(heading, justify="right" if heading in numbers else "left", no_wrap=True)
    return table


def _verdict(repair: Mapping[str, Any], letters: int) -> list[str]:
    if repair["error"] is not None:
        return [_folded(f"failed ({repair['fault']})", letters), *["-"] * len(_VERDICTS.numbers)]
    rows = repair["row_error_px"]
    return [
        _folded(repair["reason"].replace("_", " "), letters),
        "\n".join(percent(repair[f"score_{when}"]["fraction"]) for when in ("before", "after")),
        "-" if rows is None else "\n".join(number(rows[when], 2) for when in ("before", "after")),
        number(repair["seconds"], 1),
    ]


def _change(repair: Mapping[str, Any], letters: int) -> list[str]:
    if repair["error"] is not None:
        return ["-"] * len(_CHANGES.numbers)
    widths = repair["interval_95"] if repair["healthy"] or repair["accepted"] else None
    return [
        f"{repair['change'][kind][name]:+.3f}"
        + (f"\n±{widths[kind][name]:.3f}" if widths and name in widths[kind] else "")
        for kind, names in _AXES.items()
        for name in names
    ]


@dataclass(frozen=True)
class _Part:
    """Columns that stay together.

    Attributes:
        words, numbers: heads of columns that are aligned left, and right.
        cells: of a repair, with words in lines of so many letters.
    """

    words: Sequence[str]
    numbers: Sequence[str]
    cells: Callable[[Mapping[str, Any], int], list[str]]


_VERDICTS = _Part(("verdict",), ("matched", "row\nerror\npx", "s"), _verdict)
_CHANGES = _Part(
    (), [f"{name} {'°' if kind == 'rotation_deg' else '%'}" for kind, names in _AXES.items() for name in names], _change
)
