"""Curves of a comparison over cost, as SVG."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stereorecal.report._svg import INK, style, svg

# Okabe and Ito; lines differ in their dashes too.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_DASHES = ("-", "--", "-.", ":")

Row = Mapping[str, Any]


def curves_figure(rows: Sequence[Row], names: Sequence[str]) -> str:
    """The best score, the rotation error (medians and quartiles) and the share of solved trials over cost.

    Args:
        rows: the curves of a scene.
        names: of those.
    """
    panels = [("rotation error [°]", "rotation_error_deg"), ("share of trials solved", "share")]
    if all(row["score"] is not None for row in rows):
        panels.insert(0, ("best score", "score"))
    with style(("curves", names, [row["scene"] for row in rows])):
        figure = Figure(figsize=(3.7 * len(panels), 3.0 + 0.24 * ((len(names) + 1) // 2)), layout="constrained")
        for axis, (label, name) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            for index, row in enumerate(rows):
                _draw(axis, row["cost"], row[name], index, names[index])
            axis.set_ylabel(label)
            axis.set_xlabel("units spent")
            axis.spines[["top", "right"]].set_visible(False)
            if name == "share":
                axis.set_ylim(-0.03, 1.03)
            if name == "rotation_error_deg":
                axis.set_ylim(bottom=0.0)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        shown = figure.legend(handles, labels, loc="outside lower center", ncols=min(2, len(names)), frameon=False)
        for text in shown.get_texts():
            text.set_parse_math(False)
            text.set_color(INK)
        return svg(figure, f"Over the units spent: {', '.join(label for label, _ in panels)}, of {', '.join(names)}.")


def _draw(axis: Axes, cost: Sequence[float], values: Sequence, index: int, name: str) -> None:
    look: dict[str, Any] = {
        "color": _COLOURS[index % len(_COLOURS)],
        "linestyle": _DASHES[index % len(_DASHES)],
        "label": name,
    }
    if isinstance(values[0], list):
        low, median, high = values
        axis.fill_between(cost, low, high, color=look["color"], alpha=0.15, linewidth=0)
        axis.step(cost, median, where="post", **look)
    else:
        axis.step(cost, values, where="post", **look)
