"""Figures, from plain arrays. Needs matplotlib: pip install 'stereorecal[figures]'."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.figure import Figure

_INVALID = "#202020"


@dataclass(frozen=True, eq=False)
class Panel:
    """One rectified pair with its disparity.

    Attributes:
        title: what stands above.
        left, right: (h, w) rectified grey images, 0..255.
        disparity: (h, w) in pixels.
        valid: (h, w), where the disparity is.
    """

    title: str
    left: Float[np.ndarray, "h w"]
    right: Float[np.ndarray, "h w"]
    disparity: Float[np.ndarray, "h w"]
    valid: Bool[np.ndarray, "h w"]


def repair_figure(panels: Sequence[Panel]) -> Figure:
    """One row a panel: left over right image in red and cyan, and the disparity, all on one scale.

    In the overlay a well rectified pair shows red and cyan fringes side by side only, never above each other.
    """
    # The scale is that of the fullest panel: false matches of a bad calibration spread over the whole range.
    fullest = max(panels, key=lambda panel: int(panel.valid.sum()))
    largest = float(np.quantile(fullest.disparity[fullest.valid], 0.99)) if fullest.valid.any() else 1.0
    height, width = panels[0].left.shape
    figure = Figure(figsize=(11.0, 5.3 * len(panels) * height / width + 0.5), layout="constrained")
    axes = figure.subplots(len(panels), 2, squeeze=False)
    shown = None
    for (overlay, depth), panel in zip(axes, panels, strict=True):
        overlay.imshow(np.stack([panel.left, panel.right, panel.right], axis=-1).clip(0, 255).astype(np.uint8))
        overlay.set_title(f"{panel.title}: left (red) over right (cyan)", fontsize=10, loc="left")
        depth.set_facecolor(_INVALID)
        masked = np.ma.masked_where(~panel.valid, panel.disparity)
        shown = depth.imshow(masked, cmap="viridis", vmin=0.0, vmax=largest)
        share = 100.0 * float(panel.valid.mean())
        depth.set_title(f"{panel.title}: disparity on {share:.0f} % of the pixels", fontsize=10, loc="left")
        for axis in (overlay, depth):
            axis.set_xticks([])
            axis.set_yticks([])
    if shown is not None:
        figure.colorbar(shown, ax=axes[:, 1], label="disparity [px]", fraction=0.04)
    return figure


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure; the file's ending chooses the format."""
    figure.savefig(path, dpi=100)
