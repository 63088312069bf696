"""Frames of one rig agree; those of another are left out and named."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import stereorecal as sr


@pytest.fixture
def street(scene):
    return scene("street", 0, (320, 240), 4)


def one_late(street: sr.Scene) -> sr.Scene:
    """The right image of the third frame is two rows off, and the rig is out."""
    pairs = list(street.pairs)
    pairs[2] = sr.Pair(pairs[2].left, np.roll(pairs[2].right, 2, axis=0), "late")
    bad = street.rig.with_extrinsics(street.rig.extrinsics + np.radians([0.6, 0.2, -0.5, 0, 0, 0]))
    return replace(street, rig=bad, pairs=tuple(pairs))


@pytest.mark.slow
def test_a_frame_that_is_late_is_left_out(street):
    """The other three frames are used, and the rig is theirs."""
    late = one_late(street)
    bad, pairs = late.rig, late.pairs
    solution = sr.recalibrate(bad, pairs)
    assert solution.left_out == ("late",)
    assert solution.accepted
    error = np.degrees(solution.rig.extrinsics[:3] - street.rig.extrinsics[:3])
    assert np.abs(error).max() < 0.03
    assert "late" in str(solution)
    assert_counts_of_kept(solution, pairs)


def assert_counts_of_kept(solution: sr.Solution, pairs) -> None:
    kept, how = [pairs[index] for index in solution.frames.used], {"matcher": solution.matcher, "view": solution.view}
    assert len(kept) < len(pairs)
    assert solution.score_before == sr.score(solution.initial, kept, **how)
    assert solution.score_after == sr.score(solution.candidate, kept, **how)


@pytest.mark.slow
def test_counts_of_a_joint_repair_are_of_the_frames_that_take_part(street, scene):
    late, other = one_late(street), scene("street", 1, (320, 240))
    repairs = sr.recalibrate_many([late, replace(other, rig=late.rig)], extrinsics="one")
    solution = repairs[0].solution
    assert solution.accepted
    assert_counts_of_kept(solution, late.pairs)


def test_frames_of_different_rigs_are_refused(street):
    pairs = [sr.Pair(p.left, np.roll(p.right, 2 * i, axis=0), p.name) for i, p in enumerate(street.pairs)]
    solution = sr.recalibrate(street.rig, pairs)
    assert solution.reason is sr.Reason.FRAMES_DISAGREE
    assert solution.rig is street.rig
    assert not solution.left_out
    assert solution.disagreeing
    assert "disagree with others" in str(solution)


def turned(pair: sr.Pair, rig: sr.StereoRig, pitch: float) -> sr.Pair:
    """As if the right camera stood so many degrees of pitch (and of roll) lower."""
    focal, centre = float(rig.right.matrix[0, 0]), np.asarray(rig.right.matrix)[:2, 2]
    turn = cv2.getRotationMatrix2D(tuple(centre.tolist()), pitch, 1.0)
    turn[1, 2] += focal * np.tan(np.radians(pitch))
    image = cv2.warpAffine(np.array(pair.right), turn, pair.size, borderMode=cv2.BORDER_REFLECT)
    return sr.Pair(pair.left, image, f"{pair.name} at {pitch}")


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("pitches", [(0.0, 1.2), (0.0, 1.2, -1.2), (0.0, 0.0, 1.2, 1.2)])
def test_frames_so_far_apart_that_some_match_nothing(street, pitches):
    """They leave no correspondences under the candidate, and are no less apart for it."""
    pairs = [turned(pair, street.rig, pitch) for pair, pitch in zip(street.pairs, pitches, strict=False)]
    solution = sr.recalibrate(street.rig, pairs)
    assert solution.reason is sr.Reason.FRAMES_DISAGREE
    found = sr.health(street.rig, pairs)
    assert not found.healthy
    assert "different rigs" in found.verdict


@pytest.mark.slow
def test_one_frame_from_before_a_bump(street):
    """Three after it: the rig is theirs, and what the first no longer matches is no misfit."""
    pairs = [turned(pair, street.rig, 1.2 if index else 0.0) for index, pair in enumerate(street.pairs)]
    solution = sr.recalibrate(street.rig, pairs)
    assert solution.accepted
    assert solution.left_out == (pairs[0].name,)
    alone = sr.recalibrate(street.rig, pairs[1:])
    assert np.abs(np.degrees(solution.change[:3] - alone.change[:3])).max() < 0.02


@pytest.mark.slow
def test_a_frame_that_shows_nothing_has_no_say(street):
    fog = np.full(street.pairs[0].left.shape, 128.0, np.float32)
    fog[0, 0] = 129.0
    blank = sr.Pair(fog, fog[::-1].copy(), "fog")
    assert sr.recalibrate(street.rig, [*street.pairs[:2], blank]).left_out == ()
    conflict = [turned(street.pairs[0], street.rig, 0.0), turned(street.pairs[1], street.rig, 1.2), blank]
    assert sr.recalibrate(street.rig, conflict).reason is sr.Reason.FRAMES_DISAGREE
