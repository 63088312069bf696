"""Strip plots as SVG."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stereorecal.report.svg import COLOURS, INK, MARKERS, style, svg

_MOST_POINTS = 30  # of a strip; more are drawn as quartiles and range, so that a page of many trials stays small
_LETTERS = 20  # of a line of a name on the axis; longer names go on below


@dataclass(frozen=True)
class Series:
    """Values of one quantity.

    Attributes:
        label: name of the quantity in the legend.
        values: those of each strip.
    """

    label: str
    values: Sequence[Sequence[float]]


def strips(
    names: Sequence[str], series: Sequence[Series], axis: str, limits: Sequence[float], *, log: bool, tall: int = 1
) -> str:
    """A strip plot as an `<svg>` element: one strip for each name, with up to three series on it and their medians.

    Args:
        names: of the strips, from the top; any text, never read as a formula.
        series: what is plotted, each with as many lists of values as there are names.
        axis: label of the axis of values.
        limits: values marked by dotted lines.
        log: logarithmic axis; all values must then be positive.
        tall: series for which there is room, as in the panels beside it.
    """
    step = 0.8 / len(series)
    height = 1.01 + len(names) * (0.18 + 0.16 * max(tall, len(series)))
    with style((names, series, axis)):
        figure = Figure(figsize=(4.4, height), layout="constrained")
        axes = figure.subplots()
        if log:
            axes.set_xscale("log")
        else:
            axes.locator_params(axis="x", nbins=5)
        for limit in limits:
            axes.axvline(limit, color=INK, linestyle=":", linewidth=1)
        for index, one in enumerate(series):
            for row, values in enumerate(one.values):
                _strip(axes, values, row + step * (index - (len(series) - 1) / 2), index)
            axes.plot([], [], MARKERS[index], color=COLOURS[index], label=one.label)
        axes.set_yticks(range(len(names)), [_lines(name) for name in names], parse_math=False)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel(axis)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper center", ncols=len(series), frameon=False, handletextpad=0, columnspacing=1)
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


def _lines(name: str) -> str:
    return "\n".join(textwrap.wrap(name, _LETTERS)) or name
