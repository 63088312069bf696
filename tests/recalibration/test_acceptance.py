"""The epipolar errors of a candidate, and what parts of images say."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from fixtures import SAD_48
from hypothesis import given, strategies as st
from parts_of_repairs import row_errors_and_misfit, share_lost

from stereorecal import difference, health, make_pair, recalibrate
from stereorecal.recalibration import Condition, Reason
from stereorecal.synthetic import decalibrate


def test_row_errors_are_means_over_tiles_of_medians():
    rng = np.random.default_rng(0)
    before, after, tile = rng.normal(0, 3, 480), rng.normal(0, 1, 480), rng.integers(0, 48, 480)
    found, _ = row_errors_and_misfit(before, after, tile)
    for error, rows in ((found.before, before), (found.after, after)):
        assert error == pytest.approx(np.mean([np.median(np.abs(rows[tile == one])) for one in np.unique(tile)]))


@given(st.lists(st.tuples(st.integers(0, 500), st.integers(0, 500)), min_size=1, max_size=48))
def test_a_candidate_that_matches_more_everywhere_loses_nothing(counts):
    """And of two halves of an image, each of which fits a rig of its own, it would lose one."""
    before, more = np.array(counts).T
    assert share_lost(np.stack([before, before + more])[:, None]) == 0.0
    halves = np.stack([np.r_[before, more], np.r_[more, before]])[:, None]
    assert share_lost(halves) == pytest.approx(np.maximum(before - more, more - before).sum() / max(halves[1].sum(), 1))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("degrees", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["street", "harbour"])
def test_a_calibration_without_the_lenses_is_not_repaired(scene, kind, degrees):
    """A file of rectified images beside images as taken: yaw would pay for the distortion, and depth with it."""
    shown = scene(kind, 0, (640, 480))
    left, right = (replace(camera, distortion=np.zeros(5)) for camera in (shown.rig.left, shown.rig.right))
    bare = replace(shown.rig, left=left, right=right)
    found = recalibrate(decalibrate(bare, jax.random.key(3), degrees, 0.008 * degrees), shown.pairs)
    assert found.reason is Reason.OTHER_LENSES
    assert "as taken, or rectified, both" in found.advice


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["harbour", "coast"])
def test_half_of_an_image_that_moved_is_no_reason_to_change_a_calibration(scene, kind):
    """It is as many pixels as the other half, and fits a rig of its own; nobody can tell which is right."""
    seen = scene(kind, 1, (320, 240))
    right = np.array(seen.pairs[0].right)
    right[:, 160:] = np.roll(right, -4, axis=0)[:, 160:]
    moved = make_pair(np.array(seen.pairs[0].left, np.uint8), right.astype(np.uint8))
    turned = seen.rig.with_extrinsics(seen.rig.extrinsics + np.radians([0.3, 0, 0, 0, 0, 0]))
    assert not recalibrate(seen.rig, [moved], matcher=SAD_48).accepted
    done = recalibrate(turned, [moved], matcher=SAD_48)
    assert (health(turned, [moved], matcher=SAD_48).condition is Condition.REPAIR) <= done.accepted
    if done.accepted:  # as one of the halves has it
        from_truth = difference(done.rig, seen.rig, view=done.view).row_differences
        assert min(abs(np.nanmedian(from_truth)), abs(abs(np.nanmedian(from_truth)) - 4.0)) < 0.5


def test_beyond_the_reach_is_said(scene):
    shown = scene("coast", 1, (320, 240))
    far = shown.rig.with_extrinsics(shown.rig.extrinsics + np.append(np.radians([1.8, 1.8, 1.5]), np.zeros(3)))
    found = recalibrate(far, shown.pairs, matcher=SAD_48, reach=(0.5, 0.01))
    assert found.reason is Reason.REACH_EDGE
    assert found.rig is far
    assert "larger reach" in found.advice
