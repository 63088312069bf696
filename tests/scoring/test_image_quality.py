"""Light and texture of images, also of those that show a lens' image circle on black."""

import cv2
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import Pair
from stereorecal.scoring import image_quality

HEIGHT, WIDTH = 240, 320
RNG = np.random.default_rng(0)
TEXTURE = np.kron(RNG.uniform(60.0, 200.0, (HEIGHT // 8, WIDTH // 8)), np.ones((8, 8)))
BLACK = RNG.normal(6.0, 2.0, (HEIGHT, WIDTH)).clip(0.0, 12.0)


def on_black(radius: float, centre: tuple[float, float] = (WIDTH / 2, HEIGHT / 2), inside=TEXTURE) -> Pair:
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    image = np.where(np.hypot(columns - centre[0], rows - centre[1]) < radius, inside, BLACK)
    return Pair(image.astype(np.float32), image.astype(np.float32))


@given(st.floats(80.0, 150.0), st.floats(-12.0, 12.0), st.floats(-12.0, 12.0))
def test_what_an_image_circle_leaves_out_does_not_count(radius, x, y):
    found = image_quality(on_black(radius, (WIDTH / 2 + x, HEIGHT / 2 + y)))
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    disc = np.hypot(columns - WIDTH / 2 - x, rows - HEIGHT / 2 - y) < radius
    assert found.shown == pytest.approx(disc.mean(), abs=0.03)
    assert found.brightness == pytest.approx(TEXTURE.mean(), abs=15.0)
    assert found.enough


@pytest.mark.parametrize("period", [2.2, 2.6, 3.0, 4.5])
def test_slanted_stripes_are_not_interlaced(period):
    y, x = np.mgrid[:240, :320]
    left, right = (np.asarray(128 + 99 * np.sin(2 * np.pi * ((x + by) / 9 + y / period)), np.float32) for by in (0, 2))
    assert not image_quality(Pair(left, right)).interlaced


def test_a_raw_mosaic_is_not_interlaced():
    smooth = cv2.resize(np.random.default_rng(0).uniform(40, 200, (30, 40)).astype(np.float32), (320, 240))
    mosaic = smooth.copy()
    mosaic[::2, ::2] *= 0.6
    mosaic[1::2, 1::2] *= 1.25
    assert not image_quality(Pair(mosaic, np.roll(mosaic, 4, axis=1))).interlaced


def test_what_is_enough():
    """An ordinary image, all of which counts; a circle that is large, and has texture."""
    assert image_quality(Pair(TEXTURE.astype(np.float32), TEXTURE.astype(np.float32))).shown == 1.0
    assert not image_quality(on_black(110.0, inside=np.full((HEIGHT, WIDTH), 120.0))).enough
    assert not image_quality(on_black(40.0)).enough


def test_lights_at_night_are_no_image_circle():
    image = BLACK.copy()
    for _ in range(12):
        y, x = RNG.integers(20, HEIGHT - 30), RNG.integers(20, WIDTH - 30)
        image[y : y + 8, x : x + 8] = 255.0
    found = image_quality(Pair(image.astype(np.float32), image.astype(np.float32)))
    assert found.shown == 1.0
    assert not found.enough


def test_a_covered_lens_beside_an_image_circle_is_dark():
    circle = on_black(110.0)
    assert image_quality(Pair(circle.left, BLACK.astype(np.float32))).problem == "the images are too dark"


@pytest.mark.parametrize("covered", [0, 1])
def test_texture_is_that_of_the_worse_image(covered):
    images = [TEXTURE.astype(np.float32)] * 2
    images[covered] = np.tile(np.linspace(110.0, 130.0, WIDTH, dtype=np.float32), (HEIGHT, 1))
    found = image_quality(Pair(*images))
    assert found.texture == pytest.approx(0.0, abs=0.01)
    assert found.problem == "the images have too little texture"
