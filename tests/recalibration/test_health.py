"""The verdict on a calibration as it is, and where its limits are."""

import json

import numpy as np
import pytest

from stereorecal.matching import SAD, SGBM
from stereorecal.recalibration import Condition, Health, health
from stereorecal.recordings import Pair
from stereorecal.scoring.host import Score, score

SAD_48 = SAD(num_disparities=48)


@pytest.fixture
def under(scene):
    """under(degrees of pitch): the health of a rendered rig that is turned so far from the truth."""

    def look(pitch: float, matcher=SAD_48) -> Health:
        given = scene("harbour", 0, (320, 240))
        turned = given.rig.extrinsics + np.array([np.radians(pitch), 0, 0, 0, 0, 0])
        return health(given.rig.with_extrinsics(turned), given.pairs, matcher=matcher)

    return look


@pytest.mark.parametrize("matcher", [SAD_48, SGBM(num_disparities=48)], ids=["sad", "sgbm"])
def test_the_truth_is_healthy(under, matcher):
    found = under(0.0, matcher)
    assert found.condition is Condition.HEALTHY
    assert found.healthy
    assert found.row_error < 0.15
    assert found.covered > 0.4


def test_rows_apart(under):
    """0.1 degrees are half a row here."""
    found = under(0.1)
    assert found.condition is Condition.ROWS_APART
    assert found.row_error == pytest.approx(np.radians(0.1) * 300, abs=0.1)
    assert found.covered > 0.4


@pytest.mark.parametrize("pitch", [-2.0, 0.8, 2.0])
def test_far_out_many_pixels_match_and_hardly_one_is_right(under, pitch):
    found = under(pitch)
    assert found.score.fraction > 0.15
    assert found.condition is Condition.TOO_FEW_MATCHES


def test_the_score_is_that_of_score(scene, under):
    given = scene("harbour", 0, (320, 240))
    assert under(0.0).score == score(given.rig, given.pairs, matcher=SAD_48)


def test_nothing_to_match(scene):
    fog = np.full((240, 320), 128.0, np.float32)
    fog[0, 0] = 129.0
    other = fog[::-1].copy()
    found = health(scene("harbour", 0, (320, 240)).rig, [Pair(fog, other)], matcher=SAD_48)
    assert found.condition is Condition.TOO_FEW_MATCHES
    data = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert data["row_error_px"] is None
    assert data["count"] == 0


@pytest.mark.parametrize(
    ("rows", "covered", "condition"),
    [
        (0.3, 0.1, Condition.HEALTHY),
        (0.31, 0.1, Condition.ROWS_APART),
        (0.0, 0.099, Condition.TOO_FEW_MATCHES),
        (float("nan"), 0.0, Condition.TOO_FEW_MATCHES),
    ],
)
def test_limits(rows, covered, condition):
    found = Health(Score(1, 2), rows, covered)
    assert found.condition is condition
    assert found.healthy == (condition is Condition.HEALTHY)
    assert condition.value in str(found)
