"""Curves of a comparison over cost, as SVG, and the legend that they share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from stereorecal.report.svg import style, svg

# Okabe and Ito; lines differ in their dashes too.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_DASHES = ((), (6, 3), (7, 2, 1.5, 2), (1.5, 2))  # lengths of strokes and gaps, in widths of the line

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Line:
    """The look of a curve.

    Attributes:
        name: of the strategy or schedule.
        colour: a CSS colour.
        dashes: lengths of strokes and gaps in widths of the line; empty for a whole line.
    """

    name: str
    colour: str
    dashes: tuple[float, ...]


def lines_of(names: Sequence[str]) -> list[Line]:
    """A line for each name; the first twelve look different."""
    return [
        Line(name, _COLOURS[index % len(_COLOURS)], _DASHES[index % len(_DASHES)]) for index, name in enumerate(names)
    ]


def curve_figures(rows: Sequence[Row], lines: Sequence[Line]) -> list[str]:
    """The best score, the rotation error (medians and quartiles) and the share of solved trials over cost, one
    figure each, without legend.

    Args:
        rows: the curves of a scene.
        lines: their lines.
    """
    panels = [("rotation error [°]", "rotation_error_deg"), ("share of trials solved", "share")]
    if all(row["score"] is not None for row in rows):
        panels.insert(0, ("best score", "score"))
    return [_figure(rows, lines, label, name) for label, name in panels]


def _figure(rows: Sequence[Row], lines: Sequence[Line], label: str, name: str) -> str:
    names = [line.name for line in lines]
    with style(("curves", name, names, [row["scene"] for row in rows])):
        figure = Figure(figsize=(3.7, 2.8), layout="constrained")
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
        axes.spines[["top", "right"]].set_visible(False)
        if name == "share":
            axes.set_ylim(-0.03, 1.03)
        if name == "rotation_error_deg":
            axes.set_ylim(bottom=0.0)
        return svg(figure, f"{label} over the units spent, of {', '.join(names)}.")
