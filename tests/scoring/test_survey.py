"""The survey brings a rig that is far off near enough for a search."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from stereorecal import InputError
from stereorecal.geometry import Camera, view
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
    found = survey(pyramid(bad, given_scene.pairs), bad.extrinsics, 2.0 * REACH, yaw=True)
    assert np.abs(found.offset + drift)[[0, 2]].max() < np.radians(1.5)
    wanted = max(-drift[1], 0.0)  # the other yaw makes all seem near, where it is matched as it is
    assert abs(found.offset[1] - wanted) < np.radians(2.5)
    repaired = recalibrate(bad, given_scene.pairs, reach=(6.0, 0.06))
    assert repaired.accepted
    assert np.degrees(np.abs(repaired.rig.extrinsics - rig.extrinsics)[[0, 2]]).max() < 0.3


@pytest.fixture(scope="module")
def near():
    """Scenes of cameras that stand close together, so that a yaw takes nearly all points beyond infinity."""
    wide = default_rig().resized((240, 180))
    rig = wide.with_extrinsics(wide.extrinsics * [1.0, 1.0, 1.0, 0.2, 0.2, 0.2])
    return {kind: render(kind, 1, rig=rig) for kind in ("street", "coast", "harbour")}


def off(shown, *degrees):
    """The rig, and what has to be added to its extrinsics."""
    missing = np.radians([*degrees, 0.0, 0.0, 0.0])
    return shown.rig.with_extrinsics(shown.rig.extrinsics - missing), missing


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", ["street", "coast", "harbour"])
def test_a_yaw_that_takes_far_points_beyond_infinity_is_found(near, kind):
    """And one of the other sign is harmless."""
    shown = near[kind]
    for yaw in (2.4, -2.4):
        bad, missing = off(shown, 1.0, yaw, 0.0)
        found = survey(pyramid(bad, shown.pairs), bad.extrinsics, REACH, yaw=True)
        assert abs(found.offset[1] - max(missing[1], 0.0)) < np.radians(0.7)
        repaired = recalibrate(bad, shown.pairs)
        assert repaired.accepted
        assert np.degrees(np.abs(repaired.rig.extrinsics - shown.rig.extrinsics)[[0, 2]]).max() < 0.3


@pytest.mark.parametrize("rig", ["toed in", "wide"])
def test_a_yaw_of_other_views(near, rig):
    """Infinity need not be at disparity 0; at the borders of a wide view, a yaw moves points farther."""
    given = near["street"].rig
    if rig == "toed in":
        given = given.with_extrinsics(given.extrinsics - np.radians([0.0, 8.0, 0.0, 0.0, 0.0, 0.0]))
    else:
        camera = Camera((240, 180), np.array([[69.0, 0.0, 119.5], [0.0, 69.0, 89.5], [0.0, 0.0, 1.0]]))
        given = replace(given, left=camera, right=camera)
    shown = render("street", 1, rig=given)
    for yaw in (0.0, 2.4):
        bad, missing = off(shown, 0.0, yaw, 0.0)
        images = pyramid(bad, shown.pairs, view(bad, zero_disparity=False))
        assert (images.view.at_infinity > 20.0) == (rig == "toed in")
        assert abs(survey(images, bad.extrinsics, REACH, yaw=True).offset - missing).max() < np.radians(0.4)


def test_a_yaw_that_is_not_free_is_not_searched(near):
    """Pitch and roll begin where the survey found them all the same, and the range holds what a yaw takes away."""
    shown = near["street"]
    bad, missing = off(shown, 2.0, 2.4, 0.0)
    images = pyramid(bad, shown.pairs)
    found, turned = (survey(images, bad.extrinsics, REACH, yaw=yaw) for yaw in (False, True))
    assert abs(found.offset - missing)[0] < np.radians(1.0)
    assert not found.offset[1]
    assert turned.offset[1]
    least = images.view.focal * np.tan(REACH)
    assert least < found.with_range(SAD(), REACH).num_disparities <= turned.with_range(SAD(), REACH).num_disparities
    began = recalibrate(bad, shown.pairs, free=("pitch", "roll")).stages[0].began
    np.testing.assert_allclose(began.extrinsics, bad.extrinsics + found.offset)


def test_exchanged_images_have_no_yaw(near):
    """All of them lies beyond infinity, too."""
    shown = near["harbour"]
    (pair,) = shown.pairs
    exchanged = pyramid(shown.rig, [Pair(pair.right, pair.left)])
    with suppress(InputError):
        assert not survey(exchanged, shown.rig.extrinsics, REACH, yaw=True).offset[1]


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
