"""Frames of one rig agree, whatever their order; those of another are left out and named."""

from dataclasses import asdict, replace

import cv2
import numpy as np
import pytest
from spoiled import fog

import stereorecal as sr
from stereorecal.recalibration import Condition


@pytest.fixture
def street(scene):
    return scene("street", 0, (320, 240), 4)


def one_late(street: sr.Scene) -> sr.Scene:
    """The right image of the third frame is two rows off, and the rig is out."""
    pairs = list(street.pairs)
    pairs[2] = sr.Pair(pairs[2].left, np.roll(pairs[2].right, 2, axis=0), "late")
    bad = street.rig.with_extrinsics(street.rig.extrinsics + np.radians([0.6, 0.2, -0.5, 0, 0, 0]))
    return replace(street, rig=bad, pairs=tuple(pairs))


def rows_off(rig: sr.StereoRig, true: sr.StereoRig) -> float:
    return sr.difference(rig, true).row_error_median


def test_frames_of_one_rig_agree(street):
    found, looked = (look(street.rig, street.pairs[:2]) for look in (sr.recalibrate, sr.health))
    assert found.reason is looked.reason is sr.Reason.ALREADY_GOOD
    assert found.left_out == found.disagreeing == looked.disagreeing == ()
    assert found.used == (0, 1)
    assert "disagree" not in str(found)
    np.testing.assert_allclose(looked.uncertainty.interval, found.uncertainty.interval, rtol=1e-6)
    assert asdict(looked.cost) == pytest.approx(asdict(found.cost)), "the survey of the disparity range is part of it"


@pytest.mark.slow
def test_a_frame_that_is_late_is_left_out(street):
    """The other three frames are used, and the rig is theirs, in whichever order they come."""
    late = one_late(street)
    found, reversed_ = (sr.recalibrate(late.rig, pairs) for pairs in (late.pairs, late.pairs[::-1]))
    for solution in (found, reversed_):
        assert solution.left_out == ("late",)
        assert solution.accepted
        assert rows_off(solution.rig, street.rig) < 0.1
        assert "late" in str(solution)
    assert_counts_of_kept(found, late.pairs)


@pytest.mark.slow
def test_frames_of_another_rig_are_left_out_also_where_they_show_the_most_texture(scene):
    """What looks at few frames looks at those."""
    given = scene("street", 3, (320, 240), 7)
    turned = given.rig.with_extrinsics(given.rig.extrinsics + np.radians([0.6, 0.0, 0.2, 0, 0, 0]))
    other, pairs = sr.synthetic.render("street", 3, rig=turned, frames=7), list(given.pairs)
    for number in (1, 5):
        of_other = (other.pairs[number].left, other.pairs[number].right)
        left, right = (np.clip(128 + 1.6 * (np.asarray(image) - 128), 0, 255) for image in of_other)
        pairs[number] = sr.make_pair(left, right, name=f"other {number}")
    found = sr.recalibrate(given.rig, pairs)
    assert found.left_out == ("other 1", "other 5")
    assert found.reason is sr.Reason.ALREADY_GOOD


def assert_counts_of_kept(solution: sr.Solution, pairs) -> None:
    kept, how = [pairs[index] for index in solution.used], {"matcher": solution.matcher, "view": solution.view}
    assert len(kept) < len(pairs)
    assert solution.score_before == sr.score(solution.initial, kept, **how)
    if solution.candidate.left is solution.initial.left:
        assert solution.score_after == sr.score(solution.candidate, kept, **how)


def assert_of_different_rigs(rig: sr.StereoRig, pairs) -> None:
    """A repair and a look say so, and the rig stays."""
    solution, looked = sr.recalibrate(rig, pairs), sr.health(rig, pairs)
    assert solution.reason is sr.Reason.FRAMES_DISAGREE
    assert solution.rig is rig
    assert not solution.left_out
    assert solution.disagreeing
    assert "different rigs" in solution.verdict
    assert f"disagree with others: {', '.join(solution.disagreeing)}" in str(solution)
    assert not looked.healthy
    if looked.reason is not sr.Reason.NO_MATCHES:  # a look matches under the given rig alone
        assert looked.condition is Condition.CANNOT_TELL
        assert "different rigs" in looked.verdict
        assert set(looked.disagreeing) < {pair.name for pair in pairs}


def test_two_frames_of_different_rigs(street):
    first, second = street.pairs[:2]
    assert_of_different_rigs(street.rig, [first, sr.Pair(second.left, np.roll(second.right, 3, axis=0), "other")])


def turned(pair: sr.Pair, rig: sr.StereoRig, pitch: float) -> sr.Pair:
    """As if the right camera stood so many degrees of pitch (and of roll) lower."""
    focal, centre = float(rig.right.matrix[0, 0]), np.asarray(rig.right.matrix)[:2, 2]
    turn = cv2.getRotationMatrix2D(tuple(centre.tolist()), pitch, 1.0)
    turn[1, 2] += focal * np.tan(np.radians(pitch))
    image = cv2.warpAffine(np.array(pair.right), turn, pair.size, borderMode=cv2.BORDER_REFLECT)
    return sr.Pair(pair.left, image, f"{pair.name} at {pitch}")


@pytest.mark.slow
@pytest.mark.parametrize("pitches", [(0.0, 1.2), (0.0, 1.2, -1.2), (0.0, 0.0, 1.2, 1.2)])
def test_frames_so_far_apart_that_some_match_nothing(street, pitches):
    """They leave no correspondences under the candidate, and are no less apart for it."""
    pairs = [turned(pair, street.rig, pitch) for pair, pitch in zip(street.pairs, pitches, strict=False)]
    assert_of_different_rigs(street.rig, pairs)


@pytest.mark.slow
def test_one_frame_from_before_a_bump(street):
    """Three after it: the rig is theirs, and what the first no longer matches is no misfit."""
    pairs = [turned(pair, street.rig, 1.2 if index else 0.0) for index, pair in enumerate(street.pairs)]
    solution = sr.recalibrate(street.rig, pairs)
    assert solution.accepted
    assert solution.left_out == (pairs[0].name,)
    assert solution.row_errors.before > 5.0
    assert solution.row_errors.after < 0.25


@pytest.mark.slow
def test_a_frame_that_shows_nothing_has_no_say(street):
    blank = fog()
    assert sr.recalibrate(street.rig, [*street.pairs[:2], blank]).left_out == ()
    conflict = [turned(street.pairs[0], street.rig, 0.0), turned(street.pairs[1], street.rig, 1.2), blank]
    assert sr.recalibrate(street.rig, conflict).reason is sr.Reason.FRAMES_DISAGREE
