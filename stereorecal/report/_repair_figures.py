"""Figures of the page of a repair, as SVG; each fits a telephone."""

from collections import Counter
from collections.abc import Sequence

import cv2
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, SymLogNorm
from matplotlib.figure import Figure
from matplotlib.scale import SymmetricalLogTransform

from stereorecal.report._regions import GRID, LIMIT
from stereorecal.report.number_text import percent
from stereorecal.report.repair_report import Rows
from stereorecal.report.svg import COLOURS, style, svg

_WIDTH = 3.8  # inches
_LEAST_SCALE = 0.5  # pixels: smaller errors look pale
_BACKGROUND = 360  # pixels wide
_TALLEST = 1.5  # height over width
_MOST = 0.95  # of the view: the corners would otherwise fill the scale
OVER = 0.8  # opacity of colours over the image
_EXTENT = (0.0, 1.0, 1.0, 0.0)  # of every map: the whole view
ROW_COLOURS = "RdBu_r"
_TICKS = (LIMIT, 1.0, 10.0, 100.0)  # pixels, on either side of zero
_SMOOTH = 0.9 / np.log(10.0)  # width of the linear part of a logarithmic axis, for a continuous scale

Map = Float[np.ndarray, "h w"]
Grey = Float[np.ndarray, "height width"]


def field_figures(
    rows: Rows, image: Grey, names: tuple[str, str], misaligned: tuple[Sequence[int], Sequence[int]]
) -> list[str]:
    """Maps of epipolar errors over the image, before and after, on one scale, with misaligned places outlined."""
    norm, largest = row_scale(rows)
    found = []
    for name, field, places in zip(names, (rows.field_before, rows.field_after), misaligned, strict=True):
        with style(("field", name, largest, image.shape)):
            figure, axis = _map(field, image, ROW_COLOURS, norm, "row difference [px]", _ticks(largest))
            axis.set_title(name, loc="left")
            axis.add_collection(LineCollection(outline(places), colors="k", linewidths=1.8), autolim=False)
            found.append(svg(figure, f"Map over the view: median row differences of matches, {name}."))
    return found


def row_scale(rows: Rows) -> tuple[SymLogNorm, float]:
    """The scale of the colours of row differences over the view, which holds both maps, and the pixels at its ends."""
    largest = _scale(rows.field_before, rows.field_after)
    return SymLogNorm(LIMIT, vmin=-largest, vmax=largest), largest


def histogram_figure(rows: Rows, names: tuple[str, str]) -> str:
    """The density of the epipolar errors of all matches, before and after; logarithmic far from zero."""
    largest = _scale(rows.all_before, rows.all_after)
    bins = _bins(largest)
    with style(("histogram", largest, rows.all_before.size)):
        figure = Figure(figsize=(_WIDTH, 3.1))
        axis = figure.subplots()
        for name, values, colour in zip(names, (rows.all_before, rows.all_after), COLOURS[1::-1], strict=True):
            label = f"{name}: {percent(float(np.mean(np.abs(values) <= LIMIT)))} within {LIMIT} px"
            axis.stairs(density(values, bins), bins, color=colour, alpha=0.6, fill=True, label=label)
            axis.stairs(density(values, bins), bins, color=colour, lw=1.0)  # visible where it is low
        axis.axvspan(-LIMIT, LIMIT, color=COLOURS[2], alpha=0.2, lw=0.0)
        axis.set_xscale("symlog", linthresh=LIMIT, linscale=_SMOOTH)
        axis.set_xticks(_ticks(largest), [f"{tick:g}" for tick in _ticks(largest)])
        axis.set_xticks([], minor=True)
        axis.set_xlabel("row difference [px]")
        axis.set_ylabel("share of matches per px")
        axis.set_ylim(bottom=0.0)
        figure.legend(loc="outside upper left")
        return svg(figure, f"Histogram of the row differences of all matches, {names[0]} and {names[1]}.")


def density(values: Float[np.ndarray, "m"], bins: Float[np.ndarray, "b1"]) -> Float[np.ndarray, "b"]:
    """The share of the values in each bin, over its width, so that wide bins far from zero make no false peak. Values
    that rounding puts outside are in the outermost bins."""
    counts = np.histogram(values.clip(bins[0], bins[-1]), bins)[0]
    return counts / max(values.size, 1) / np.diff(bins)


def _bins(largest: float) -> Float[np.ndarray, "b1"]:
    """Edges at equal distances on an axis that is linear near zero and logarithmic far from it."""
    scale = SymmetricalLogTransform(10.0, LIMIT, _SMOOTH)
    end = float(scale.transform(np.array([largest]))[0])
    return scale.inverted().transform(np.linspace(-end, end, 61))


def expected_figure(expected: Map, image: Grey) -> str:
    """Map of the epipolar errors to expect over the view."""
    largest = max(_LEAST_SCALE, float(np.nanquantile(expected, _MOST))) if np.isfinite(expected).any() else _LEAST_SCALE
    with style(("expected", largest)):
        label = "epipolar error, 95 % below [px]"
        figure, _ = _map(expected, image, "YlOrBr", Normalize(0.0, largest), label, extend="max")
        return svg(
            figure, "Map over the view: the epipolar error to expect at each place, with the calibration to use."
        )


def _map(
    values: Map,
    image: Grey,
    colours: str,
    norm: Normalize,
    label: str,
    ticks: Sequence[float] | None = None,
    extend: str = "neither",
) -> tuple[Figure, Axes]:
    """A map of values in colours over the grey image, without colour where there is no value."""
    figure = Figure(figsize=(_WIDTH, 0.82 * _WIDTH * _aspect(image) + 0.4))
    axis = figure.subplots()
    height, width = image.shape
    size = min(_BACKGROUND, width), max(1, round(height * min(_BACKGROUND, width) / width))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    axis.imshow(small, cmap="gray", vmin=0, vmax=255, extent=_EXTENT, aspect="auto")
    axis.imshow(values, cmap=colours, norm=norm, alpha=OVER, extent=_EXTENT, aspect="auto")
    axis.set_box_aspect(_aspect(image))
    axis.spines[:].set_visible(True)
    axis.set_xticks([])
    axis.set_yticks([])
    # A colour bar of its own: the map's would be as translucent as the map.
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axis, label=label, fraction=0.05, extend=extend)
    if ticks is not None:
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks], minor=False)
        bar.minorticks_off()
    return figure, axis


def outline(places: Sequence[int]) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """The outline of regions of the view, the edges that no two of them share: (start, end) in shares of width and
    height."""
    edges = Counter()
    for place in places:
        y, x = divmod(place, GRID[0])
        edges.update([((x, y), (x + 1, y)), ((x, y + 1), (x + 1, y + 1))])
        edges.update([((x, y), (x, y + 1)), ((x + 1, y), (x + 1, y + 1))])
    return [
        ((x / GRID[0], y / GRID[1]), (u / GRID[0], v / GRID[1]))
        for ((x, y), (u, v)), number in edges.items()
        if number == 1
    ]


def _aspect(image: Grey) -> float:
    """Height over width of a drawing: very tall views are squeezed."""
    return min(image.shape[0] / image.shape[1], _TALLEST)


def _scale(*values: Float[np.ndarray, "..."]) -> float:
    """The limit, in pixels, of a scale for all epipolar errors before and after."""
    return max(float(np.nanmax(np.abs(some), initial=_LEAST_SCALE)) for some in values)


def _ticks(largest: float) -> list[float]:
    positive = [tick for tick in _TICKS if tick <= largest]
    return [*(-tick for tick in reversed(positive)), 0.0, *positive]
