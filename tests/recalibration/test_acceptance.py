"""The verdict in words: where the count is all there is, and the row errors that go with a candidate."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import SAD, make_pair, recalibrate
from stereorecal.objectives import Reach
from stereorecal.recalibration import Condition, Reason, RowErrors, RowResiduals, health
from stereorecal.recalibration._acceptance import drift_within_reach, loses_regions, row_errors, verdict_on_count
from stereorecal.synthetic import default_rig

SAD_48 = SAD(num_disparities=48)  # which other files have compiled


def test_more_matches_are_better():
    assert verdict_on_count(5, 6, signal=True) is Reason.MORE_MATCHES


def test_what_is_healthy():
    assert {reason for reason in Reason if reason.healthy} == {
        Reason.IMPROVED,
        Reason.MORE_MATCHES,
        Reason.ALREADY_GOOD,
        Reason.RANGES,
        Reason.MOTION,
    }


@pytest.mark.parametrize(("before", "after"), [(0, 0), (7, 7), (7, 6)])
def test_the_count_alone_must_rise(before, after):
    assert verdict_on_count(before, after, signal=True) is Reason.NOT_IMPROVED
    assert verdict_on_count(before, after, signal=False) is Reason.TOO_LITTLE_TEXTURE


def paired(before: np.ndarray, after: np.ndarray) -> RowErrors:
    """Of one frame, each tile at its own place."""
    return row_errors(RowResiduals(residual=after, start_residual=before, tile=np.arange(len(before))))


def test_significance_is_that_of_a_paired_test():
    rng = np.random.default_rng(0)
    before = rng.uniform(0.5, 3, 48)
    after = before - 0.1 + rng.normal(0, 0.05, 48)
    found = paired(before, after)
    gain = before - after
    assert found.before == pytest.approx(before.mean())
    assert found.after == pytest.approx(after.mean())
    assert found.significance == pytest.approx(gain.mean() / (gain.std(ddof=1) / np.sqrt(48)))
    assert found.significance > 3
    assert paired(after, before).significance == pytest.approx(-found.significance)
    assert paired(before, before).significance == 0.0


def test_one_tile_proves_nothing():
    assert paired(np.array([5.0]), np.array([0.1])).significance == 0.0


def test_what_is_lost_in_places_is_not_made_good_in_others():
    """Of two halves of an image, each of which fits a rig of its own, a candidate takes one and leaves the other."""
    left, right = np.r_[np.full(24, 100), np.full(24, 5)], np.r_[np.full(24, 5), np.full(24, 100)]
    assert loses_regions(np.array([left, right])[:, None])
    assert not loses_regions(np.array([left // 10, right])[:, None])  # chance matches
    assert not loses_regions(np.array([left, left + right])[:, None])


@given(st.lists(st.tuples(st.integers(0, 500), st.integers(0, 500)), min_size=1, max_size=48))
def test_a_candidate_that_matches_more_everywhere_loses_nothing(counts):
    before, more = np.array(counts).T
    assert not loses_regions(np.stack([before, before + more])[:, None])


@pytest.mark.slow(after=0)
@pytest.mark.parametrize("kind", ["harbour", "coast"])
def test_half_of_an_image_that_moved_is_no_reason_to_change_a_calibration(scene, kind):
    """It is as many pixels as the other half, and fits a rig of its own; nobody can tell which is right."""
    seen = scene(kind, 1, (640, 480))
    right = np.array(seen.pairs[0].right)
    right[:, 320:] = np.roll(right, -4, axis=0)[:, 320:]
    moved = make_pair(np.array(seen.pairs[0].left, np.uint8), right.astype(np.uint8))
    turned = seen.rig.with_extrinsics(seen.rig.extrinsics + np.radians([0.3, 0, 0, 0, 0, 0]))
    assert not recalibrate(seen.rig, [moved]).accepted
    done = recalibrate(turned, [moved])
    assert (health(turned, [moved]).condition is Condition.REPAIR) <= done.accepted
    if done.accepted:  # as one of the halves has it
        pitch = float(done.rig.extrinsics[0] - seen.rig.extrinsics[0])
        assert min(abs(pitch), abs(pitch - np.arctan(4 / float(seen.rig.left.focal[1])))) < np.radians(0.1)


def test_beyond_the_reach_is_said_and_what_a_larger_one_finds_is_right(scene):
    shown = scene("coast", 1, (320, 240))
    far = shown.rig.with_extrinsics(shown.rig.extrinsics + np.append(np.radians([1.8, 1.8, 1.5]), np.zeros(3)))
    found = recalibrate(far, shown.pairs, matcher=SAD_48, reach=(0.5, 0.01))
    assert found.reason is Reason.REACH_EDGE
    assert "larger reach" in str(found)
    apart = recalibrate(far, shown.pairs, matcher=SAD_48).rig.extrinsics[:3] - shown.rig.extrinsics[:3]
    np.testing.assert_allclose(np.degrees(apart), 0.0, atol=0.15)


def test_the_length_of_the_baseline_is_no_drift():
    rig = default_rig().with_extrinsics(np.array([0.01, -0.02, 0.005, -0.2, 0.004, -0.006]))
    longer = rig.with_extrinsics(rig.extrinsics * np.array([1.0, 1.0, 1.0, 1.2, 1.2, 1.2]))
    np.testing.assert_allclose(drift_within_reach(rig, longer, Reach()), 0.0, atol=1e-9)
