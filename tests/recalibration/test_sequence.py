"""Pair after pair: each repair starts where the one before it ended; the path says where a repair stood."""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest

import stereorecal as sr
from stereorecal import InputError
from stereorecal.objectives import Reach
from stereorecal.strategies import strategy

OPTIONS = {
    "matcher": sr.SAD(num_disparities=24),
    "schedule": sr.Schedule.count(strategy("compass"), 0.5),
    "reach": Reach(2.0, 0.02),
}


def in_order(rig, pairs, **options):
    """The solutions of single pairs, each of which starts where the one before it ended."""
    scenes = [sr.Scene(str(number), rig, (pair,)) for number, pair in enumerate(pairs)]
    return [repair.solution for repair in sr.recalibrate_many(scenes, start="previous", **options)]


@pytest.fixture(scope="module")
def drifted(scene):
    rig = scene().rig
    return rig.with_extrinsics(rig.extrinsics + np.array([*np.radians([0.7, 0.0, -0.9]), 0.0, 0.002, 0.0]))


@pytest.fixture(scope="module")
def solutions(scene, drifted):
    return in_order(drifted, scene(frames=3).pairs, **OPTIONS)


def test_each_starts_where_the_one_before_ended(scene, drifted, solutions):
    assert len(solutions) == 3
    np.testing.assert_array_equal(solutions[0].initial.extrinsics, drifted.extrinsics)
    for before, after in pairwise(solutions):
        np.testing.assert_array_equal(after.initial.extrinsics, before.rig.extrinsics)
    away = [np.abs(s.extrinsics - scene().rig.extrinsics)[[0, 2]].max() for s in (drifted, solutions[-1].rig)]
    assert away[1] < 0.5 * away[0]


def test_each_is_a_repair_of_its_own(scene, drifted, solutions):
    second = scene(frames=3).pairs[1]
    alone = sr.recalibrate(solutions[0].rig, [second], view=sr.view(drifted), **OPTIONS)
    np.testing.assert_array_equal(alone.rig.extrinsics, solutions[1].rig.extrinsics)
    assert solutions[0].view is solutions[1].view is solutions[2].view
    assert solutions[0].view.centre_row == sr.view(drifted).centre_row


def test_a_pair_that_shows_nothing_leaves_the_rig(scene, drifted):
    sea = scene("open-sea", 1, (320, 240)).pairs
    rig = drifted.resized((320, 240))
    (found,) = in_order(rig, sea, matcher=sr.SAD(num_disparities=64))
    assert not found.accepted
    assert found.rig is rig


def test_what_cannot_be_repaired_leaves_the_rig(scene, drifted):
    pairs = scene(frames=3).pairs
    first, last = (sr.Scene(name, drifted, (pair,)) for name, pair in (("a", pairs[0]), ("c", pairs[1])))
    found = sr.recalibrate_many([first, sr.Scene("b", None, ()), last], start="previous", **OPTIONS)
    assert [repair.solution is None for repair in found] == [False, True, False]
    assert found[2].solution.initial is found[0].solution.rig


def test_repairs_that_wait_for_each_other_share_nothing(scene, drifted):
    scenes = [sr.Scene("a", drifted, scene().pairs)]
    with ThreadPoolExecutor(1) as pool, pytest.raises(InputError, match="leave executor out"):
        sr.recalibrate_many(scenes, start="previous", executor=pool)
    with pytest.raises(InputError, match="free the extrinsics alone"):
        sr.recalibrate_many(scenes, start="previous", free=("extrinsics", "intrinsics"))
    with pytest.raises(InputError, match="unknown start 'prevoius'"):
        sr.recalibrate_many(scenes, start="prevoius")


def test_the_path_climbs_from_the_start_to_the_end(scene, solutions, drifted):
    path = solutions[0].path
    np.testing.assert_array_equal(path[0].extrinsics, drifted.extrinsics)
    np.testing.assert_allclose(path[-1].extrinsics, solutions[0].candidate.extrinsics, atol=1e-12)
    assert path[0].cost == 0
    assert all(a.cost < b.cost for a, b in pairwise(path))
    assert path[-1].cost <= solutions[0].cost.total
    matcher, pairs = OPTIONS["matcher"], scene(frames=3).pairs[:1]
    counts = [
        sr.score(drifted.with_extrinsics(p.extrinsics), pairs, matcher=matcher, view=solutions[0].view, scale=0.5).count
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
