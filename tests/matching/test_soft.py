"""The differentiable twin of the SAD search against the search itself, on images of whole grey levels."""

from dataclasses import replace

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal.matching import BM, SAD

SIZE = (120, 70)
PLAIN = SAD(num_disparities=16, block_size=7)
OPTIONS = {
    "default": PLAIN,
    "grey levels, not unique": replace(PLAIN, pre_filter_cap=0, uniqueness_ratio=0),
    "one way, any texture": replace(PLAIN, disp12_max_diff=-1, texture_threshold=0),
    "exact, much texture": replace(PLAIN, disp12_max_diff=0, texture_threshold=400),
    "lax, negative": replace(PLAIN, disp12_max_diff=2, min_disparity=-5, num_disparities=12),
}


def pair(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A textured step in depth, noise, and a patch without texture; whole grey levels, float32."""
    rng = np.random.default_rng(seed)
    texture = cv2.GaussianBlur(rng.normal(size=SIZE[::-1]), (0, 0), 1.2) * 160 + 120
    texture[40:60, 70:100] = 120
    right = np.where(np.arange(SIZE[0]) < 60, np.roll(texture, -3, axis=1), np.roll(texture, -8, axis=1))
    noisy = [image + rng.normal(size=image.shape) * 2 for image in (texture, right)]
    return tuple(np.clip(np.round(image), 0, 255).astype(np.float32) for image in noisy)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
@pytest.mark.parametrize("seed", [0, 1])
def test_without_temperature_it_is_the_search(options: SAD, seed: int):
    left, right = pair(seed)
    hard, soft = options.match(left, right), options.soft_match(left, right, 1e-6)
    confidence = np.asarray(soft.confidence.sum(axis=0))
    valid = np.asarray(hard.valid)
    assert 0.05 < valid.mean() < 0.98
    # Limits of whole costs are rounded down, and ties are broken by float32: not every pixel agrees.
    assert np.mean(np.abs(confidence - valid)) < 0.01
    sure = valid & (confidence > 0.9)
    winner = np.asarray(soft.values[0])
    assert np.abs(np.round(np.asarray(hard.values)) - winner)[sure].max() <= 1


@pytest.mark.parametrize("temperature", [0.01, 0.1, 1.0])
def test_confidence_is_a_share(temperature: float):
    soft = PLAIN.soft_match(*pair(0), temperature)
    total = np.asarray(soft.confidence.sum(axis=0))
    assert np.asarray(soft.confidence).min() >= 0.0
    assert total.max() <= 1.0 + 1e-5
    assert np.abs(np.diff(np.asarray(soft.values), axis=0)).max() <= 1  # the second candidate is a neighbour


@pytest.mark.slow
def test_the_derivative_is_that_of_small_changes_of_the_images():
    """Pixel by pixel, along a smooth random direction, against central differences; kinks are few."""
    confidence = jax.jit(lambda a, b: PLAIN.soft_match(a, b, 0.1).confidence.sum(axis=0))
    rng = np.random.default_rng(2)
    # Off the whole levels, where absolute differences of 0 have their kink.
    left, right = (jnp.asarray(image + rng.uniform(0, 1, image.shape), jnp.float32) for image in pair(0))
    change = [jnp.asarray(cv2.GaussianBlur(rng.normal(size=SIZE[::-1]), (0, 0), 2.0), jnp.float32) for _ in "lr"]
    actual = np.asarray(jax.jvp(confidence, (left, right), tuple(change))[1])
    step = 0.01
    ahead, behind = (confidence(left + s * change[0], right + s * change[1]) for s in (step, -step))
    expected = np.asarray(ahead - behind) / (2 * step)
    close = np.abs(actual - expected) <= 0.05 * np.abs(expected) + 1e-4
    assert close.mean() > 0.97
    moving = np.abs(expected) > 1e-2
    assert moving.mean() > 0.02
    assert close[moving].mean() > 0.8


def test_matchers_without_a_twin_say_so():
    assert SAD.smooth
    assert not BM.smooth
    with pytest.raises(NotImplementedError, match="BM has no differentiable twin"):
        BM(num_disparities=16).soft_match(*pair(0), 0.1)
