"""Samples of an image between its pixels, by its cubic B-spline."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from stereorecal._arrays import AnyArray
from stereorecal.geometry._warp import PixelMap, nearest_before

_POLE = np.sqrt(3.0) - 2.0  # of the filter from samples to the coefficients of their cubic spline
_REACH = 8  # pixels, where that filter has fallen to 3e-5


def cubic_warp(image: Float[AnyArray, "height width"], coordinates: PixelMap) -> Float[jax.Array, "h w"]:
    """Sample `image` at pixel coordinates (x, y) by its cubic B-spline (Unser 1999); the border is repeated.

    For work well below a pixel: of a texture with a period of four pixels a bilinear sample, and cubic convolution as
    well, is shifted by up to 0.045 pixels, toward the nearest pixel and so in opposite directions in two images of it;
    this one by 0.007. A pixel that is NaN makes those within ten of it so.
    """
    return cubic_sampler(image)(coordinates)


def cubic_sampler(image: Float[AnyArray, "height width"]) -> Callable[[PixelMap], Float[jax.Array, "h w"]]:
    """`cubic_warp` of one image, to be used in a loop: what depends on the image alone is done before it."""
    shape, width = image.shape, image.shape[1] + 2
    # Computed once, not once for each pixel that reads it.
    flat = jax.lax.optimization_barrier(_coefficients(jnp.asarray(image, jnp.float32))).reshape(-1)

    def sample(coordinates: PixelMap) -> Float[jax.Array, "h w"]:
        x0, y0, fx, fy = nearest_before(coordinates, shape)
        columns, rows = _weights(fx), _weights(fy)
        corner = y0 * width + x0

        def along_row(j: int) -> jax.Array:
            offset = corner + j * width
            taps = (c * flat.at[offset + i].get(mode="promise_in_bounds") for i, c in enumerate(columns))
            return sum(taps, start=jnp.zeros((), jnp.float32))

        return sum((r * along_row(j) for j, r in enumerate(rows)), start=jnp.zeros((), jnp.float32))

    return sample


def _coefficients(image: Float[jax.Array, "height width"]) -> Float[jax.Array, "height+2 width+2"]:
    """The coefficients of the spline that goes through the pixels, from one pixel beyond the border on.

    Samples of a cubic B-spline are its coefficients, weighted (1, 4, 1) / 6; the inverse of that filter falls off by
    its pole, to each side (Unser 1999, box 2).
    """
    kernel = _POLE ** np.abs(np.arange(-_REACH, _REACH + 1))
    weights = (kernel / kernel.sum()).tolist()  # Python's numbers: they leave float32 as it is
    coefficients = jnp.pad(image, _REACH + 1, mode="edge")
    for axis in (0, 1):
        length = image.shape[axis] + 2
        parts = (w * jax.lax.slice_in_dim(coefficients, i, i + length, axis=axis) for i, w in enumerate(weights))
        coefficients = jax.lax.optimization_barrier(sum(parts, start=jnp.zeros((), jnp.float32)))
    return coefficients


def _weights(t: Float[jax.Array, "h w"]) -> tuple[jax.Array, ...]:
    """Weights of the four coefficients at -1, 0, 1, 2 for a point at t in [0, 1]."""
    before, after = (1.0 - t) ** 3 / 6.0, t**3 / 6.0
    here = 2.0 / 3.0 + t * t * (0.5 * t - 1.0)
    return before, here, 1.0 - before - here - after, after
