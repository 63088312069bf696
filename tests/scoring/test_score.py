"""score, rectify, disparity, counts: what a user gets to see, and a twin in OpenCV and plain NumPy."""

import cv2
import numpy as np
import pytest
from fixtures import SAD_48
from hypothesis import example, given, settings, strategies as st

from stereorecal import InputError
from stereorecal.geometry import rectifying_rotations, rotation_from_euler, view, with_unit_baseline
from stereorecal.matching import BM, SAD, SGBM, reference
from stereorecal.scoring import prepare
from stereorecal.scoring.host import Score, counts, disparities, disparity, rectify, score


def test_text():
    assert str(Score(41033, 1204224)) == "41 033 of 1 204 224 pixels (3.4 %)"
    assert str(Score(0, 999)) == "0 of 999 pixels (0.0 %)"


def test_what_is_seen_are_numpy_arrays_of_the_images_size(scene):
    given_scene = scene()
    left, right = rectify(given_scene.rig, given_scene.pairs[0])
    found = disparity(given_scene.rig, given_scene.pairs[0], matcher=SAD_48)
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
    expected = score(given_scene.rig, given_scene.pairs, matcher=SAD_48)
    assert score(other, given_scene.pairs, matcher=SAD_48) == expected


def test_pairs_of_another_size(scene):
    with pytest.raises(InputError, match="images are 320x240, but the calibration is for 160x120"):
        score(scene(size=(160, 120)).rig, scene().pairs, matcher=SAD_48)


# --- what is counted ----------------------------------------------------------------------------------------

MATCHERS = [cls(num_disparities=48) for cls in (SAD, BM, SGBM)]


@pytest.mark.parametrize("size", [(320, 240), (160, 120)])  # candidates of small ones share a call
@pytest.mark.parametrize("matcher", MATCHERS)
def test_count_is_the_sum_of_valid_over_frames_each_of_which_is_as_alone(scene, matcher, size):
    given_scene = scene("street", 0, size, frames=2)
    rig, pairs = given_scene.rig, given_scene.pairs
    both, *each = (prepare(rig, some, view(rig)) for some in (pairs, pairs[:1], pairs[1:]))
    points = with_unit_baseline(rig.extrinsics) + np.radians([[0.0] * 6, [0.5, 0.2, -0.4, 0.0, 0.0, 0.0]])
    single = [counts(one, points, matcher) for one in each]
    assert len({tuple(one) for one in single}) == 2
    np.testing.assert_array_equal(counts(both, points, matcher), np.sum(single, axis=0))
    for point, *alone in zip(points, *single, strict=True):
        assert [one.valid.sum() for one in disparities(both, point, matcher)] == alone


@pytest.mark.parametrize("matcher", MATCHERS)
def test_nothing_outside_the_mapped_area_counts(scene, matcher):
    """A rig turned down by 15 degrees shows nothing in the lowest part of the view of before."""
    given_scene = scene("street", 1)
    rig, first_view = given_scene.rig, view(given_scene.rig)
    turn = np.radians([30.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    found = disparity(
        rig.with_extrinsics(rig.extrinsics + turn), given_scene.pairs[0], view=first_view, matcher=matcher
    )
    covered = disparity(rig, given_scene.pairs[0], view=first_view, matcher=matcher)
    assert covered.valid[200:].any()
    outside = ~found.valid.any(axis=1)
    assert outside[-20:].all() or outside[:20].all()


# --- the twin -----------------------------------------------------------------------------------------------


def slow_count(rig, pair, extrinsics, own_view, matcher):
    rotations = rectifying_rotations(rotation_from_euler(extrinsics[:3]), extrinsics[3:])
    sides = (
        (pair.left, rig.left, rotations[0], own_view.matrix_left),
        (pair.right, rig.right, rotations[1], own_view.matrix_right),
    )
    images, areas = [], []
    for image, camera, turn, matrix in sides:
        maps = cv2.initUndistortRectifyMap(camera.matrix, camera.distortion, turn, matrix, own_view.size, cv2.CV_32FC1)
        images.append(cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
        areas.append(
            (maps[0] >= 0) & (maps[0] <= camera.size[0] - 1) & (maps[1] >= 0) & (maps[1] <= camera.size[1] - 1)
        )
    found = reference.match(*images, matcher)
    width = own_view.size[0]
    partner = np.arange(width) - np.round(found.values).astype(int)
    seen = np.take_along_axis(areas[1], np.clip(partner, 0, width - 1), axis=1) & (partner >= 0) & (partner < width)
    return int(np.sum(found.valid & areas[0] & seen))


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.2, 0.5, -0.3), (-1.0, 1.0, 1.0)])
@pytest.mark.parametrize(
    ("kind", "matcher"),
    [
        ("harbour", SAD(num_disparities=24)),
        ("street", SAD(min_disparity=-4, num_disparities=20, block_size=7)),
    ],
)
def test_twin(scene, kind, turn, matcher):
    given_scene = scene(kind, 3, (160, 120))
    rig, own_view = given_scene.rig, view(given_scene.rig)
    extrinsics = with_unit_baseline(rig.extrinsics) + np.radians([*turn, 0.0, 0.0, 0.0])
    fast = int(counts(prepare(rig, given_scene.pairs, own_view), extrinsics[None], matcher)[0])
    slow = slow_count(rig, given_scene.pairs[0], extrinsics, own_view, matcher)
    assert slow > 500
    assert fast == pytest.approx(slow, rel=0.005)
