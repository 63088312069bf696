"""Pairs from arrays, their checks, pickling."""

import pickle

import cv2
import numpy as np
import pytest
from refusals import refused
from trees import SIZE, texture

from stereorecal import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.recordings import Pair, check_pairs, make_pair


def colour(seed: int) -> np.ndarray:
    return np.dstack([texture(seed + i) for i in range(3)])


def test_eight_bit_values_stay():
    pair = make_pair(texture(0), texture(1)[..., None], name="frame")
    np.testing.assert_array_equal(pair.left, texture(0))
    np.testing.assert_array_equal(pair.right, texture(1))
    assert pair.left.dtype == pair.right.dtype == np.float32
    assert pair.size == SIZE
    assert pair.name == "frame"


@pytest.mark.parametrize("channels", ["rgb", "bgr"])
def test_colour_is_weighted_as_opencv_does(channels: str):
    code = cv2.COLOR_RGB2GRAY if channels == "rgb" else cv2.COLOR_BGR2GRAY
    alpha = np.dstack([colour(1), texture(9)])
    pair = make_pair(colour(0), alpha, channels=channels)
    assert np.abs(pair.left - cv2.cvtColor(colour(0), code)).max() <= 0.51
    assert np.abs(pair.right - cv2.cvtColor(colour(1), code)).max() <= 0.51


@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64, np.int32])
def test_wider_images_are_scaled_once_for_both(dtype: type):
    left, right = texture(0).astype(dtype) * 200, texture(1).astype(dtype) * 100
    pair = make_pair(left, right)
    np.testing.assert_allclose(pair.left, left * (255.0 / left.max()), rtol=1e-5)
    np.testing.assert_allclose(pair.right, right * (255.0 / left.max()), rtol=1e-5)


def with_value(value: float) -> np.ndarray:
    image = texture(0).astype(np.float64)
    image[3, 4] = value
    return image


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (np.zeros((16, 24, 3), np.uint8), "all black"),
        (np.full((16, 24), 7, np.uint8), "constant"),
        (np.full((480, 641, 3), (200, 13, 90), np.uint8), "constant"),
        (np.full((16, 24), 0.3), "constant"),
        (with_value(np.nan), "NaN"),
        (with_value(np.inf), "infinite"),
        (with_value(-1.0), "negative"),
        (np.zeros(24, np.uint8), "no image"),
        (np.zeros((16, 24, 2), np.uint8), "no image"),
        (np.zeros((1, 24), np.uint8), "no image"),
        (np.zeros((0, 24), np.uint8), "no image"),
        (np.zeros((2, 16, 24, 3), np.uint8), "no image"),
    ],
)
def test_images_that_are_none(bad: np.ndarray, words: str):
    size = bad.shape[1::-1] if bad.ndim in (2, 3) and min(bad.shape[:2]) > 1 else (24, 16)
    good = texture(1, size).astype(bad.dtype)
    with pytest.raises(InputError, match=f"frame, left: .*{words}"):
        make_pair(bad, good, name="frame")
    with pytest.raises(InputError, match=f"frame, right: .*{words}"):
        make_pair(good, bad, name="frame")


def test_images_that_do_not_go_together():
    deep, wide = texture(0).astype(np.uint16), texture(1, (25, 16))
    words = "frame: the left image is 24x16 and the right one 25x16"
    refused(lambda: make_pair(texture(0), wide, name="frame"), words)
    words = "uint16 and the right one float64; give both the same bit depth"
    refused(lambda: make_pair(deep, texture(1).astype(float)), words)
    refused(lambda: make_pair(colour(0), colour(1), channels="hsv"), "channel order 'hsv'")
    refused(lambda: Pair(np.zeros((3, 4), np.float32), np.zeros((4, 3), np.float32)), "same size")


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("dtype", [np.float16, np.float64, np.int64, np.uint8])
def test_a_pair_holds_float32(dtype):
    assert Pair(texture(0).astype(dtype), texture(1).astype(dtype)).left.dtype == np.float32


