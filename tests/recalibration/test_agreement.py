"""Frames of one rig agree; those of another are left out and named."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from spoiled_rows import nothing, seen

import stereorecal as sr
from stereorecal.recalibration._agreement import MOST_APART, disagreeing
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence

FRAMES = 5


def with_others(seed: int, *apart: tuple[int, tuple[float, ...]]) -> Evidence:
    """Five frames; some of them of rigs that are so far off, in degrees and percent."""
    found = seen(nothing, frames=FRAMES, seed=seed)
    frame = found.tile // TILES_OF_A_FRAME
    residual = found.residual.copy()
    for index, off in apart:
        residual[frame == index] += found.jacobian[frame == index] @ np.array(off)
    return replace(found, residual=residual)


@settings(max_examples=20)
@given(seed=st.integers(0, 999))
def test_frames_of_one_rig_agree(seed):
    assert disagreeing(with_others(seed)) == ()


@settings(max_examples=10)
@given(seed=st.integers(0, 99), which=st.integers(0, 4), pitch=st.sampled_from([-0.2, 0.1, 0.5]))
def test_one_of_another_rig_is_named(seed, which, pitch):
    assert disagreeing(with_others(seed, (which, (pitch, 0.0, 0.0, 0.0, 0.0)))) == (which,)


def test_one_frame_has_nobody_to_disagree_with():
    assert disagreeing(seen(nothing)) == ()


def test_too_many_disagree():
    motions = [(i, (0.3 * i, 0.0, 0.2 * i * (-1) ** i, 0.0, 0.0)) for i in range(1, FRAMES)]
    assert len(disagreeing(with_others(0, *motions))) > MOST_APART * FRAMES


@pytest.fixture
def street(scene):
    return scene("street", 0, (320, 240), 4)


def test_a_frame_that_is_late_is_left_out(street):
    """Its right image is three rows off: the other three frames are used, and the rig is theirs."""
    pairs = list(street.pairs)
    pairs[2] = sr.Pair(pairs[2].left, np.roll(pairs[2].right, 2, axis=0), "late")
    bad = street.rig.with_extrinsics(street.rig.extrinsics + np.radians([0.6, 0.2, -0.5, 0, 0, 0]))
    solution = sr.recalibrate(bad, pairs)
    assert solution.left_out == ("late",)
    assert solution.accepted
    error = np.degrees(solution.rig.extrinsics[:3] - street.rig.extrinsics[:3])
    assert np.abs(error).max() < 0.03
    assert "late" in str(solution)


def test_frames_of_different_rigs_are_refused(street):
    pairs = [sr.Pair(p.left, np.roll(p.right, 2 * i, axis=0), p.name) for i, p in enumerate(street.pairs)]
    solution = sr.recalibrate(street.rig, pairs)
    assert solution.reason is sr.Reason.FRAMES_DISAGREE
    assert solution.rig is street.rig
