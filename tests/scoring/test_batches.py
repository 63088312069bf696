"""A count belongs to its candidate: it does not know which others were asked with it, or in which order."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.geometry import view
from stereorecal.matching import BM, SAD
from stereorecal.scoring import counts, normalised, prepare

SAD_32 = SAD(num_disparities=32)
angles = st.floats(-0.05, 0.05)
shifts = st.floats(-0.05, 0.05)
candidates = st.lists(st.tuples(angles, angles, angles, st.just(0.0), shifts, shifts), min_size=1, max_size=6)


@settings(max_examples=15)
@given(offsets=candidates, data=st.data())
def test_batch_size_and_order_do_not_matter(scene, offsets, data):
    given_scene = scene()
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = normalised(given_scene.rig.extrinsics) + np.array(offsets)
    order = np.array(data.draw(st.permutations(range(len(points)))))
    cut = data.draw(st.integers(0, len(points)))
    together = counts(prepared, points, SAD_32)
    shuffled = counts(prepared, points[order], SAD_32)
    parts = np.concatenate([counts(prepared, part, SAD_32) for part in (points[:cut], points[cut:])])
    alone = [int(counts(prepared, point[None], SAD_32)[0]) for point in points]
    assert np.array_equal(shuffled, together[order])
    assert np.array_equal(parts, together)
    assert np.array_equal(alone, together)


def test_candidates_differ(scene):
    """Else the property above would hold for a constant."""
    given_scene = scene()
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    points = normalised(given_scene.rig.extrinsics) + np.array([[0.002 * i, 0, 0, 0, 0, 0] for i in range(4)])
    assert len(set(counts(prepared, points, SAD_32))) == 4


@pytest.mark.parametrize("matcher", [SAD_32, BM(num_disparities=32)])
def test_no_candidates_no_counts(scene, matcher):
    given_scene = scene()
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    assert counts(prepared, np.zeros((0, 6)), matcher).shape == (0,)
