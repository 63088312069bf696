"""What a repair frees by itself: intrinsics only where frames of several places, each left out, bear it out."""

from dataclasses import replace

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.estimation import PLACES, frames_by_place, largest_loss
from stereorecal.geometry import changed_camera, same_camera, view
from stereorecal.recalibration import IntrinsicsOutcome, Reason, row_errors_of

TRUE = sr.synthetic.default_rig().resized((320, 240))
WRONG = replace(  # lenses that no extrinsics make up for
    TRUE,
    left=changed_camera(TRUE.left, {"f": 0.002, "cy": 0.7, "k1": 0.03, "k2": -0.03, "p1": 0.003}),
    right=changed_camera(TRUE.right, {"f": -0.003, "cy": -0.5, "k1": -0.03, "k2": 0.02, "p2": -0.002}),
)


def over_the_view(rig: sr.StereoRig) -> float:
    """Root mean square of the rows of points at ten baselines, pixels."""
    apart = row_errors_of(rig, TRUE, view(rig), np.linspace(0, 319, 17), np.linspace(0, 239, 13))[0]
    return float(np.sqrt(np.nanmean(apart**2)))


@pytest.fixture(scope="module")
def places(scene) -> list[sr.Pair]:
    kinds = [("harbour", 1), ("harbour", 2), ("coast", 1), ("street", 1)]
    return [scene(kind, seed, TRUE.left.size).pairs[0] for kind, seed in kinds]


@pytest.fixture(scope="module")
def found(places) -> sr.Solution:
    return sr.recalibrate(WRONG, places)


def test_lenses_that_no_extrinsics_make_up_for(found):
    assert found.accepted
    assert found.intrinsics is not None
    assert found.intrinsics.outcome is IntrinsicsOutcome.NEEDED
    assert "frames left out" in str(found)
    assert over_the_view(WRONG) > 0.5
    assert over_the_view(found.rig) < 0.3 * over_the_view(WRONG)


def test_it_expects_what_the_decision_expects(found):
    assert found.expected.rows_px == found.decision.rows_px[1, 0]
    assert found.expected.rows_px > 0.5 * over_the_view(found.rig)  # at ten baselines


@pytest.mark.slow  # as the laws of tests/decision
def test_what_it_wrote_is_good(found, places, scene):
    other = scene("street", 0, TRUE.left.size)
    assert not sr.health(found.rig, other.pairs).verdict.startswith("repair")
    assert sr.recalibrate(found.rig, places).reason is Reason.ALREADY_GOOD


@pytest.mark.slow
def test_extrinsics_alone_where_they_are_asked_for(places):
    held = sr.recalibrate(WRONG, places, free="extrinsics")
    assert held.intrinsics is None
    assert same_camera(held.rig.left, WRONG.left)


def test_one_place_proves_nothing(places):
    """However often it was photographed: noise differs, the errors of its rows do not."""
    rng = np.random.default_rng(0)

    def again(image: np.ndarray) -> np.ndarray:
        return (image + rng.normal(0.0, 1.0, image.shape)).astype(np.float32)

    pairs = [sr.Pair(again(places[0].left), again(places[0].right)) for _ in range(4)]
    found = sr.recalibrate(WRONG, pairs)
    assert found.intrinsics is None
    assert same_camera(found.candidate.left, WRONG.left)
    assert len(frames_by_place(found.estimate.shown)) == 1


def test_three_places_are_too_few(places):
    assert sr.recalibrate(WRONG, places[:3]).intrinsics is None


@pytest.mark.slow
def test_exact_intrinsics_stay(places):
    found = sr.recalibrate(WRONG, places, prior="exact")
    assert found.intrinsics is None


def test_frames_of_different_places(found):
    shown = found.estimate.shown
    assert sorted(frames_by_place(shown)) == [(frame,) for frame in np.unique(shown.frame).tolist()]


def test_the_largest_loss_is_of_frames_and_of_regions(found):
    shown = found.estimate.shown
    before = np.full(len(shown), 0.2)
    assert largest_loss(shown, before, 0.5 * before) == pytest.approx(-0.1)
    one = shown.frame == shown.frame[0]
    assert largest_loss(shown, before, np.where(one, -0.3, 0.1)) == pytest.approx(0.1)  # signs do not matter
    down, across = np.divmod(shown.place, PLACES[0])
    corner = (3 * down < PLACES[1]) & (3 * across < PLACES[0])
    assert largest_loss(shown, before, np.where(corner, 0.3, 0.1)) == pytest.approx(0.1)
    assert np.isnan(largest_loss(shown.of(shown.place < 60), before[shown.place < 60], before[shown.place < 60]))


@pytest.mark.slow
def test_recordings_of_a_rig_that_did_not_drift_between_them(places):
    scenes = [sr.Scene(pair.name, WRONG, (pair,)) for pair in places]
    each = sr.recalibrate_many(scenes)
    assert all(repair.solution.intrinsics is None for repair in each)
    one = sr.recalibrate_many(scenes, extrinsics="one")
    assert all(repair.solution.intrinsics.outcome is IntrinsicsOutcome.NEEDED for repair in one)
    assert over_the_view(one[0].solution.rig) < 0.3 * over_the_view(WRONG)


@pytest.mark.slow
def test_recordings_that_extrinsics_explain_share_nothing_more(places):
    turned = TRUE.with_extrinsics(TRUE.extrinsics + np.append(np.radians([0.3, -0.2, 0.3]), np.zeros(3)))
    repairs = sr.recalibrate_many([sr.Scene(pair.name, turned, (pair,)) for pair in places], extrinsics="one")
    assert all(repair.solution.accepted and repair.solution.intrinsics is None for repair in repairs)
