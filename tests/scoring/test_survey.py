"""The survey brings a rig that is far off near enough for a search."""

import numpy as np
import pytest

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.recalibration import health, recalibrate
from stereorecal.recordings import Pair
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import score, survey
from stereorecal.synthetic import default_rig, render

REACH = np.radians(3.0)


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("signs", [(1, 1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize("kind", ["harbour", "street"])
def test_finds_pitch_and_roll(scene, kind, signs):
    given_scene = scene(kind, 1)
    rig = given_scene.rig
    drift = np.radians([2.4 * signs[0], 0.0, 2.0 * signs[1], 0.0, 0.0, 0.0])
    bad = rig.with_extrinsics(rig.extrinsics + drift)
    found = survey(pyramid(bad, given_scene.pairs), bad.extrinsics, REACH)
    assert np.abs(found.offset + drift)[[0, 2]].max() < np.radians(1.0)
    assert not found.offset[[1, 3, 4, 5]].any()
    better = bad.with_extrinsics(bad.extrinsics + found.offset)
    counts = [score(r, given_scene.pairs, matcher=SAD(num_disparities=24), view=view(bad)).count for r in (bad, better)]
    assert counts[1] > 1.5 * counts[0]


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, -1, 1), (1, -1, -1)])
@pytest.mark.parametrize("kind", ["harbour", "coast"])
def test_a_wider_reach_is_searched(scene, kind, signs):
    given_scene = scene(kind, 1)
    rig = given_scene.rig
    drift = np.radians([*(np.array([4.5, 5.0, 4.0]) * signs), 0.0, 0.0, 0.0])
    bad = rig.with_extrinsics(rig.extrinsics + drift)
    found = survey(pyramid(bad, given_scene.pairs), bad.extrinsics, 2.0 * REACH)
    assert np.abs(found.offset + drift)[[0, 2]].max() < np.radians(1.5)
    if signs[1] < 0:  # the other yaw makes all seem near, where it is matched as it is
        assert np.abs(found.offset + drift)[1] < np.radians(2.5)
    assert recalibrate(bad, given_scene.pairs, reach=(6.0, 0.06)).accepted


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", ["street", "coast", "harbour"])
def test_a_yaw_that_takes_far_points_beyond_infinity_is_found(kind):
    """Of cameras that stand close together nearly all points lie there, and a yaw of the other sign is harmless."""
    wide = default_rig().resized((160, 120))
    rig = wide.with_extrinsics(wide.extrinsics * [1.0, 1.0, 1.0, 0.2, 0.2, 0.2])
    pairs = render(kind, 1, rig=rig).pairs
    for yaw in np.radians([2.4, -2.4]):
        bad = rig.with_extrinsics(rig.extrinsics - [np.radians(1.0), yaw, 0.0, 0.0, 0.0, 0.0])
        found = survey(pyramid(bad, pairs), bad.extrinsics, REACH)
        assert abs(found.offset[1] - max(yaw, 0.0)) < np.radians(0.7)
        assert np.quantile(found.disparities, 0.05) >= -1.0
        assert recalibrate(bad, pairs).accepted


def test_a_rig_that_is_right_is_left_alone(scene):
    """Or taken as it is, if it is said to be aligned."""
    images, extrinsics = pyramid(scene().rig, scene().pairs), scene().rig.extrinsics
    assert np.abs(survey(images, extrinsics, REACH).offset).max() < np.radians(0.8)
    found = survey(images, extrinsics, REACH, aligned=True)
    assert not found.offset.any()
    assert found.with_range(SAD(), 0.0).num_disparities < found.with_range(SAD(), REACH).num_disparities
    assert found.with_range(SAD(num_disparities=7), REACH).num_disparities == 7
    assert found.with_range(SAD(min_disparity=90), 0.0).num_disparities == 16  # never negative


def test_where_nothing_matches_more_it_begins_at_the_given_rig(scene):
    shown = scene()
    noise = np.random.default_rng(0).uniform(0, 255, (2, *np.shape(shown.pairs[0].left))).astype(np.float32)
    grey = np.full_like(noise, 128.0)
    grey[:, 0, :2] = [(0.0, 255.0), (255.0, 0.0)]  # no constant images, and nothing to match
    assert not survey(pyramid(shown.rig, [Pair(*grey)]), shown.rig.extrinsics, REACH).offset.any()
    found = health(shown.rig, [Pair(*noise)], matcher=SAD(num_disparities=48))
    assert found.candidate is found.initial
