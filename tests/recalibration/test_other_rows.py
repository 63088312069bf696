"""A part of a single pair that moved by some rows: windows do not match it where they match the rest."""

from functools import cache

import numpy as np
import pytest

import stereorecal as sr

ROWS = 6  # that the part moved by, up
SAD_48 = sr.SAD(num_disparities=48)  # which other files have compiled


@pytest.fixture(scope="module")
def repaired(scene):
    """repaired(share): a rig that was a little off, by one pair of which so much moved, on the right; and the truth."""

    @cache
    def repair(share: float):
        shown = scene("harbour", 1, (320, 240))
        off = shown.rig.with_extrinsics(shown.rig.extrinsics + np.radians([0.3, 0.1, -0.2, 0, 0, 0]))
        right = np.array(shown.pairs[0].right)
        first = round((1.0 - share) * right.shape[1])
        right[:, first:] = np.roll(right, -ROWS, axis=0)[:, first:]
        return sr.recalibrate(off, sr.Pair(shown.pairs[0].left, right), matcher=SAD_48), shown.rig

    return repair


def test_both_parts_are_seen_and_neither_is_surely_the_rig(repaired):
    found, true = repaired(0.45)
    column = found.misfit.place % 8
    stood, moved = (np.median(found.misfit.after[some]) for some in (column < 3, column > 5))
    assert abs(stood) < 0.2
    assert abs(moved) > ROWS - 0.7, "windows that match the rows of the rest see less"
    assert not found.accepted
    assert abs(np.degrees(found.candidate.extrinsics[0] - true.extrinsics[0])) < 0.07


def test_a_pair_of_which_nothing_moved_shows_its_own_rows_alone(repaired):
    found, _ = repaired(0.0)
    assert found.accepted
    assert np.abs(found.misfit.after).max() < 1.0


def test_matches_at_other_rows_cost_what_matches_cost(repaired):
    """Where most of the texture matches there are none."""
    (moved, _), (still, _) = repaired(0.45), repaired(0.0)
    assert moved.search.cost.judging == pytest.approx(still.search.cost.judging + 2.0, abs=0.1)
