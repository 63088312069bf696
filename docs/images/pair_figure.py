"""The picture of pairs before and after a repair, from plain arrays."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.figure import Figure

from stereorecal.report.disparity_map import colour_range


@dataclass(frozen=True, eq=False)
class Panel:
    """One rectified pair with its disparity.

    Attributes:
        title: heading of the row.
        left, right: (h, w) rectified grey images, 0..255.
        disparity: (h, w) in pixels.
        valid: (h, w) bool, True where the disparity is valid.
    """

    title: str
    left: Float[np.ndarray, "h w"]
    right: Float[np.ndarray, "h w"]
    disparity: Float[np.ndarray, "h w"]
    valid: Bool[np.ndarray, "h w"]


def repair_figure(panels: Sequence[Panel]) -> Figure:
    """One row per panel: a red-cyan overlay of the left and right image, and the disparity on a common colour scale.

    In the overlay of a well rectified pair the red and cyan fringes are displaced horizontally only.
    """
    _, largest = colour_range((panel.disparity, panel.valid) for panel in panels)
    height, width = panels[0].left.shape
    figure = Figure(figsize=(11.0, 5.3 * len(panels) * height / width + 0.5), layout="constrained")
    axes = figure.subplots(len(panels), 2, squeeze=False)
    disparity_image = None
    for (overlay, depth), panel in zip(axes, panels, strict=True):
        overlay.imshow(np.stack([panel.left, panel.right, panel.right], axis=-1).clip(0, 255).astype(np.uint8))
        overlay.set_title(f"{panel.title}: left (red), right (cyan)", fontsize=10, loc="left")
        depth.set_facecolor("#202020")  # where nothing matches
        seen = np.ma.masked_where(~panel.valid, panel.disparity)
        disparity_image = depth.imshow(seen, cmap="viridis", vmin=0.0, vmax=largest)
        share = 100.0 * float(panel.valid.mean())
        depth.set_title(f"{panel.title}: disparity, {share:.0f} % of the pixels valid", fontsize=10, loc="left")
        for axis in (overlay, depth):
            axis.set_xticks([])
            axis.set_yticks([])
    if disparity_image is not None:
        figure.colorbar(disparity_image, ax=axes[:, 1], label="disparity [px]", fraction=0.04)
    return figure


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure to `path`, whose suffix selects the format."""
    figure.savefig(path, dpi=100)
