"""Pixel maps, the area of a view that an image covers, and samples of an image between its pixels: bilinear, and by its
cubic B-spline."""

from collections.abc import Callable, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from stereorecal._arrays import AnyArray, Mat3
from stereorecal.geometry._camera import Camera
from stereorecal.geometry._view import View

PixelMap = Float[AnyArray, "2 h w"]  # a plane of columns x and one of rows y

_POLE = np.sqrt(3.0) - 2.0  # of the filter from samples to the coefficients of their cubic spline
_REACH = 8  # pixels, where that filter has fallen to 3e-5


def pixel_map(camera: Camera, rotation: Mat3, view: View, side: int) -> PixelMap:
    """Where each pixel of a rectified view comes from in the camera's image: (2, h, w), columns x and rows y.

    Of a pinhole the same as `initUndistortRectifyMap` of `cv2`, or of `cv2.fisheye` for an equidistant lens, float32,
    except that pixels that the lens does not show, behind the camera or beyond the angle at which its model folds back,
    lie at (-1, -1), outside every image.

    Args:
        rotation: (3, 3) camera frame to rectified frame.
        side: of the view: 0 left, 1 right.
    """
    formulas, (width, height) = view.formulas, view.size
    matrix = (view.matrix_left, view.matrix_right)[side]
    u = ((jnp.arange(width, dtype=jnp.float32) - matrix[0, 2]) / matrix[0, 0])[None, :]
    v = ((jnp.arange(height, dtype=jnp.float32) - matrix[1, 2]) / matrix[1, 1])[:, None]
    x, y, z = formulas.directions(u, v)
    r = rotation  # directions of the view, turned back by the transpose
    ray_x, ray_y, ray_z = (r[0, axis] * x + r[1, axis] * y + r[2, axis] * z for axis in range(3))
    if camera.lens.WIDE:
        length = jnp.sqrt(ray_x * ray_x + ray_y * ray_y + ray_z * ray_z)
        seen = ray_z > length * jnp.cos(camera.lens_field)
        # A direction that is seen, for those that are not: derivatives of what is not used must be finite, too.
        ray_x, ray_y, ray_z = (jnp.where(seen, ray, axis) for ray, axis in ((ray_x, 0.0), (ray_y, 0.0), (ray_z, 1.0)))
        planes = camera.lens.project(ray_x, ray_y, ray_z, camera.distortion)
    else:
        forward = ray_z > 1e-3
        inverse_z = 1.0 / jnp.where(forward, ray_z, 1.0)
        x, y = ray_x * inverse_z, ray_y * inverse_z
        seen = forward & (x * x + y * y < camera.lens_radius**2)
        planes = camera.lens.project(x, y, 1.0, camera.distortion)
    seen = seen & formulas.shows(u, v)
    return jnp.stack(
        [jnp.where(seen, p * camera.matrix[i, i] + camera.matrix[i, 2], -1.0) for i, p in enumerate(planes)]
    )


def rectifying_maps(
    left: Camera, right: Camera, rotations: Sequence[Mat3] | AnyArray, view: View
) -> tuple[PixelMap, PixelMap]:
    """The pixel maps of both cameras in one View, by their rotations into its frame (`rectifying_rotations`)."""
    return pixel_map(left, rotations[0], view, 0), pixel_map(right, rotations[1], view, 1)


def bilinear_warp(image: Float[AnyArray, "height width"], coordinates: PixelMap) -> Float[jax.Array, "h w"]:
    """Sample `image` at pixel coordinates (x, y), as `cv2.remap` with INTER_LINEAR and BORDER_REPLICATE.

    The border is repeated, not blackened: a black border is an edge that a matcher would match. `mapped_area`
    says which pixels are real.
    """
    width = image.shape[1]
    x0, y0, fx, fy = _nearest_before(coordinates, image.shape)
    corner = y0 * width + x0
    flat = jnp.asarray(image).reshape(-1)

    def at(offset: int) -> jax.Array:
        return flat.at[corner + offset].get(mode="promise_in_bounds")

    top = at(0) + fx * (at(1) - at(0))
    bottom = at(width) + fx * (at(width + 1) - at(width))
    return top + fy * (bottom - top)


def _nearest_before(coordinates: PixelMap, shape: tuple[int, ...]) -> tuple[jax.Array, ...]:
    """The pixel left of and above each point, which is moved into the image first, and the way from it in x and y."""
    height, width = shape
    x = jnp.clip(coordinates[0], 0.0, width - 1.0)
    y = jnp.clip(coordinates[1], 0.0, height - 1.0)
    x0 = jnp.minimum(x.astype(jnp.int32), width - 2)
    y0 = jnp.minimum(y.astype(jnp.int32), height - 2)
    return x0, y0, x - x0, y - y0


def mapped_area(coordinates: PixelMap, size: tuple[int, int]) -> Bool[AnyArray, "h w"]:
    """Pixels of a view whose source lies inside an image of `size` (width, height)."""
    x, y = coordinates[0], coordinates[1]
    return (x >= 0) & (x <= size[0] - 1) & (y >= 0) & (y <= size[1] - 1)


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
        x0, y0, fx, fy = _nearest_before(coordinates, shape)
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
