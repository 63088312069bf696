"""Figures of the paper's experiments, from the plain data of `reproduce`. Needs matplotlib."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter

from stereorecal.report.disparity_map import colour_range
from stereorecal_paper._summaries import grouped_by

Row = Mapping[str, Any]
Image = Float[np.ndarray, "h w"]

# Okabe and Ito: told apart by people who see fewer colours.
_COLOURS: tuple[str, ...] = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_INVALID = "#202020"
_UNIT = {"pitch": "pitch [°]", "yaw": "yaw [°]", "roll": "roll [°]", "y": "y [% of B]", "z": "z [% of B]"}
_METHOD = {"count": "count at one scale (the paper's way)", "default": "default schedule"}
_COST = "cost [matcher runs on a full-size frame]"


def experiment_figures(rows: Mapping[str, Sequence[Row]]) -> dict[str, Figure]:
    """A figure for each experiment that has rows, by the name of its file."""
    return {name: make(rows[name]) for name, make in _FIGURES.items() if rows.get(name)}


def disparity_figure(left: Image, disparities: Mapping[str, tuple[Image, Bool[np.ndarray, "h w"]]]) -> Figure:
    """The left image and disparities (values, valid) under several calibrations, on one scale (paper, section 4.4)."""
    _, largest = colour_range(disparities.values())
    columns = (len(disparities) + 2) // 2
    height, width = left.shape
    figure = Figure(figsize=(3.6 * columns + 0.8, 7.2 * height / width + 0.4), layout="constrained")
    axes = figure.subplots(2, columns, squeeze=False).ravel()
    axes[0].imshow(left, cmap="gray", vmin=0, vmax=255)
    axes[0].set_title("left image", fontsize=9, loc="left")
    image = None
    for axis, (name, (values, found)) in zip(axes[1:], disparities.items(), strict=False):
        axis.set_facecolor(_INVALID)
        image = axis.imshow(np.ma.masked_where(~found, values), cmap="viridis", vmin=0.0, vmax=largest)
        axis.set_title(f"{name}: {100 * found.mean():.0f} % of the pixels", fontsize=9, loc="left")
    for axis in axes:
        axis.set_xticks([])
        axis.set_yticks([])
    for axis in axes[1 + len(disparities) :]:
        axis.set_visible(False)
    if image is not None:
        figure.colorbar(image, ax=list(axes), label="disparity [px]", fraction=0.03)
    return figure


def _validity(rows: Sequence[Row]) -> Figure:
    """The counts of every pair under every calibration; a diamond at the highest (paper, figure 4)."""
    groups = grouped_by(rows, "sequence")
    figure, axes = _axes_grid(len(groups), 3.4, 2.6)
    for axis, (sequence, group) in zip(axes, groups.items(), strict=False):
        names = list(group[0]["counts"])
        for index, row in enumerate(group):
            counts = np.array(list(row["counts"].values())) / 1e3
            style = {"color": _COLOURS[index % len(_COLOURS)], "linewidth": 0.8}
            axis.plot(counts, linestyle=":" if row["starred"] else "-", **style)
            axis.plot(np.argmax(counts), counts.max(), marker="D", markersize=5, color=style["color"])
        axis.axvspan(names.index(group[0]["own"]) - 0.4, names.index(group[0]["own"]) + 0.4, color="0.9", zorder=0)
        axis.set_xticks(range(len(names)), names, rotation=90, fontsize=6)
        axis.set_title(sequence, fontsize=9, loc="left")
        axis.set_ylim(bottom=0)
        axis.set_ylabel("valid pixels [10³]", fontsize=8)
    for line, label in (("-", "a pair"), (":", "starred: little to match")):
        axes[0].plot([], [], color="0.4", label=label, linestyle=line)
    axes[0].plot([], [], color="0.4", marker="D", linestyle="none", label="its highest count")
    axes[0].legend(fontsize=6, frameon=False)
    figure.supxlabel("manual calibration (grey: that of the sequence)", fontsize=8)
    return figure


def _sweeps(rows: Sequence[Row]) -> Figure:
    """The count along each axis, for each matcher, relative to its peak."""
    axes_names = list(dict.fromkeys(row["axis"] for row in rows))
    matchers = list(dict.fromkeys(row["matcher"] for row in rows))
    figure, axes = _axes_grid(len(axes_names), 3.0, 2.4, most=len(axes_names))
    for axis, name in zip(axes, axes_names, strict=True):
        for row in [row for row in rows if row["axis"] == name]:
            colour = _COLOURS[matchers.index(row["matcher"])]
            counts = np.array(row["counts"], float)
            axis.plot(row["offsets"], counts / max(counts.max(), 1), color=colour, linewidth=1.0)
        axis.axvline(0.0, color="0.6", linewidth=0.7, zorder=0)
        axis.set_xlabel(f"offset of {_UNIT[name]}", fontsize=8)
        axis.set_ylim(0.0, 1.05)
    axes[0].set_ylabel("count, relative to its peak", fontsize=8)
    _legend(axes[-1], matchers)
    return figure


def _generalise(rows: Sequence[Row]) -> Figure:
    """r of every other pair of the sequence, before (hollow) and after (filled), for each start (paper, figure 5)."""
    methods = grouped_by(rows, "schedule")
    starts = list(dict.fromkeys(row["calibration"] for row in rows))
    figure, axes = _axes_grid(len(methods), 4.6, 3.0, most=len(methods))
    for axis, (method, group) in zip(axes, methods.items(), strict=True):
        for row in group:
            others = {name: c for name, c in row["others"].items() if c["score_reference"]}
            colour = _COLOURS[starts.index(row["calibration"]) % len(_COLOURS)]
            place = np.arange(len(others)) + 0.12 * (starts.index(row["calibration"]) - 0.5 * (len(starts) - 1))
            for when, face in (("score_initial", "none"), ("score_final", colour)):
                ratios = [c[when] / c["score_reference"] for c in others.values()]
                axis.plot(place, ratios, "o", markersize=4, markeredgecolor=colour, markerfacecolor=face)
            axis.set_xticks(range(len(others)), [name.rpartition(".")[0] for name in others], fontsize=7)
        axis.axhline(1.0, color="0.6", linewidth=0.7, zorder=0)
        axis.set_ylim(0.0, 1.15)
        axis.set_title(_title(method), fontsize=9, loc="left")
        axis.set_xlabel("pair of the sequence (hollow: before)", fontsize=8)
    axes[0].set_ylabel("r = N / N_GT", fontsize=8)
    _legend(axes[-1], [f"from {name}" for name in starts])
    return figure


def _ex_nihilo(rows: Sequence[Row]) -> Figure:
    """Score and squared error against cost, for every pair without a star (paper, figures 6 and 8)."""
    methods = grouped_by([row for row in rows if not row["starred"]] or rows, "schedule")
    figure = Figure(figsize=(4.6 * len(methods), 6.4), layout="constrained")
    axes = figure.subplots(3, len(methods), squeeze=False, sharex="col", sharey="row")
    pairs = dict.fromkeys(_pair_key(row) for group in methods.values() for row in group)
    colours = {pair: _COLOURS[index % len(_COLOURS)] for index, pair in enumerate(pairs)}
    labels = ("r = N / N_GT", "squared error of\nrotation [°²]", "squared error of\ntranslation [(% of B)²]")
    for column, (method, group) in enumerate(methods.items()):
        for row in group:
            way, style = row["way"], {"color": colours[_pair_key(row)], "linewidth": 0.9}
            cost = [point["cost"] for point in way]
            reference = max(row["score_reference"], 1)
            axes[0, column].step(cost, [p["count"] / reference for p in way], where="post", **style)
            axes[1, column].step(cost, [p["rotation2"] for p in way], where="post", **style)
            axes[2, column].step(cost, [p["translation2"] for p in way], where="post", **style)
        axes[0, column].axhline(1.0, color="black", linewidth=0.8)
        axes[0, column].set_title(_title(method), fontsize=9, loc="left")
        axes[-1, column].set_xlabel(_COST, fontsize=8)
    lines = [Line2D([], [], color=colour, label=f"{sequence} {name}") for (sequence, name), colour in colours.items()]
    _legend_below(figure, [*lines, Line2D([], [], color="black", label="the reference")])
    for row_axes, label in zip(axes, labels, strict=True):
        row_axes[0].set_ylabel(label, fontsize=8)
    for axis in axes[1:].ravel():
        axis.set_yscale("log")
        axis.yaxis.set_minor_formatter(NullFormatter())
    _small_ticks(axes.ravel())
    return figure


def _sequential(rows: Sequence[Row]) -> Figure:
    """r on the current pair, from pair to pair; a line where the next pair begins, grey where it is starred (paper,
    figure 9)."""
    methods = list(dict.fromkeys(row["schedule"] for row in rows))
    orders = list(dict.fromkeys(row["order"] for row in rows))
    figure = Figure(figsize=(4.8 * len(methods), 1.9 * len(orders) + 0.4), layout="constrained")
    axes = figure.subplots(len(orders), len(methods), squeeze=False, sharey=True)
    for row in rows:
        axis = axes[orders.index(row["order"]), methods.index(row["schedule"])]
        spent = 0.0
        for step in row["steps"]:
            reference = max(step["score_reference"], 1)
            ends = [{"cost": 0.0, "count": step["score_initial"]}, {"cost": step["cost"], "count": step["score_final"]}]
            way = [*step["way"], ends[1]] if step["way"] else ends
            cost, ratios = [spent + p["cost"] for p in way], [p["count"] / reference for p in way]
            axis.step(cost, ratios, where="post", color="#D55E00", linewidth=1.0)
            axis.axvline(spent, color="0.4", linewidth=0.6)
            if step["starred"]:
                axis.axvspan(spent, spent + step["cost"], color="0.9", zorder=0)
            spent += step["cost"]
        axis.axhline(1.0, color="0.6", linewidth=0.7, zorder=0)
        axis.set_title(f"{row['order']}; {_title(row['schedule'])}", fontsize=8, loc="left")
        axis.set_ylim(bottom=0.0)
    for axis in axes[-1]:
        axis.set_xlabel(_COST, fontsize=8)
    for axis in axes[:, 0]:
        axis.set_ylabel("r on this pair", fontsize=8)
    current = Line2D([], [], color="#D55E00", label="r = N / N_GT of the current pair")
    then = Line2D([], [], color="0.4", label="the next pair begins")
    _legend_below(figure, [current, then, Patch(color="0.9", label="starred: little to match")])
    _small_ticks(axes.ravel())
    return figure


def _ratios(rows: Sequence[Row]) -> Figure:
    """r of each pair before (hollow) and after (filled), by schedule."""
    pairs = list(dict.fromkeys((row["sequence"], row["image"]) for row in rows))
    methods = list(dict.fromkeys(row["schedule"] for row in rows))
    figure = Figure(figsize=(0.32 * len(pairs) + 2.4, 3.4), layout="constrained")
    axis = figure.subplots()
    for row in rows:
        if not row["score_reference"]:
            continue
        index, colour = methods.index(row["schedule"]), _COLOURS[methods.index(row["schedule"])]
        place = pairs.index((row["sequence"], row["image"])) + 0.2 * (index - 0.5 * (len(methods) - 1))
        for when, face in (("score_initial", "none"), ("score_final", colour)):
            ratio = row[when] / row["score_reference"]
            axis.plot(place, ratio, "o", markersize=4, markeredgecolor=colour, markerfacecolor=face)
    axis.axhline(1.0, color="0.6", linewidth=0.7, zorder=0)
    stars = {(row["sequence"], row["image"]): "*" if row["starred"] else "" for row in rows}
    names = [f"{sequence} {image.rpartition('.')[0]}{stars[sequence, image]}" for sequence, image in pairs]
    axis.set_xticks(range(len(pairs)), names, rotation=90, fontsize=6)
    axis.set_ylabel("r = N / N_GT (hollow: before)", fontsize=8)
    axis.set_ylim(bottom=0.0)
    _legend(axis, methods, marker="o")
    return figure


_FIGURES: dict[str, Callable[[Sequence[Row]], Figure]] = {
    "validity": _validity,
    "sweeps": _sweeps,
    "repair": _ratios,
    "generalise": _generalise,
    "ex_nihilo": _ex_nihilo,
    "sequential": _sequential,
}


def _axes_grid(number: int, width: float, height: float, most: int = 4) -> tuple[Figure, list[Axes]]:
    columns = min(number, most)
    lines = -(-number // columns)
    figure = Figure(figsize=(width * columns, height * lines), layout="constrained")
    axes = list(figure.subplots(lines, columns, squeeze=False).ravel())
    for axis in axes[number:]:
        axis.set_visible(False)
    _small_ticks(axes)
    return figure, axes


def _small_ticks(axes: Iterable[Axes]) -> None:
    for axis in axes:
        axis.tick_params(labelsize=7)


def _legend(axis: Axes, names: Sequence[str], marker: str | None = None) -> None:
    for index, name in enumerate(names):
        line = "none" if marker else "-"
        axis.plot([], [], color=_COLOURS[index % len(_COLOURS)], marker=marker, linestyle=line, label=name)
    axis.legend(fontsize=7, frameon=False)


def _legend_below(figure: Figure, handles: Sequence[Artist]) -> None:
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7, frameon=False)


def _title(schedule: str) -> str:
    return _METHOD.get(schedule, schedule)


def _pair_key(row: Row) -> tuple[str, str]:
    return row["sequence"], row["image"].rpartition(".")[0]
