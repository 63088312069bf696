"""The path says where a repair stood."""

from itertools import pairwise

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.objectives import Reach
from stereorecal.strategies import strategy

OPTIONS = {
    "matcher": sr.SAD(num_disparities=24),
    "schedule": sr.Schedule.count(strategy("compass"), 0.5),
    "reach": Reach(2.0, 0.02),
}


@pytest.fixture(scope="module")
def drifted(scene):
    rig = scene().rig
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians([0.7, 0.0, -0.9]), 0.0, 0.002, 0.0]))


def test_the_path_climbs_from_the_start_to_the_end(scene, drifted):
    matcher, pairs = OPTIONS["matcher"], scene().pairs
    solution = sr.recalibrate(drifted, pairs, prior="exact", **OPTIONS)
    path = solution.path
    np.testing.assert_array_equal(path[0].extrinsics, drifted.extrinsics)
    np.testing.assert_allclose(path[-1].extrinsics, solution.candidate.extrinsics, atol=1e-12)
    assert path[0].cost == 0
    assert all(a.cost < b.cost for a, b in pairwise(path))
    assert path[-1].cost <= solution.cost.total
    counts = [
        sr.score(drifted.with_extrinsics(p.extrinsics), pairs, matcher=matcher, view=solution.view, scale=0.5).count
        for p in path
    ]
    assert counts == sorted(counts)
    assert counts[0] < counts[-1]


def test_the_path_of_the_default_schedule_has_the_end_of_every_stage(scene):
    rig = scene(size=(320, 240)).rig
    start = rig.with_extrinsics(rig.extrinsics + np.array([*np.radians([0.7, 0.3, -0.9]), 0.0, 0.002, 0.0]))
    solution = sr.recalibrate(start, scene(size=(320, 240)).pairs)
    path = solution.path
    np.testing.assert_allclose(path[-1].extrinsics, solution.candidate.extrinsics, atol=1e-12)
    cost, last = solution.cost, solution.stages[-1]
    assert cost.survey > 1
    np.testing.assert_allclose(path[-1].cost, cost.total - cost.judging - last.survey_cost)
    np.testing.assert_allclose(path[-2].cost + solution.stages[-2].survey_cost, path[-1].cost - last.cost)
