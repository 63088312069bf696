"""A region of a single pair that moved by some rows: it finds no match where the rest does, and yet bends the rig."""

from functools import cache

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import axis_errors

ROWS = 6
SAD_48 = sr.SAD(num_disparities=48)  # which other files have compiled


@pytest.fixture(scope="module")
def shown(scene):
    return scene("harbour", 1, (320, 240))


@pytest.fixture(scope="module")
def repaired(shown, scene):
    """repaired(spoilt): a rig that was a little off, by one pair whose right side moved up or down, or is of another
    scene, or is as it was."""
    off = shown.rig.with_extrinsics(shown.rig.extrinsics + np.radians([0.3, 0.1, -0.2, 0, 0, 0]))

    @cache
    def repair(spoilt: str) -> sr.Solution:
        right = np.array(shown.pairs[0].right)
        first = round(0.55 * right.shape[1])
        if spoilt in ("up", "down"):
            right[:, first:] = np.roll(right, -ROWS if spoilt == "up" else ROWS, axis=0)[:, first:]
        if spoilt == "another":
            right[:, first:] = scene("street", 1, (320, 240)).pairs[0].right[:, first:]
        return sr.recalibrate(off, sr.Pair(shown.pairs[0].left, right), matcher=SAD_48)

    return repair


@pytest.mark.parametrize("spoilt", ["up", "down"])
def test_what_moved_is_seen_and_bends_the_rig_by_less(shown, repaired, spoilt):
    """Without, the rig is off by .09 to .16° in pitch, and by .22 to .26° in roll."""
    found = repaired(spoilt)
    column = found.misfit.place % 8
    stood, moved = (np.median(found.misfit.after[some]) for some in (column < 3, column > 5))
    assert abs(stood) < 0.2
    assert abs(moved) == pytest.approx(ROWS, abs=0.5)
    error = axis_errors(found.candidate, shown.rig).rotation_deg
    assert error["pitch"] < 0.05
    assert error["roll"] < 0.2


def test_what_matches_nowhere_changes_nothing(shown, repaired):
    """Only the cost tells that it was looked for, and not where most of the texture matches."""
    found, whole = repaired("another"), repaired("not")
    assert found.accepted
    assert np.abs(found.misfit.after).max() < 1.0
    assert axis_errors(found.candidate, shown.rig).rotation_deg["pitch"] < 0.02
    assert found.search.cost.judging == pytest.approx(whole.search.cost.judging + 2.0, abs=0.1)
