"""Terminal tables of `recalibrate` and `score`, one row for each recording, from the plain data of their JSON."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group
from rich.text import Text

from stereorecal.report._tables import tables_of
from stereorecal.report.number_text import between, distance, number, percent

_AXES = {  # heads of columns
    **{f"{name} °": ("rotation_deg", name) for name in ("pitch", "yaw", "roll")},
    **{f"{name} %": ("translation_percent", name) for name in ("y", "z")},
}
_VERDICT = ("verdict", "matched", "row\nerror\npx", "s")
_SCORE = ("matched", "epipolar\npx", "depth error", "verdict")
_WORDS = ("scene", "depth error", "verdict")
_LEGEND = (
    "matched pixels and median epipolar (row) error: before and after; axes: change and, unless it was rejected, half "
    "width of its 95 % interval, translations in percent of the baseline"
)

Row = Mapping[str, Any]


def repairs_table(repairs: Sequence[Row], width: int) -> Group:
    """One row for each recording: verdict, matched pixels and epipolar error before and after, changes with intervals;
    in two tables where `width` columns hold no more, with words folded until they fit."""
    return Group(*tables_of([_repair(row) for row in repairs], width, _WORDS, parts=(_VERDICT, _AXES)), Text(_LEGEND))


def scores_table(scenes: Sequence[Row], width: int) -> Group:
    """One row for each recording: matched pixels, epipolar error, error of depth, verdict; words are folded until they
    fit into `width` columns."""
    return Group(*tables_of([_score(row) for row in scenes], width, _WORDS))


def _repair(repair: Row) -> dict[str, str]:
    name, cells = {"scene": repair["scene"]}, dict.fromkeys((*_VERDICT, *_AXES), "-")
    if repair["error"] is not None:
        return name | cells | {"verdict": f"failed ({repair['fault']})"}
    shares = (percent(repair[f"score_{when}"]["fraction"]) for when in ("before", "after"))
    rows = repair["row_error_px"]
    errors = "-" if rows is None else "\n".join(number(rows[when], 2) for when in ("before", "after"))
    verdict = (repair["reason"].replace("_", " "), "\n".join(shares), errors, number(repair["seconds"], 1))
    widths = (repair["interval_95"] if repair["healthy"] or repair["accepted"] else None) or {}
    for head, (kind, axis) in _AXES.items():
        known = f"\n±{widths[kind][axis]:.3f}" if axis in widths.get(kind, ()) else ""
        cells[head] = f"{repair['change'][kind][axis]:+.3f}{known}"
    return name | cells | dict(zip(_VERDICT, verdict, strict=True))


def _score(scene: Row) -> dict[str, str]:
    cells = ("-", "-", "-", "cannot be used")
    if scene["error"] is None:
        decision, depth = scene["decision"], "-"
        if depths := scene["depth"]:
            middle = depths[len(depths) // 2]
            ends = (middle["before"]["metres"][end] for end in ("low", "high"))
            error = between(*(math.inf if end is None else end for end in ends))
            depth = f"{error} at {distance(middle['distance_m'])}"
        rows = None if decision is None else decision["rows_px"]["before"]["value"]
        cells = (percent(scene["score_before"]["fraction"]), number(rows, 2), depth, scene["verdict"])
    return {"scene": scene["scene"], **dict(zip(_SCORE, cells, strict=True))}
