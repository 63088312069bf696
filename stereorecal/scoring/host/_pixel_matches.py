"""The pixels of the right image that match given pixels of the left one, such as those of a range measurement."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Bool, Float

from stereorecal._compile_cache import CachedProgram
from stereorecal.geometry import StereoRig, cubic_warp, rectifying_rotations, with_unit_baseline
from stereorecal.matching import AbstractMatcher, Disparity
from stereorecal.scoring._correspondences import SMALLEST_SPREAD
from stereorecal.scoring._prepare import ScoringData
from stereorecal.scoring._rectify import Rotations, rectify_frames
from stereorecal.scoring._subpixel import refine
from stereorecal.scoring.host._disparities import compiled_rotations, disparities_at, of_one

_WINDOW = 5  # pixels to each side: the size of a matcher's window
_COVERED = 0.1  # of the window
_OUTSIDE = -1e6  # pixels: outside of every view
_FLAT = 0.3  # pixels of disparity off a plane: at an edge, either side may be meant


class PixelMatches(NamedTuple):
    """The matches of single pixels of the left image in the right one, at full size; NaN where none is reliable."""

    pixels: Float[np.ndarray, "n 2"]  # column, row
    deviation: Float[np.ndarray, "n"]  # standard deviation of the disparity, in pixels of the right camera


def match_pixels(
    data: ScoringData, rig: StereoRig, matcher: AbstractMatcher, frames: Sequence[Float[np.ndarray, "n 2"]]
) -> list[PixelMatches]:
    """The matches of pixels of the left image, for each frame.

    Args:
        data: at any scale, with the cameras of `rig`.
        frames: pixels (column, row) of the left image, at full size, for each frame.
    """
    rotations, found = compiled_rotations(with_unit_baseline(rig.extrinsics)), []
    for frame, pixels in zip(data.frames, frames, strict=True):
        if not len(pixels):
            found.append(PixelMatches(np.zeros((0, 2)), np.zeros(0)))
            continue
        matched = disparities_at(frame, rotations, matcher)[0]
        offsets = _offsets(frame, rotations, of_one(matched))
        found.append(_right_pixels(data, rig, [np.asarray(field)[0] for field in offsets], pixels))
    return found


@CachedProgram
def _offsets(data: ScoringData, rotations: Rotations, found: Disparity) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Disparity, row offset and whether they are good, of each pixel of one frame."""

    def frame(rectified, disparity):
        offsets = refine(rectified, disparity)
        return offsets.disparity, offsets.row, offsets.good

    return rectify_frames(data, rotations, frame, warp=cubic_warp, more=(found,))


def _right_pixels(
    data: ScoringData, rig: StereoRig, offsets: Sequence[np.ndarray], pixels: Float[np.ndarray, "n 2"]
) -> PixelMatches:
    view, (disparity, row, good) = jax.tree.map(float, data.view), offsets  # float64
    to_left, to_right = rectifying_rotations(rig.rotation, rig.translation)
    column, line = np.nan_to_num(view.pixels(np.asarray(rig.left.rays(pixels)) @ to_left.T, 0), nan=_OUTSIDE)
    (d, v), deviation = _planes_at(np.stack([disparity, row]), good > 0, column, line)
    sure = np.isfinite(deviation)
    turned = np.asarray(view.directions(column - d, line + v, 1))
    in_right = np.asarray(rig.right.project(np.where(sure[:, None], turned, [0.0, 0.0, 1.0]) @ to_right))
    # Of the view at its scale, as an angle, in pixels of the right camera.
    return PixelMatches(np.where(sure[:, None], in_right, np.nan), deviation / view.focal * float(rig.right.focal[0]))


def _planes_at(
    fields: Float[np.ndarray, "2 h w"], good: Bool[np.ndarray, "h w"], x: Float[np.ndarray, "n"], y: np.ndarray
) -> tuple[Float[np.ndarray, "2 n"], Float[np.ndarray, "n"]]:
    """The fields at points, by planes through the good pixels around them; and the standard deviation of the first
    field, NaN where it is no plane.

    The errors of matches within a window are correlated, so their number does not matter: a point among them is as
    uncertain as their scatter, a point outside of them more so (the leverage of a regression).
    """
    step = np.stack(np.meshgrid(*[np.arange(-_WINDOW, _WINDOW + 1)] * 2), -1).reshape(-1, 2)
    columns, rows = (np.round(p).astype(int)[:, None] + s for p, s in zip((x, y), step.T, strict=True))
    height, width = good.shape
    inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
    at = np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)
    use = inside & good[at]
    values = np.where(use, fields[:, *at], 0.0)
    places = np.stack([np.ones(use.shape), columns - x[:, None], rows - y[:, None]], -1) * use[..., None]
    normal = np.einsum("nki,nkj->nij", places, places) + 1e-6 * np.eye(3)
    planes = np.linalg.solve(normal, np.einsum("nki,cnk->nic", places, values))
    residuals = np.where(use, values[0] - np.einsum("nki,ni->nk", places, planes[..., 0]), 0.0)
    number = use.sum(axis=1)
    spread = np.sqrt((residuals**2).sum(axis=1) / np.maximum(number, 1))
    deviation = np.maximum(spread, SMALLEST_SPREAD) * np.sqrt(number * np.linalg.inv(normal)[:, 0, 0])
    return planes[:, 0].T, np.where((number > _COVERED * len(step)) & (spread < _FLAT), deviation, np.nan)
