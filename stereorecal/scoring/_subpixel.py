"""Sub-pixel refinement of a matched frame: the disparity and the row offset of each pixel's match.

The right image is warped by disparity and row offset as they are, so that a window follows slanted surfaces, and the
difference that remains within the window of a pixel says where that pixel belongs (Lucas & Kanade 1981): one correction
of the matcher's disparities and one row offset for all of the window. Increments are not added up: a box window has
negative frequencies, and what it averages out would grow with every iteration. Pixels without a valid disparity take no
part in any window. Where the disparity changes fast, at the edges of objects and on steep slants, a window covers more
than one depth: the offsets there have a small bias that does not average out, and get less weight.
"""

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import cubic_sampler
from stereorecal.matching import Disparity, box_sum
from stereorecal.scoring._rectify import Rectified

WINDOW = 11  # pixels
_ITERATIONS = 3
_CONTRAST_WINDOW = 15  # pixels; grey levels are taken relative to the mean and the contrast in it
_CONTRAST_FLOOR = 25.0  # grey levels squared: below that, differences are noise
_SETTLED = 0.05  # pixels that the last iteration may still move
_AWAY = 1.0  # pixels from the matcher's disparity
_COVER = 0.5  # share of the window that must be valid
_FARTHEST_ROW = 2.0  # pixels across the rows; beyond it the match is wrong
_WIDEST = 0.17  # pixels, standard deviation of the row offset by the noise of the window alone
_UNEVEN = 1.0  # pixels of disparity within so many pixels: an edge, or a slant of a quarter of a pixel a pixel
_UNEVEN_WITHIN = 5
_BY_UNEVEN = 0.1  # pixels, standard deviation of the row offset where the grey levels' window sees that
_QUIETEST = 1e-5  # contrast squared: without it, a flat window that agrees exactly would have zero variance


class Offsets(NamedTuple):
    """The match of each pixel of the left image.

    Attributes:
        disparity, row: position of the match: (x - disparity, y + row), pixels.
        variance: of `row`, in pixels squared, with the disparity unknown as well: the noise of the window over
            [G^-1]_yy of its structure tensor G, and what uneven disparities near by add.
        good: False where the refinement failed.
    """

    disparity: Float[jax.Array, "h w"]
    row: Float[jax.Array, "h w"]
    variance: Float[jax.Array, "h w"]
    good: Bool[jax.Array, "h w"]


def refine(frame: Rectified, disparity: Disparity) -> Offsets:
    """Refine a disparity from (d, 0) to (d, row offset) of sub-pixel accuracy. Pure and traceable."""
    left, right = _contrast(jnp.stack([frame.left, frame.right]))
    mask = jnp.asarray(disparity.valid, jnp.float32)
    columns, rows = (jnp.arange(n, dtype=jnp.float32) for n in left.shape[::-1])
    gradient_x, gradient_y = (mask * g for g in _gradient(left))
    products = [mask, gradient_x * gradient_x, gradient_x * gradient_y, gradient_y * gradient_y]
    pixels, xx, xy, yy = _window_sums(jnp.stack(products))
    sample = cubic_sampler(right)
    damping = 1e-3 * pixels + 1e-6
    determinant = (xx + damping) * (yy + damping) - xy * xy
    start = jnp.where(disparity.valid, disparity.values, 0.0)

    def difference(change, v):
        return mask * (left - sample(jnp.stack([columns - (start + change), rows[:, None] + v])))

    def step(_, fields):
        change, v, error, _ = fields
        # What would remain at the matcher's disparity and row 0, linear where each pixel is now.
        at_start = error - gradient_x * change + gradient_y * v
        x, y = _window_sums(jnp.stack([gradient_x * at_start, gradient_y * at_start]))
        # Damped towards where it is, not where it began: weak texture would be drawn to row 0.
        x, y = x - damping * change, y + damping * v
        # The least-squares solution of at_start + gradient_x change - gradient_y v = 0 over the window.
        by = jnp.clip((xy * y - (yy + damping) * x) / determinant - change, -1.0, 1.0)
        by_v = jnp.clip(((xx + damping) * y - xy * x) / determinant - v, -1.0, 1.0)
        change, v = change + mask * by, v + mask * by_v
        return change, v, difference(change, v), jnp.maximum(jnp.abs(by), jnp.abs(by_v))

    zero = jnp.zeros_like(start)
    # The first time around no error is known and nothing moves. Sampled in one place only, there is less to
    # compile, and no sum over a window in which XLA would sample anew.
    change, v, error, moved = jax.lax.fori_loop(0, 1 + _ITERATIONS, step, (zero, zero, zero, zero))
    noise = box_sum(error**2, WINDOW) / jnp.maximum(pixels, 1.0)
    variance = jnp.maximum(noise, _QUIETEST) / jnp.maximum(yy - xy * xy / (xx + 1e-6), 1e-6)
    by_uneven = _BY_UNEVEN**2 * _uneven(disparity)
    good = (
        disparity.valid
        & (moved < _SETTLED)
        & (jnp.abs(change) < _AWAY)
        & (jnp.abs(v) < _FARTHEST_ROW)
        & (pixels > _COVER * WINDOW**2)
        & (variance < _WIDEST**2)
    )
    return Offsets(start + change, v, variance + by_uneven, good)


_window_sums = jax.vmap(partial(box_sum, block_size=WINDOW))  # of several fields in one go: less to compile


def _uneven(disparity: Disparity) -> Bool[jax.Array, "h w"]:
    """True where the disparity changes fast inside the window in which grey levels are taken relative."""

    def highest(values, side):
        for window in ((side, 1), (1, side)):
            values = jax.lax.reduce_window(values, -jnp.inf, jax.lax.max, window, (1, 1), "SAME")
        return values

    values, valid = jnp.asarray(disparity.values), disparity.valid
    farther, nearer = (highest(jnp.where(valid, side, -jnp.inf), _UNEVEN_WITHIN) for side in (-values, values))
    return highest((nearer + farther > _UNEVEN).astype(jnp.float32), _CONTRAST_WINDOW) > 0


def _contrast(images: Float[jax.Array, "n h w"]) -> Float[jax.Array, "n h w"]:
    """Grey levels less their local mean, over the local contrast: exposure and vignetting leave it as it is."""
    sums = jax.vmap(partial(box_sum, block_size=_CONTRAST_WINDOW))
    across, down = (np.convolve(np.ones(n), np.ones(_CONTRAST_WINDOW), "same") for n in images.shape[:0:-1])
    pixels = jnp.outer(jnp.asarray(down, jnp.float32), jnp.asarray(across, jnp.float32))
    centred = images - sums(images) / pixels
    return centred / jnp.sqrt(sums(centred**2) / pixels + _CONTRAST_FLOOR)


def _gradient(image: Float[jax.Array, "h w"]) -> tuple[Float[jax.Array, "h w"], Float[jax.Array, "h w"]]:
    padded = jnp.pad(image, 1, mode="edge")
    return 0.5 * (padded[1:-1, 2:] - padded[1:-1, :-2]), 0.5 * (padded[2:, 1:-1] - padded[:-2, 1:-1])
