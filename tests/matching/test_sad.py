"""The streaming SAD matcher against its plain NumPy twin, pixel for pixel."""

from dataclasses import fields, replace

import cv2
import numpy as np
import pytest
from gpu import as_on_a_gpu
from hypothesis import given, settings, strategies as st

from stereorecal import InputError
from stereorecal.matching import BM, SAD, SGBM, reference

SHAPE = (37, 61)


def image_pair(seed: int, height: int, width: int, shift: float, noise: float = 2.0):
    """A smooth random texture and the same seen `shift` pixels to the left, with noise."""
    rng = np.random.default_rng(seed)
    margin = 64
    texture = rng.normal(size=(height, width + 2 * margin)).astype(np.float32)
    texture = 128 + 60 * cv2.GaussianBlur(texture, (0, 0), 1.2) / 0.25
    column = np.arange(width, dtype=np.float32)
    rows = np.repeat(np.arange(height, dtype=np.float32)[:, None], width, axis=1)

    def seen(offset):
        x = np.repeat((column + margin + offset)[None], height, axis=0).astype(np.float32)
        image = cv2.remap(texture, x, rows, cv2.INTER_CUBIC)
        return np.clip(image + rng.normal(scale=noise, size=image.shape), 0, 255).astype(np.float32)

    return seen(0.0), seen(shift)


# Any two values of two options meet in one of these: each is a program, so they are few. In the order of the fields.
OPTIONS = [
    SAD(**dict(zip([field.name for field in fields(SAD)], values, strict=True)))
    for values in (
        (4, 1, 3, 10, 10, 3, 31),
        (4, 2, 11, 15, 0, -1, 15),
        (-9, 21, 3, 0, 1500, 0, 15),
        (0, 16, 15, 0, 10, -1, 0),
        (-9, 16, 11, 10, 1500, 1, 0),
        (0, 21, 15, 15, 0, 1, 31),
        (0, 2, 15, 10, 1500, 3, 15),
        (-9, 1, 15, 15, 0, 0, 0),
        (-9, 2, 11, 0, 10, 0, 31),
        (4, 16, 3, 15, 0, 3, 0),
        (0, 1, 11, 0, 10, 1, 15),
        (4, 21, 11, 10, 1500, -1, 31),
        (4, 2, 3, 0, 0, 1, 0),
        (-9, 21, 11, 0, 10, 3, 0),
        (0, 16, 3, 10, 0, 0, 15),
        (-9, 1, 3, 15, 1500, -1, 31),
        (4, 16, 15, 15, 10, 0, 31),
    )
]


