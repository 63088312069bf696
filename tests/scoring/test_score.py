"""score, rectify, disparity: what a user gets to see."""

import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.matching import SAD
from stereorecal.scoring.host import Score, disparity, rectify, score

SAD_32 = SAD(num_disparities=32)


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (Score(41033, 1204224), "41 033 of 1 204 224 pixels (3.4 %)"),
        (Score(0, 999), "0 of 999 pixels (0.0 %)"),
        (Score(1234567, 1234567), "1 234 567 of 1 234 567 pixels (100.0 %)"),
    ],
)
def test_text(found, text):
    assert str(found) == text


def test_score(scene):
    given_scene = scene()
    found = score(given_scene.rig, given_scene.pairs, matcher=SAD_32)
    assert found.pixels == 320 * 240
    assert type(found.count) is int
    assert found.fraction == found.count / found.pixels


def test_scale_scales_the_images_and_the_range(scene):
    given_scene = scene()
    half = score(given_scene.rig, given_scene.pairs, matcher=SAD_32, scale=0.5)
    assert half.pixels == 160 * 120
    assert half.fraction > 0.25


def test_rectify(scene):
    given_scene = scene()
    left, right = rectify(given_scene.rig, given_scene.pairs[0])
    assert left.shape == right.shape == (240, 320)
    assert left.dtype == right.dtype == np.float32
    assert isinstance(left, np.ndarray)
    assert 0 <= left.min() < left.max() <= 255


def test_disparity(scene):
    given_scene = scene()
    found = disparity(given_scene.rig, given_scene.pairs[0], matcher=SAD_32)
    assert found.values.shape == found.valid.shape == (240, 320)
    assert (found.values.dtype, found.valid.dtype) == (np.float32, np.bool_)
    assert isinstance(found.values, np.ndarray)
    assert isinstance(found.valid, np.ndarray)


@pytest.mark.parametrize("scale", [0.0, -0.5, 1.5, float("nan"), 0.01])
def test_scales_that_make_no_sense(scene, scale):
    given_scene = scene()
    with pytest.raises(InputError, match="scale is"):
        score(given_scene.rig, given_scene.pairs, matcher=SAD_32, scale=scale)


def test_no_pairs(scene):
    with pytest.raises(InputError, match="no image pair"):
        score(scene().rig, [], matcher=SAD_32)


def test_pairs_of_another_size(scene):
    with pytest.raises(InputError, match="images are 320x240, but the calibration is for 160x120"):
        score(scene(size=(160, 120)).rig, scene().pairs, matcher=SAD_32)


def test_a_range_wider_than_the_image(scene):
    given_scene = scene()
    with pytest.raises(InputError, match="beyond the width of the image"):
        score(given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=336))
