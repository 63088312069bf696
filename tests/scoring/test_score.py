"""score, rectify, disparity: what a user gets to see."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from stereorecal import InputError
from stereorecal.matching import SAD
from stereorecal.scoring.host import Score, disparity, rectify, score

SAD_32 = SAD(num_disparities=32)


def test_text():
    assert str(Score(41033, 1204224)) == "41 033 of 1 204 224 pixels (3.4 %)"
    assert str(Score(0, 999)) == "0 of 999 pixels (0.0 %)"


def test_scale_scales_the_images_and_the_range(scene):
    given_scene = scene()
    half = score(given_scene.rig, given_scene.pairs, matcher=SAD_32, scale=0.5)
    assert half.pixels == 160 * 120
    assert half.fraction == half.count / half.pixels > 0.25


def test_what_is_seen_are_numpy_arrays_of_the_images_size(scene):
    given_scene = scene()
    left, right = rectify(given_scene.rig, given_scene.pairs[0])
    found = disparity(given_scene.rig, given_scene.pairs[0], matcher=SAD_32)
    for array, kind in ((left, np.float32), (right, np.float32), (found.values, np.float32), (found.valid, np.bool_)):
        assert isinstance(array, np.ndarray)
        assert (array.shape, array.dtype) == ((240, 320), kind)
    assert 0 <= left.min() < left.max() <= 255


@settings(max_examples=8)
@example(factor=1000.0)
@given(factor=st.floats(1e-3, 1e4))
def test_the_unit_of_the_baseline_does_not_matter(scene, factor):
    given_scene = scene()
    other = given_scene.rig.with_extrinsics(given_scene.rig.extrinsics * np.r_[np.ones(3), np.full(3, factor)])
    expected = score(given_scene.rig, given_scene.pairs, matcher=SAD_32)
    assert score(other, given_scene.pairs, matcher=SAD_32) == expected


def test_no_pairs(scene):
    with pytest.raises(InputError, match="no image pair"):
        score(scene().rig, [], matcher=SAD_32)


def test_pairs_of_another_size(scene):
    with pytest.raises(InputError, match="images are 320x240, but the calibration is for 160x120"):
        score(scene(size=(160, 120)).rig, scene().pairs, matcher=SAD_32)