@pytest.mark.slow(after=4)
@pytest.mark.parametrize("matcher", OPTIONS)
@settings(max_examples=max(4, settings.default.max_examples // 12))
@given(seed=st.integers(0, 10**6), shift=st.floats(-6, 12))
def test_equals_the_numpy_twin(matcher, seed, shift):
    left, right = image_pair(seed, *SHAPE, shift)
    fast, plain = matcher.match(left, right), reference.match(left, right, matcher)
    np.testing.assert_array_equal(np.asarray(fast.valid), plain.valid)
    # Winners are compared where a winner exists at all; elsewhere the value means nothing.
    np.testing.assert_allclose(np.asarray(fast.values), plain.values, atol=1e-4)


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("matcher", OPTIONS[2:7])  # each compiles two programs
@settings(max_examples=max(4, settings.default.max_examples // 12))
@given(seed=st.integers(0, 10**6), shift=st.floats(-6, 12))
def test_the_form_for_a_gpu_finds_the_same(matcher, seed, shift):
    left, right = image_pair(seed, *SHAPE, shift)
    found, plain = as_on_a_gpu(matcher, SHAPE)(left, right), reference.match(left, right, matcher)
    np.testing.assert_array_equal(np.asarray(found.valid), plain.valid)
    np.testing.assert_allclose(np.asarray(found.values), plain.values, atol=1e-4)


@pytest.mark.parametrize("matcher", [SAD(pre_filter_cap=0, block_size=21), SAD(block_size=31)])
def test_wide_windows_do_not_overflow(matcher):
    matcher = replace(matcher, num_disparities=16)
    rng = np.random.default_rng(0)
    left = (255.0 * (rng.random((48, 80)) > 0.5)).astype(np.float32)
    right = (255.0 - np.roll(left, -5, axis=1)).astype(np.float32)  # as different as can be
    fast, plain = matcher.match(left, right), reference.match(left, right, matcher)
    np.testing.assert_array_equal(np.asarray(fast.valid), plain.valid)
    np.testing.assert_allclose(np.asarray(fast.values), plain.values, atol=1e-4)


def test_twice_a_cost_may_not_fit_where_the_cost_does():
    """Slopes against each other cost nearly as much as can be, everywhere, and no candidate is much better."""
    matcher = SAD(num_disparities=16, block_size=21, uniqueness_ratio=100, disp12_max_diff=-1, texture_threshold=0)
    left = np.tile(3.0 * np.arange(80), (48, 1)).astype(np.float32)
    fast, plain = matcher.match(left, 255.0 - left), reference.match(left, 255.0 - left, matcher)
    np.testing.assert_array_equal(np.asarray(fast.valid), plain.valid)


def test_the_limit_of_a_rival_does_not_overflow():
    """A hundredfold of these costs is no int32. All are equal, so no winner is unique."""
    options = {"block_size": 467, "uniqueness_ratio": 100, "pre_filter_cap": 0, "texture_threshold": 0}
    black, white = (np.full((240, 32), grey, np.float32) for grey in (0.0, 255.0))
    found = SAD(num_disparities=4, disp12_max_diff=-1, **options).match(black, white)
    assert not np.asarray(found.valid)[:, 4:].any()  # farther left, not all candidates lie in the right image


CLASSES = [SAD, BM, SGBM]
BOTH_WAYS = {"min_disparity": -16, "num_disparities": 48}  # one program of SAD's for images of one size
SEEN = (120, 200)


@pytest.mark.parametrize("cls", CLASSES)
@pytest.mark.parametrize("shift", [4.0, 7.25, 12.5, -8.0])
def test_finds_a_known_shift(cls, shift):
    disparity = cls(**BOTH_WAYS).match(*image_pair(3, *SEEN, shift, noise=1.0))
    valid = np.asarray(disparity.valid)[:, 50:-40]
    found = np.asarray(disparity.values)[:, 50:-40][valid]
    assert valid.mean() > 0.9
    assert np.abs(np.median(found) - shift) < (0.15 if shift % 1 else 0.02)
    assert np.mean(np.abs(found - shift) < 0.5) > 0.95


@pytest.mark.parametrize("cls", CLASSES)
def test_flat_areas_are_not_valid(cls):
    left, right = image_pair(5, *SEEN, 5.0, noise=0.0)
    left[:, 60:110] = right[:, 60:110] = 100.0
    valid = np.asarray(cls(**BOTH_WAYS).match(left, right).valid)
    assert not valid[:, 72:98].any()


def test_rounding_happens_once_and_inside():
    left, right = image_pair(6, *SEEN, 5.0)
    exact, rounded = (SAD(**BOTH_WAYS).match(*images) for images in ((left, right), (np.rint(left), np.rint(right))))
    np.testing.assert_array_equal(np.asarray(exact.values), np.asarray(rounded.values))


@pytest.mark.parametrize(
    ("cls", "options", "words"),
    [
        (SAD, {"block_size": 4}, "block_size"),
        (SAD, {"num_disparities": 0}, "num_disparities"),
        (BM, {"uniqueness_ratio": 120}, "uniqueness_ratio"),
        (SGBM, {"texture_threshold": -1}, "texture_threshold"),
        (SAD, {"pre_filter_cap": 99}, "pre_filter_cap"),
    ],
)
def test_senseless_options_are_refused(cls, options, words):
    with pytest.raises(InputError, match=words):
        cls(**options)


@pytest.mark.parametrize("cls", CLASSES)
def test_range_must_be_known_and_fit(cls):
    left, right = image_pair(7, 40, 60, 3.0)
    with pytest.raises(InputError, match="num_disparities"):
        cls().match(left, right)
    with pytest.raises(InputError, match="beyond the width of the image"):
        cls(num_disparities=64).match(left, right)


def test_scaling_covers_the_range():
    small = SAD(min_disparity=-5, num_disparities=70).scaled(0.25)
    assert small.min_disparity == -2
    assert small.min_disparity + small.num_disparities >= 65 / 4
    assert small.block_size == 11


@pytest.mark.parametrize(("lowest", "count"), [(0, 64), (-64, 32), (-8, 72)])
def test_the_widest_range_leaves_one_column(lowest, count):
    matcher = SAD(min_disparity=lowest, num_disparities=count)
    assert matcher.disparity_range(65) == (lowest, count)
    with pytest.raises(InputError, match=r"beyond the width of the image \(64 pixels\)"):
        matcher.disparity_range(64)
