"""The SAD matcher in plain NumPy: slow, short, and the definition that `sad.py` is tested against."""

import numpy as np
from jaxtyping import Float, Int

from stereorecal.matching._matcher import Disparity
from stereorecal.matching.sad._sad import SAD

_NEVER = 2**31 - 1


def match(left: Float[np.ndarray, "h w"], right: Float[np.ndarray, "h w"], options: SAD) -> Disparity:
    """What `options.match(left, right)` must return: equal winners and validity, sub-pixel part to 1e-4 px."""
    width = left.shape[1]
    lowest, count = options.disparity_range(width)
    images = [np.clip(np.round(image), 0, 255).astype(np.int64) for image in (left, right)]
    gradients = [_x_sobel(image, options.pre_filter_cap or 31) for image in images]
    if options.pre_filter_cap:
        images = gradients
    volume = _cost_volume(images[0], images[1], lowest, count, options.block_size)
    winner = volume.argmin(axis=0)

    def cost(index: Int[np.ndarray, "h w"]) -> Int[np.ndarray, "h w"]:
        found = np.take_along_axis(volume, np.clip(index, 0, count - 1)[None], axis=0)[0]
        return np.where((index >= 0) & (index < count), found, _NEVER)

    best, below, above = cost(winner), cost(winner - 1), cost(winner + 1)
    valid = _box_sum(np.abs(gradients[0]), options.block_size) >= options.texture_threshold
    valid &= best < _NEVER
    if options.uniqueness_ratio:
        unrelated = np.abs(np.arange(count)[:, None, None] - winner) > 1
        second = np.where(unrelated, volume, _NEVER).min(axis=0)
        valid &= second > best + best * options.uniqueness_ratio // 100
    disparity = lowest + winner
    if options.disp12_max_diff >= 0:
        mirrored = _cost_volume(images[1][:, ::-1], images[0][:, ::-1], lowest, count, options.block_size)
        from_right = lowest + mirrored.argmin(axis=0)[:, ::-1]
        partner = np.clip(np.arange(width) - disparity, 0, width - 1)
        difference = np.take_along_axis(from_right, partner, axis=1) - disparity
        valid &= np.abs(difference) <= options.disp12_max_diff
    curvature = below - 2.0 * best + above
    refined = (np.maximum(below, above) < _NEVER) & (curvature > 0)
    offset = np.where(refined, 0.5 * (below - above) / np.where(refined, curvature, 1.0), 0.0)
    return Disparity((disparity + offset).astype(np.float32), valid)


def _cost_volume(left, right, lowest: int, count: int, block_size: int) -> Int[np.ndarray, "d h w"]:
    """Windows that reach beyond a column of either image see its border repeated; beyond its rows they see nothing."""
    height, width = left.shape
    radius = block_size // 2
    column = np.arange(-radius, width + radius)
    volume = np.full((count, height, width), _NEVER, np.int64)
    for index in range(count):
        partner = column - (lowest + index)
        difference = np.abs(left[:, np.clip(column, 0, width - 1)] - right[:, np.clip(partner, 0, width - 1)])
        partner = partner[radius : width + radius]
        inside = (partner >= 0) & (partner < width)
        volume[index][:, inside] = _box_sum(difference, block_size)[:, radius : width + radius][:, inside]
    return volume


def _x_sobel(image, cap: int):
    rows = np.pad(image, ((1, 1), (0, 0)), mode="edge")
    smooth = rows[:-2] + 2 * rows[1:-1] + rows[2:]
    gradient = np.zeros_like(image)
    gradient[:, 1:-1] = smooth[:, 2:] - smooth[:, :-2]
    return np.clip(gradient, -cap, cap)


def _box_sum(image, block_size: int):
    padded = np.pad(image, block_size // 2)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (block_size, block_size))
    return windows.sum(axis=(2, 3))
