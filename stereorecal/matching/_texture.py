"""What the matchers share before they match: rounding, the x-Sobel prefilter, box sums and the texture check."""

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Bool, Float, Int, Num

from stereorecal._arrays import AnyArray

# Texture is measured on the prefiltered image; without a prefilter, on one with OpenCV's default cap.
DEFAULT_CAP = 31


def quantise(image: Float[AnyArray, "h w"]) -> Int[jax.Array, "h w"]:
    """Round to whole grey levels 0..255, half to even, int16. The one rounding between the warp and the matcher."""
    return jnp.clip(jnp.round(jnp.asarray(image)), 0, 255).astype(jnp.int16)


def x_sobel(image: Num[jax.Array, "h w"], cap: int) -> Num[jax.Array, "h w"]:
    """The x-Sobel response clipped to ±cap, as `cv2.StereoBM` prefilters; rows repeat at the border, the first and
    last column are 0."""
    rows = jnp.pad(image, ((1, 1), (0, 0)), mode="edge")
    smooth = rows[:-2] + 2 * rows[1:-1] + rows[2:]
    gradient = jnp.clip(smooth[:, 2:] - smooth[:, :-2], -cap, cap)
    # Not padded: with AVX2, XLA makes no vector loop of that, and takes eight times as long.
    border = jnp.zeros((len(image), 1), gradient.dtype)
    return jnp.concatenate([border, gradient, border], axis=1)


def box_sum(image: Num[jax.Array, "h w"], block_size: int) -> Num[jax.Array, "h w"]:
    """Sums over the square window around each pixel, int32 or float32; outside the image counts 0."""
    total = image if jnp.issubdtype(image.dtype, jnp.floating) else image.astype(jnp.int32)
    for window in ((block_size, 1), (1, block_size)):  # not slices and sums: XLA would repeat them for each reader
        total = jax.lax.reduce_window(total, total.dtype.type(0), jax.lax.add, window, (1, 1), "SAME")
    return total


def texture_response(image: Num[jax.Array, "h w"], block_size: int, pre_filter_cap: int) -> Num[jax.Array, "h w"]:
    """The absolute x-Sobel response, summed over the window."""
    return box_sum(jnp.abs(x_sobel(image, pre_filter_cap or DEFAULT_CAP)), block_size)


@partial(jax.jit, static_argnames=("block_size", "texture_threshold", "pre_filter_cap"))
def textured(
    image: Float[AnyArray, "h w"], block_size: int, texture_threshold: int, pre_filter_cap: int
) -> Bool[jax.Array, "h w"]:
    """Pixels whose window has an absolute x-Sobel response of at least `texture_threshold` in total.

    One definition for every matcher (it is `cv2.StereoBM`'s), so that their counts mean the same.
    """
    return texture_response(quantise(image), block_size, pre_filter_cap) >= texture_threshold
