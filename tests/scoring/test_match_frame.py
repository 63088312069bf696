"""The count is the number of valid disparities, and what counts as valid lies inside both images."""

import numpy as np
import pytest

from stereorecal.geometry import view, with_unit_baseline
from stereorecal.matching import BM, SAD, SGBM
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts, disparities, disparity, score

MATCHERS = [cls(num_disparities=32) for cls in (SAD, BM, SGBM)]


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
def test_disparity_shows_what_score_counts(scene, matcher):
    given_scene = scene()
    found = disparity(given_scene.rig, given_scene.pairs[0], matcher=matcher)
    assert found.valid.sum() == score(given_scene.rig, given_scene.pairs, matcher=matcher).count
    assert found.values[found.valid].min() >= 0


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
