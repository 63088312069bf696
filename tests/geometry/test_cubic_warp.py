"""The cubic warp against a plain NumPy twin, polynomials and a band-limited function."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from stereorecal.geometry import bilinear_warp, cubic_warp

HEIGHT, WIDTH = 17, 23
warp, bilinear = jax.jit(cubic_warp), jax.jit(bilinear_warp)

coefficient = st.floats(-1, 1, width=32)
inner = st.tuples(st.floats(1, WIDTH - 2, width=32), st.floats(1, HEIGHT - 2, width=32))


def keys(distance: float) -> float:
    """Keys' kernel with a = -1/2, from its definition."""
    a, s = -0.5, abs(distance)
    if s <= 1:
        return (a + 2) * s**3 - (a + 3) * s**2 + 1
    return a * s**3 - 5 * a * s**2 + 8 * a * s - 4 * a if s < 2 else 0.0


def slow_warp(image: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Pixel by pixel: the kernel times all pixels within two, the image continued by its border."""
    height, width = image.shape
    out = np.zeros(coordinates.shape[1:])
    for index in np.ndindex(out.shape):
        x, y = (np.clip(float(coordinates[(axis, *index)]), 0, n - 1) for axis, n in enumerate((width, height)))
        for row in range(int(np.floor(y)) - 1, int(np.floor(y)) + 3):
            for column in range(int(np.floor(x)) - 1, int(np.floor(x)) + 3):
                pixel = float(image[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)])
                out[index] += keys(x - column) * keys(y - row) * pixel
    return out


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 255, (HEIGHT, WIDTH)).astype(np.float32)


def grid(height: int = HEIGHT, width: int = WIDTH) -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(width), np.arange(height))).astype(np.float32)


@pytest.mark.parametrize("seed", range(3))
def test_twin(seed):
    """On noise, which forgives nothing; inside, on the border and beyond it."""
    low, high = np.array([-3, -3])[:, None, None], np.array([WIDTH + 2, HEIGHT + 2])[:, None, None]
    coordinates = np.random.default_rng(seed).uniform(low, high, (2, 30, 20)).astype(np.float32)
    found = warp(noise(seed), coordinates)
    assert found.dtype == jnp.float32
    assert found.shape == (30, 20)
    np.testing.assert_allclose(found, slow_warp(noise(seed), coordinates), atol=2e-3)


@settings(max_examples=50)
@given(st.tuples(*[coefficient] * 9), inner)
@example((0, 0, 0, 0, 0, 0, 0, 0, 1.0), (1.0, 1.0))
@example((0, 0, 0, 0, 0, 0, 0, 0, 1.0), (WIDTH - 2, HEIGHT - 2))
@example((0, 0, 1.0, 0, 0, 0, -1.0, 0, 0), (10.5, 8.25))
def test_exact_for_quadratics(coefficients, point):
    """In both coordinates at once, wherever no border is touched."""

    def surface(x, y):
        u, v = x / WIDTH, y / HEIGHT
        return sum(c * u ** (k % 3) * v ** (k // 3) for k, c in enumerate(coefficients))

    image = surface(*grid().astype(float)).astype(np.float32)
    x, y = (np.float32(p) for p in point)
    found = warp(image, np.array([[[x]], [[y]]], np.float32))
    np.testing.assert_allclose(found, surface(float(x), float(y)), atol=5e-6)


def test_a_cubic_is_beyond_it():
    """What "exact for quadratics" leaves out; a higher order would be another kernel."""
    image = (grid()[0] ** 3).astype(np.float32)
    found = float(warp(image, np.array([[[10.25]], [[8.0]]], np.float32))[0, 0])
    assert abs(found - 10.25**3) > 0.05


def test_pixels_themselves_are_kept():
    image = noise()
    np.testing.assert_allclose(warp(image, grid()), image, atol=1e-4)
    shifted = warp(image, grid() + np.float32([2, -1])[:, None, None])
    np.testing.assert_allclose(shifted[1:, :-2], image[:-1, 2:], atol=1e-4)


def test_the_border_is_repeated():
    image = noise()
    far = np.float32([[[-1e6, -1e6], [1e6, -3.0], [WIDTH - 1, HEIGHT - 1], [1e6, 1e9], [-0.4, 1e9], [7.0, 1e9]]]).T
    corners = [image[0, 0], image[0, -1], image[-1, -1], image[-1, -1], image[-1, 0], image[-1, 7]]
    np.testing.assert_allclose(warp(image, far)[:, 0], corners, atol=1e-4)


@settings(max_examples=25)
@given(
    st.floats(-1e3, 1e3, width=32), st.lists(st.tuples(*[st.floats(-1e4, 1e4, width=32)] * 2), min_size=4, max_size=4)
)
def test_a_constant_stays_constant(level, points):
    coordinates = np.array([points], np.float32).T
    found = warp(np.full((HEIGHT, WIDTH), level, np.float32), coordinates)
    np.testing.assert_allclose(found, level, rtol=1e-5, atol=1e-5)


def test_closer_than_bilinear_to_a_band_limited_function():
    rng = np.random.default_rng(0)
    frequency, phase = rng.uniform(-0.12, 0.12, (2, 20)), rng.uniform(0, 2 * np.pi, 20)

    def texture(x, y):
        return np.sin(2 * np.pi * (frequency[0] * x[..., None] + frequency[1] * y[..., None]) + phase).sum(-1)

    image = texture(*grid(60, 80).astype(float)).astype(np.float32)
    coordinates = rng.uniform([[[3]], [[3]]], [[[76]], [[56]]], (2, 50, 50)).astype(np.float32)
    truth = texture(*coordinates.astype(float))
    cubic, linear = (np.sqrt(np.mean((w(image, coordinates) - truth) ** 2)) for w in (warp, bilinear))
    assert cubic < 0.3 * linear
    assert linear > 0.02 * truth.std()


def test_the_slope_of_the_samples_is_the_slope_of_the_image():
    """The derivative through the coordinates is continuous, also across the pixels."""
    x, y = (n.astype(float) for n in grid())
    image = (0.03 * x**2 - 0.02 * x * y + y).astype(np.float32)

    def sample(point):
        return cubic_warp(image, point.reshape(2, 1, 1))[0, 0]

    slope = jax.jit(jax.grad(sample))
    for px, py in ((5.3, 7.6), (8.0, 9.0), (7.9999, 9.0001)):
        expected = [0.06 * px - 0.02 * py, 1 - 0.02 * px]
        np.testing.assert_allclose(slope(jnp.asarray([px, py], jnp.float32)), expected, atol=2e-4)
