"""Strip plots as SVG that takes its text colour from the page around it."""

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

# From the palette of Okabe and Ito, safe for colour-blind readers; contrast of at least 3:1 on white and on black.
_COLOURS = ("#0072b2", "#d55e00", "#009e73")
_MARKERS = ("o", "s", "^")
_INK = "#010203"  # placeholder for the text colour of the page
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.size": 11,
    **dict.fromkeys(("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), _INK),
}
_MOST_POINTS = 30  # of a strip; more are drawn as quartiles and range, so that a page of many trials stays small
_MOST_LETTERS = 20  # of a name on the axis; longer ones are cut


@dataclass(frozen=True)
class Series:
    """Values of one quantity.

    Attributes:
        label: name of the quantity in the legend.
        values: those of each strip.
    """

    label: str
    values: Sequence[Sequence[float]]


def strips(names: Sequence[str], series: Sequence[Series], axis: str, limits: Sequence[float], *, log: bool) -> str:
    """A strip plot as an `<svg>` element: one strip for each name, with up to three series on it and their medians.

    Args:
        names: of the strips, from the top; any text, never read as a formula.
        series: what is plotted, each with as many lists of values as there are names.
        axis: label of the axis of values.
        limits: values marked by dotted lines.
        log: logarithmic axis; all values must then be positive.
    """
    step = 0.8 / len(series)
    height = 0.75 + 0.26 * (len(series) > 1) + len(names) * (0.18 + 0.16 * len(series))
    with rc_context({**_STYLE, "svg.hashsalt": repr((names, series, axis))}):  # ids unique on the page
        figure = Figure(figsize=(4.4, height), layout="constrained")
        axes = figure.subplots()
        if log:
            axes.set_xscale("log")
        else:
            axes.locator_params(axis="x", nbins=5)
        for limit in limits:
            axes.axvline(limit, color=_INK, linestyle=":", linewidth=1)
        for index, one in enumerate(series):
            for row, values in enumerate(one.values):
                _strip(axes, values, row + step * (index - (len(series) - 1) / 2), index)
            axes.plot([], [], _MARKERS[index], color=_COLOURS[index], label=one.label)
        axes.set_yticks(range(len(names)), [_short(name) for name in names], parse_math=False)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel(axis)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
        if len(series) > 1:
            figure.legend(
                loc="outside upper center", ncols=len(series), frameon=False, handletextpad=0, columnspacing=1
            )
        return _svg(figure)


def _strip(axes: Axes, values: Sequence[float], y: float, index: int) -> None:
    colour, marker = _COLOURS[index], _MARKERS[index]
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


def _short(name: str) -> str:
    return name if len(name) <= _MOST_LETTERS else name[: _MOST_LETTERS - 1] + "…"


def _svg(figure: Figure) -> str:
    file = io.StringIO()
    figure.savefig(file, format="svg", transparent=True, metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = file.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r' id="[a-z0-9]+(\.[a-z0-9]+)*_\d+"', "", text)  # "axes_1": not unique on a page
    return re.sub(f"(fill|stroke): {_INK}", r"\1: currentColor", text)
