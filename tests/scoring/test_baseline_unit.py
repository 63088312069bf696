"""A count does not know whether the baseline is in metres, millimetres or miles."""

import numpy as np
from hypothesis import example, given, settings, strategies as st

from stereorecal.matching import SAD
from stereorecal.objectives import objective
from stereorecal.scoring.host import score

SAD_32 = SAD(num_disparities=32)


def in_unit(rig, factor):
    return rig.with_extrinsics(np.concatenate([rig.extrinsics[:3], rig.extrinsics[3:] * factor]))


@settings(max_examples=8)
@example(factor=1000.0)
@given(factor=st.floats(1e-3, 1e4))
def test_score(scene, factor):
    given_scene = scene()
    rig = given_scene.rig
    expected = score(rig, given_scene.pairs, matcher=SAD_32)
    assert score(in_unit(rig, factor), given_scene.pairs, matcher=SAD_32) == expected


def test_objective(scene):
    given_scene = scene()
    points = np.array([[0.0] * 5, [0.1, 0.2, -0.1, 0.5, -0.5], [0.0, 0.0, 0.0, -1.0, 1.0]])
    values = [
        objective(in_unit(given_scene.rig, factor), given_scene.pairs, matcher=SAD_32).batch(points)
        for factor in (1.0, 1000.0)
    ]
    assert np.array_equal(*values)
    assert len(set(values[0])) == 3
