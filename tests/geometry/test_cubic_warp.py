"""The cubic warp against a spline of SciPy, and polynomials."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from scipy.ndimage import map_coordinates

from stereorecal.geometry import cubic_warp

try:
    from jax import enable_x64
except ImportError:  # before JAX 0.8
    from jax.experimental import enable_x64

HEIGHT, WIDTH = 29, 37
BORDER = 10  # pixels: what is beyond the border has no effect farther inside
warp = jax.jit(cubic_warp)

coefficient = st.floats(-1, 1, width=32)
inner = st.tuples(*[st.floats(BORDER, n - 1 - BORDER, width=32) for n in (WIDTH, HEIGHT)])


def oracle(image: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """SciPy's spline through the pixels, the image continued by its border without end, at points inside of it."""
    inside = [np.clip(c.astype(float), 0, n - 1) for c, n in zip(coordinates, image.shape[::-1], strict=True)]
    return map_coordinates(np.pad(image.astype(float), 30, mode="edge"), [c + 30 for c in inside[::-1]], order=3)


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 255, (HEIGHT, WIDTH)).astype(np.float32)


def grid() -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))).astype(np.float32)


@pytest.mark.parametrize("seed", range(3))
def test_oracle(seed):
    """On noise, which forgives nothing; inside, on the border and beyond it."""
    low, high = np.array([-3, -3])[:, None, None], np.array([WIDTH + 2, HEIGHT + 2])[:, None, None]
    coordinates = np.random.default_rng(seed).uniform(low, high, (2, 30, 20)).astype(np.float32)
    found = warp(noise(seed), coordinates)
    assert found.dtype == jnp.float32
    assert found.shape == (30, 20)
    np.testing.assert_allclose(found, oracle(noise(seed), coordinates), atol=1e-2)


@given(st.tuples(*[coefficient] * 16), inner)
@example((0,) * 15 + (1.0,), (BORDER, BORDER))
@example((0,) * 15 + (1.0,), (WIDTH - 1 - BORDER, HEIGHT - 1 - BORDER))
@example((0, 0, 0, 1.0, 0, 0, 0, 0, -1.0) + (0,) * 7, (10.5, 8.25))
def test_exact_for_cubics(coefficients, point):
    """In both coordinates at once, away from the border, whose repetition is no cubic."""

    def surface(x, y):
        u, v = x / WIDTH, y / HEIGHT
        return sum(c * u ** (k % 4) * v ** (k // 4) for k, c in enumerate(coefficients))

    image = surface(*grid().astype(float)).astype(np.float32)
    x, y = (np.float32(p) for p in point)
    found = warp(image, np.array([[[x]], [[y]]], np.float32))
    np.testing.assert_allclose(found, surface(float(x), float(y)), atol=2e-5)


def test_float32_also_where_jax_computes_with_64_bits():
    with enable_x64(True):
        found = cubic_warp(noise(), grid() + 0.5)
    assert found.dtype == jnp.float32
    np.testing.assert_allclose(found, warp(noise(), grid() + np.float32(0.5)), atol=1e-3)


def test_the_border_is_repeated():
    image = noise()
    far = np.float32([[[-1e6, -1e6], [1e6, -3.0], [WIDTH - 1, HEIGHT - 1], [1e6, 1e9], [-0.4, 1e9], [7.0, 1e9]]]).T
    corners = [image[0, 0], image[0, -1], image[-1, -1], image[-1, -1], image[-1, 0], image[-1, 7]]
    np.testing.assert_allclose(warp(image, far)[:, 0], corners, atol=5e-3)


def test_the_slope_of_the_samples_is_the_slope_of_the_image():
    """The derivative through the coordinates is continuous, also across the pixels."""
    x, y = (n.astype(float) for n in grid())
    image = (0.03 * x**2 - 0.02 * x * y + y).astype(np.float32)

    def sample(point):
        return cubic_warp(image, point.reshape(2, 1, 1))[0, 0]

    slope = jax.jit(jax.grad(sample))
    for px, py in ((15.3, 12.6), (18.0, 14.0), (17.9999, 14.0001)):
        expected = [0.06 * px - 0.02 * py, 1 - 0.02 * px]
        np.testing.assert_allclose(slope(jnp.asarray([px, py], jnp.float32)), expected, atol=2e-4)
