"""The figures of a page about a repair, as SVG."""

from collections.abc import Sequence

import cv2
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stereorecal.report._svg import COLOURS, style, svg
from stereorecal.report.repair import Climb, Rows

_WIDTH = 7.6  # inches, of two panels side by side
_LEAST_SCALE = 0.5  # pixels: smaller rows look pale, as they are
_BACKGROUND = 360  # pixels wide
_TALLEST = 1.5  # height over width

Map = Float[np.ndarray, "h w"]
Grey = Float[np.ndarray, "height width"]


def field_figure(rows: Rows, image: Grey, after: str) -> str:
    """Row differences over the view, before and after on one scale, over the image."""
    fields = {"before": rows.field_before, after: rows.field_after}
    largest = _scale(rows)
    with style(("field", largest, image.shape)):
        figure, panels = _side_by_side(image)
        shown = None
        for axis, (title, field) in zip(panels, fields.items(), strict=True):
            _background(axis, image)
            shown = axis.imshow(
                np.ma.masked_invalid(field),
                cmap="coolwarm",
                vmin=-largest,
                vmax=largest,
                alpha=0.75,
                extent=_EXTENT,
                aspect="auto",
            )
            axis.set_title(title, loc="left")
        if shown is not None:
            figure.colorbar(shown, ax=panels, label="row difference [px]", fraction=0.03, extend="both")
        return svg(figure, "Maps over the view: median row differences of matches before and after the repair.")


def histogram_figure(rows: Rows, after: str) -> str:
    """How often matches lie how many rows apart, before and after."""
    largest = 2.0 * _scale(rows)
    bins = np.linspace(-largest, largest, 61).tolist()
    with style(("histogram", largest, rows.all_before.size)):
        figure = Figure(figsize=(_WIDTH / 2, 2.6), layout="constrained")
        axis = figure.subplots()
        for name, values, colour in (
            ("before", rows.all_before, COLOURS[1]),
            (after, rows.all_after, COLOURS[0]),
        ):
            axis.hist(values.clip(-largest, largest), bins, color=colour, alpha=0.6, label=name)
        axis.set_xlabel("row difference [px]")
        axis.set_ylabel("matches")
        axis.spines[["top", "right"]].set_visible(False)
        axis.legend(frameon=False)
        return svg(figure, "Histogram of the row differences of all matches, before and after the repair.")


def expected_figure(expected: Map, image: Grey) -> str:
    """Row errors to expect over the view."""
    largest = max(_LEAST_SCALE, float(np.nanmax(expected, initial=0.0)))
    with style(("expected", largest)):
        figure = Figure(figsize=(_WIDTH / 2, _height(image) + 0.3), layout="constrained")
        axis = figure.subplots()
        _background(axis, image)
        shown = axis.imshow(
            np.ma.masked_invalid(expected),
            cmap="magma_r",
            vmin=0,
            vmax=largest,
            alpha=0.7,
            extent=_EXTENT,
            aspect="auto",
        )
        figure.colorbar(shown, ax=axis, label="row error, 95 % below [px]", fraction=0.04)
        return svg(figure, "Map over the view: row errors to expect of the candidate.")


def progress_figure(climbs: Sequence[Climb], way: Climb | None) -> str | None:
    """Scores, and the row error, over cost; None if there is nothing to draw."""
    curves = [climb for climb in [*climbs, way] if climb is not None and len(climb.cost) > 0]
    if not curves:
        return None
    with style(("progress", [curve.label for curve in curves])):
        figure = Figure(figsize=(_WIDTH / 2 * len(curves), 2.5), layout="constrained")
        for axis, curve in zip(figure.subplots(1, len(curves), squeeze=False)[0], curves, strict=True):
            axis.step(curve.cost, curve.best, where="post", color=COLOURS[0])
            axis.plot(curve.cost[-1], curve.best[-1], "o", color=COLOURS[0])
            axis.set_ylabel(curve.label)
            axis.set_xlabel("units spent")
            axis.spines[["top", "right"]].set_visible(False)
            if curve is way:
                axis.set_ylim(bottom=0.0)
        return svg(figure, f"Over the units spent: {', '.join(curve.label for curve in curves)}.")


_EXTENT = (0.0, 1.0, 1.0, 0.0)  # of every map: the whole view


def _side_by_side(image: Grey) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(_WIDTH, _height(image) + 0.4), layout="constrained")
    return figure, list(figure.subplots(1, 2))


def _height(image: Grey) -> float:
    return 0.44 * _WIDTH * _aspect(image)


def _aspect(image: Grey) -> float:
    """Height over width, of what is drawn: very tall views are squeezed, lest the page grows."""
    return min(image.shape[0] / image.shape[1], _TALLEST)


def _background(axis: Axes, image: Grey) -> None:
    """The image in pale grey, and no ticks."""
    height, width = image.shape
    size = min(_BACKGROUND, width), max(1, round(height * min(_BACKGROUND, width) / width))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    axis.imshow(small, cmap="gray", vmin=0, vmax=255, extent=_EXTENT, aspect="auto")
    axis.set_box_aspect(_aspect(image))
    axis.set_xticks([])
    axis.set_yticks([])


def _scale(rows: Rows) -> float:
    """Pixels at the ends of the colours, before and after: what is left after the repair must be seen."""
    left = np.abs(rows.all_after)
    return max(_LEAST_SCALE, float(np.quantile(left, 0.98))) if left.size else _LEAST_SCALE
