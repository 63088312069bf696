"""Figures of the field's table: error against seconds, coverage, harm."""

import string
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from scipy.special import betaincinv

from stereorecal.report.svg import COLOURS, INK, style, svg
from stereorecal_field.table._field_tables import panel_of

Row = Mapping[str, Any]
_ACROSS = 3  # panels beside each other
_LEAST_PX, _LEAST_PERCENT = 0.01, 0.05  # of logarithmic axes, which have no zero
_DECADE = 4.0  # half of what an axis spans at least
_MOST = 100.0  # percent: what is infinite is drawn here
_KINDS = {
    "harmful": COLOURS[1],
    "accepted, not harmful": COLOURS[2],
    "nothing wrong": COLOURS[0],
    "refused or failed": "#999999",
}


def letters_of(data: Mapping[str, Any]) -> dict[str, str]:
    """What methods are called in the figures."""
    names = [method["name"] for method in data["methods"]]
    return dict(zip(names, (string.ascii_uppercase + string.ascii_lowercase), strict=False))


def error_against_seconds(data: Mapping[str, Any]) -> str:
    """A panel for each judge: |depth error| at 30 baselines, or rows where the judge tells no depth, over seconds."""
    letters = letters_of(data)
    judges = list(dict.fromkeys(map(panel_of, data["summary"])))
    down = -(-len(judges) // _ACROSS)
    with style(("seconds", judges)):
        figure = Figure(figsize=(10.5, 3.1 * down))
        panels = figure.subplots(down, _ACROSS, squeeze=False).ravel()
        for axes in panels[len(judges) :]:
            axes.set_visible(False)
        for axes, judge in zip(panels, judges, strict=False):
            _scatter(axes, judge, [row for row in data["summary"] if panel_of(row) == judge], letters)
        return svg(figure, f"error against seconds, a panel for each judge: {', '.join(judges)}")


def _scatter(axes: Axes, judge: str, rows: Sequence[Row], letters: Mapping[str, str]) -> None:
    depth = any(row["depth_error_percent"] for row in rows)
    axes.set(xscale="log", yscale="log", title=judge, xlabel="seconds")
    axes.set_ylabel("|depth error| at 30 B [%]" if depth else "epipolar error [px]")
    for row in rows:
        if row["seconds"] is None:
            continue
        if depth:
            error = row["depth_error_percent"]["final"]["30"]
            error = np.clip(_MOST if error is None else error, _LEAST_PERCENT, _MOST)
        else:
            error = max(row["row_error_px"]["final"] or _LEAST_PX, _LEAST_PX)
        harm = row["harmful"] / max(row["trials"], 1)
        colour = COLOURS[1] if harm > 0 else COLOURS[0]
        axes.plot([row["seconds"]], [error], "s" if harm > 0 else "o", color=colour, markersize=5)
        axes.annotate(letters[row["method"]], (row["seconds"], error), xytext=(4, 3), textcoords="offset points")
    starts = [row for row in rows if row["seconds"] is not None]
    if starts:
        before = starts[0]["depth_error_percent"]["start"]["30"] if depth else starts[0]["row_error_px"]["start"]
        axes.axhline(_MOST if before is None else before, color=INK, linestyle=":", linewidth=1)
    axes.margins(0.15)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        middle = np.sqrt(low * high)  # a decade at least, so that there are ticks
        axis.axes.set(**{f"{axis.axis_name}lim": (min(low, middle / _DECADE), max(high, middle * _DECADE))})
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def coverage(data: Mapping[str, Any]) -> str | None:
    """The share of stated 95 % intervals that hold the truth, with its own interval; None if no method states any."""
    found = _summed(data, "covered", "stated")
    found = {name: (held, of) for name, (held, of) in found.items() if of}
    if not found:
        return None
    with style(("coverage", list(found))):
        figure = Figure(figsize=(5.2, 1.1 + 0.42 * len(found)))
        axes = figure.subplots()
        for place, (held, of) in enumerate(found.values()):
            low, high = _binomial(held, of)
            axes.plot([low, high], [place, place], color=COLOURS[0], linewidth=2)
            axes.plot([held / of], [place], "o", color=COLOURS[0])
        axes.axvline(0.95, color=INK, linestyle=":", linewidth=1)
        axes.set_yticks(range(len(found)), [f"{name} ({held} of {of})" for name, (held, of) in found.items()])
        axes.set(ylim=(len(found) - 0.5, -0.5), xlim=(0, 1.02), xlabel="share of stated intervals that hold the truth")
        return svg(figure, "coverage of stated intervals, by method")


def harm(data: Mapping[str, Any]) -> str:
    """What came of all trials of a method: harmful, accepted, kept, refused."""
    names = [method["name"] for method in data["methods"]]
    rows = {name: [row for row in data["summary"] if row["method"] == name] for name in names}
    counts = {name: _kinds(some) for name, some in rows.items() if sum(row["trials"] for row in some)}
    with style(("harm", names)):
        figure = Figure(figsize=(7.2, 1.5 + 0.36 * len(counts)))
        axes = figure.subplots()
        for place, numbers in enumerate(counts.values()):
            left = 0.0
            for value, (label, colour) in zip(numbers, _KINDS.items(), strict=True):
                share = value / sum(numbers)
                axes.barh(place, share, left=left, color=colour, label=label if place == 0 else None)
                if value:
                    axes.text(left + share / 2, place, str(value), ha="center", va="center", fontsize=9, color="white")
                left += share
        axes.set_yticks(range(len(counts)), list(counts))
        axes.set(ylim=(len(counts) - 0.5, -0.5), xlim=(0, 1), xlabel="share of the trials")
        figure.legend(loc="outside upper center", ncols=2)
        return svg(figure, "outcomes of all trials, by method: harmful, accepted, kept, refused")


def _kinds(rows: Sequence[Row]) -> list[int]:
    total = {name: sum(row[name] for row in rows) for name in ("harmful", "accepted", "good", "refused", "failed")}
    return [total["harmful"], total["accepted"] - total["harmful"], total["good"], total["refused"] + total["failed"]]


def _summed(data: Mapping[str, Any], part: str, whole: str) -> dict[str, tuple[int, int]]:
    names = [method["name"] for method in data["methods"]]
    rows = {name: [row for row in data["summary"] if row["method"] == name] for name in names}
    return {name: (sum(row[part] for row in some), sum(row[whole] for row in some)) for name, some in rows.items()}


def _binomial(held: int, of: int) -> tuple[float, float]:
    """The 95 % interval of Clopper and Pearson."""
    low = float(betaincinv(held, of - held + 1, 0.025)) if held else 0.0
    high = float(betaincinv(held + 1, of - held, 0.975)) if held < of else 1.0
    return low, high
