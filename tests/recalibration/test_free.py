"""All that a calibration file holds may change, unless it is held: lenses that no extrinsics make up for come right."""

import pytest
from wrong_lenses import TRUE, over_the_view, wrong

import stereorecal as sr
from stereorecal.geometry import same_camera
from stereorecal.recalibration import IntrinsicsOutcome, Reason

WRONG = wrong({"k1": 0.03, "k2": -0.03, "p1": 0.003}, {"k1": -0.03, "k2": 0.02, "p2": -0.002})


def same_intrinsics(one: sr.StereoRig, other: sr.StereoRig) -> bool:
    return same_camera(one.left, other.left) and same_camera(one.right, other.right)


@pytest.fixture(scope="module")
def places(scene) -> list[sr.Pair]:
    kinds = [("harbour", 1), ("harbour", 2), ("street", 1)]
    return [scene(kind, seed, TRUE.left.size).pairs[0] for kind, seed in kinds]


@pytest.fixture(scope="module")
def found(places) -> sr.Solution:
    return sr.recalibrate(WRONG, places)


def test_lenses_that_no_extrinsics_make_up_for(found):
    assert found.accepted
    assert found.intrinsics.outcome is IntrinsicsOutcome.REFINED
    assert not same_intrinsics(found.rig, WRONG)
    assert over_the_view(WRONG) > 0.5
    assert over_the_view(found.rig) < 0.3 * over_the_view(WRONG)
    assert "--free extrinsics" in str(found)


def test_every_term_of_the_lenses_is_free(found):
    """But for the length of the baseline, which only more than images can tell."""
    kinds = ("f", "aspect", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
    assert {f"{side}.{kind}" for side in ("left", "right") for kind in kinds} <= set(found.intrinsics.names)
    assert "baseline" not in found.settings.free.names
    assert found.rig.extrinsics[3] == WRONG.extrinsics[3]


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("held", [{"prior": "exact"}, {"free": "extrinsics"}], ids=["exact", "free"])
def test_what_is_held_stays(places, held):
    kept = sr.recalibrate(WRONG, places, **held)
    assert kept.intrinsics is None
    assert same_intrinsics(kept.candidate, WRONG)
    assert "--free" not in kept.advice
    assert over_the_view(kept.rig) > 0.4  # which is what it costs


@pytest.mark.slow
def test_what_it_wrote_is_good_elsewhere(found, scene):
    assert sr.health(found.rig, scene("street", 0, TRUE.left.size).pairs).healthy


@pytest.mark.slow
def test_recordings_of_different_rigs_share_nothing(places):
    scenes = [sr.Scene(str(number), rig, (places[number],)) for number, rig in enumerate((TRUE, WRONG))]
    first, second = sr.recalibrate_many(scenes)
    assert first.solution.reason is Reason.ALREADY_GOOD
    assert (first.error, second.error) == (None, None)
