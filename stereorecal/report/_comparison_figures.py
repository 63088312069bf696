"""Figures of the page of a comparison, as SVG: curves over cost with the legend that they share, and strip plots."""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stereorecal.report.svg import COLOURS, INK, MARKERS, style, svg

_COLOURS = (*COLOURS, "#cc79a7", "#e69f00", "#56b4e9")  # of the same palette; lines differ in their dashes too
_DASHES = ((), (6, 3), (7, 2, 1.5, 2), (1.5, 2))  # lengths of strokes and gaps, in widths of the line

Row = Mapping[str, Any]
Strips = Sequence[Sequence[float]]  # the values in each strip

_MOST_POINTS = 30  # of a strip; more are drawn as quartiles and range, so that a page of many trials stays small
_LETTERS = 20  # of a line of a name on the axis; longer names go on below


@dataclass(frozen=True)
class Line:
    """The look of a curve: its name, its colour in CSS, and lengths of strokes and gaps in widths of the line."""

    name: str
    colour: str
    dashes: tuple[float, ...]


def lines_of(names: Sequence[str]) -> list[Line]:
    """A line for each name; the first twelve look different."""
    return [
        Line(name, _COLOURS[index % len(_COLOURS)], _DASHES[index % len(_DASHES)]) for index, name in enumerate(names)
    ]


def curve_figures(rows: Sequence[Row], lines: Sequence[Line]) -> list[str]:
    """The best score, the rotation error (medians and quartiles) and the share of solved trials over cost, one figure
    each, without legend; a row for each line."""
    panels = [("rotation error [°]", "rotation_error_deg"), ("share of trials solved", "share")]
    if all(row["score"] is not None for row in rows):
        panels.insert(0, ("best score", "score"))
    return [_figure(rows, lines, label, name) for label, name in panels]


def _figure(rows: Sequence[Row], lines: Sequence[Line], label: str, name: str) -> str:
    names = [line.name for line in lines]
    with style(("curves", name, names, [row["scene"] for row in rows])):
        figure = Figure(figsize=(3.7, 2.8))
        axes = figure.subplots()
        for row, line in zip(rows, lines, strict=True):
            values = row[name]
            if name != "share":
                low, values, high = values
                axes.fill_between(row["cost"], low, high, color=line.colour, alpha=0.15, linewidth=0)
            (drawn,) = axes.step(row["cost"], values, where="post", color=line.colour)
            drawn.set_dashes(line.dashes)
        axes.set_ylabel(label)
        axes.set_xlabel("units spent")
        axes.set_xlim(left=0.0)
        if name == "share":
            axes.set_ylim(-0.03, 1.03)
        if name == "rotation_error_deg":
            axes.set_ylim(bottom=0.0)
        return svg(figure, f"{label} over the units spent, of {', '.join(names)}.")


def strips(
    names: Sequence[str], series: Mapping[str, Strips], axis: str, limits: Sequence[float], *, log: bool, tall: int = 1
) -> str:
    """A strip plot as an `<svg>` element: one strip for each name, from the top, with up to three series on it, by
    their names in the legend, and their medians. Limits are dotted lines; `tall`: series for which there is room, as in
    the panels beside it."""
    step = 0.8 / len(series)
    height = 1.01 + len(names) * (0.18 + 0.16 * max(tall, len(series)))
    with style((names, series, axis)):
        figure = Figure(figsize=(4.4, height))
        axes = figure.subplots()
        if log:
            axes.set_xscale("log")
        else:
            axes.locator_params(axis="x", nbins=5)
        for limit in limits:
            axes.axvline(limit, color=INK, linestyle=":", linewidth=1)
        for index, (label, of_strips) in enumerate(series.items()):
            for row, values in enumerate(of_strips):
                _strip(axes, values, row + step * (index - (len(series) - 1) / 2), index)
            axes.plot([], [], MARKERS[index], color=COLOURS[index], label=label)
        folded = ["\n".join(textwrap.wrap(name, _LETTERS)) or name for name in names]
        axes.set_yticks(range(len(names)), folded, parse_math=False)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel(axis)
        axes.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper center", ncols=len(series), handletextpad=0, columnspacing=1)
        return svg(figure, f"{axis} by {', '.join(names)}")


def _strip(axes: Axes, values: Sequence[float], y: float, index: int) -> None:
    colour, marker = COLOURS[index], MARKERS[index]
    if len(values) <= 1:
        axes.plot(values, [y] * len(values), marker, color=colour)
        return
    least, low, median, high, largest = np.quantile(values, (0, 0.25, 0.5, 0.75, 1))
    if len(values) > _MOST_POINTS:
        axes.plot([least, largest], [y, y], color=colour, linewidth=1)
        axes.plot([low, high], [y, y], color=colour, linewidth=6, alpha=0.5, solid_capstyle="butt")
    else:
        axes.plot(values, [y] * len(values), marker, color=colour, alpha=0.5, markersize=5, mew=0)
    axes.plot([median], [y], "|", color=colour, markersize=11, markeredgewidth=2)