@pytest.mark.parametrize(("scale", "words"), [(16.0, r"grey levels go up to .* sr\.make_pair"), (-1.0, "negative")])
def test_a_pair_is_of_grey_levels_up_to_255(scale, words):
    with pytest.raises(InputError, match=f"pair, left: .*{words}"):
        Pair(scale * texture(0).astype(np.float32), texture(1).astype(np.float32))


def test_a_pair_has_pixels():
    with pytest.raises(InputError, match="pair, left: the image has no pixels"):
        Pair(np.zeros((0, 0), np.float32), np.zeros((0, 0), np.float32))


@pytest.mark.parametrize(
    ("given", "what"),
    [
        (np.ma.masked_invalid(np.ones((16, 24))), "masked array"),
        ([["a", "b"]], "a list is no image"),
        (None, "None is no image; cv2.imread returns it where it cannot"),
        (np.zeros((16, 24), complex), "an array of complex128 is no image"),
    ],
)
def test_what_holds_no_numbers_is_no_image(given, what):
    with pytest.raises(InputError, match=f"pair, left: .*{what}"):
        make_pair(given, texture(1))


def test_a_hot_pixel_is_not_white():
    """All others would be dark."""
    left, right = (16 * texture(seed, (240, 160)).astype(np.uint16) for seed in (0, 1))
    hot = left.copy()
    hot[3, 5] = 65535
    usual, spoiled = make_pair(left, right), make_pair(hot, right)
    assert spoiled.left[3, 5] == 255.0
    np.testing.assert_allclose(np.delete(spoiled.left, 3, axis=0), np.delete(usual.left, 3, axis=0), rtol=0.01)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("size", [(0, 0), (12.5, 8), (12,), 12, None, ("a", "b")])
def test_sizes_are_whole_pixels(size):
    with pytest.raises(InputError, match="give \\(width, height\\) in whole pixels"):
        make_pair(texture(0), texture(1)).resized(size)


def test_resized_is_the_mean_over_pixels():
    pair = make_pair(texture(0), texture(1), name="frame")
    small = pair.resized((12, 8))
    expected = texture(0).reshape(8, 2, 12, 2).mean(axis=(1, 3))
    np.testing.assert_allclose(small.left, expected, atol=1e-3)
    assert small.name == "frame"
    assert pair.resized(SIZE) is pair


def make_again(seed: int) -> Pair:
    return make_pair(texture(seed), texture(seed + 1), origin=(make_again, (seed,)))


def test_pickling():
    """By its origin, if it has one; else by value."""
    assert make_again(3).__reduce__() == (make_again, (3,))
    pair = make_again(3).resized((12, 8)).named("frame")
    again = pickle.loads(pickle.dumps(pair))
    np.testing.assert_array_equal(again.left, pair.left)
    np.testing.assert_array_equal(again.right, pair.right)
    assert again.name == "frame"


def test_rolling_shutters():
    """Their readout stays with a pair, wherever it goes."""
    for pair in (make_pair(texture(0), texture(1), time=2.0).read_out(0.02), make_again(3).read_out(0.02)):
        assert pair.readout == 0.02
        again = pickle.loads(pickle.dumps(pair))
        assert (again.readout, again.time) == (0.02, pair.time)
        assert pair.resized((12, 8)).readout == 0.02
    for wrong in (-0.01, 2.0, np.nan, np.inf):
        with pytest.raises(InputError, match="a rolling shutter"):
            make_again(3).read_out(wrong)


def test_check_pairs():
    lens = Camera(SIZE, np.array([[20.0, 0, 12], [0, 20, 8], [0, 0, 1]]))
    rig = StereoRig(lens, lens, np.array([0, 0, 0, -0.1, 0, 0]))
    pairs = [make_pair(texture(i), texture(i + 1), name=f"frame {i}") for i in range(2)]
    assert check_pairs(rig, pairs) == tuple(pairs)
    refused(lambda: check_pairs(rig, []), "no image pair")
    words = "frame 0: the images are 12x8, but the calibration is for 24x16"
    refused(lambda: check_pairs(rig, [*pairs, pairs[0].resized((12, 8))]), words)
    two_sizes = StereoRig(lens, lens.resized((12, 8)), rig.extrinsics)
    refused(lambda: check_pairs(two_sizes, pairs), "24x16 (left) and 12x8 (right)")
