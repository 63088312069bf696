"""Figures of the page of a comparison, as SVG: curves over cost, and strip plots."""

import textwrap
from collections.abc import Mapping, Sequence
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
_LETTERS, _LEGEND_LETTERS = 20, 36  # of a line of a name, on the axis and in a legend; longer names go on below


def curve_figures(rows: Sequence[Row], names: Sequence[str]) -> list[str]:
    """The best score, the rotation error (medians and quartiles) and the share of solved trials over cost, one figure
    each; a line for each row, of which the first twelve look different."""
    panels = [("rotation error [°]", "rotation_error_deg"), ("share of trials solved", "share")]
    if all(row["score"] is not None for row in rows):
        panels.insert(0, ("best score", "score"))
    return [_figure(rows, names, label, name) for label, name in panels]


def _figure(rows: Sequence[Row], names: Sequence[str], label: str, name: str) -> str:
    titles = [_folded(one, _LEGEND_LETTERS) for one in names]
    with style(("curves", name, names, [row["scene"] for row in rows])):
        figure = Figure(figsize=(3.7, 2.8 + 0.2 * len("\n".join(titles).split("\n"))))
        axes = figure.subplots()
        for index, (row, title) in enumerate(zip(rows, titles, strict=True)):
            values, colour = row[name], _COLOURS[index % len(_COLOURS)]
            if name != "share":
                low, values, high = values
                axes.fill_between(row["cost"], low, high, color=colour, alpha=0.15, linewidth=0)
            (drawn,) = axes.step(row["cost"], values, where="post", color=colour, label=title)
            drawn.set_dashes(_DASHES[index % len(_DASHES)])
        for text in figure.legend(loc="outside lower left").get_texts():
            text.set_parse_math(False)
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
        axes.set_yticks(range(len(names)), [_folded(name, _LETTERS) for name in names], parse_math=False)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel(axis)
        axes.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper center", ncols=len(series), handletextpad=0, columnspacing=1)
        return svg(figure, f"{axis} by {', '.join(names)}")


def _folded(name: str, letters: int) -> str:
    return "\n".join(textwrap.wrap(name, letters)) or name


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
