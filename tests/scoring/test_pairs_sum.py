"""The count of several pairs is the sum of their counts."""

import numpy as np
import pytest

from stereorecal.geometry import view, with_unit_baseline
from stereorecal.matching import BM, SAD
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts, score


@pytest.mark.parametrize("matcher", [SAD(num_disparities=32), BM(num_disparities=32)])
def test_sum(scene, matcher):
    given_scene = scene("street", 0, frames=2)
    rig, pairs = given_scene.rig, given_scene.pairs
    points = with_unit_baseline(rig.extrinsics) + np.radians([[0.0] * 6, [0.5, 0.2, -0.4, 0.0, 0.0, 0.0]])
    joint = counts(prepare(rig, pairs, view(rig)), points, matcher)
    single = [counts(prepare(rig, [pair], view(rig)), points, matcher) for pair in pairs]
    assert len({tuple(s) for s in single}) == 2
    assert np.array_equal(joint, np.sum(single, axis=0))


def test_score_knows_how_many_pixels(scene):
    given_scene = scene("street", 0, frames=2)
    assert score(given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=32)).pixels == 2 * 320 * 240
