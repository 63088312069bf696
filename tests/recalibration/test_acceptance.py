"""The verdict in words: where the count is all there is, and the row errors that go with a candidate."""

import numpy as np
import pytest

from stereorecal.recalibration import Reason, RowErrors
from stereorecal.recalibration._acceptance import behind, compared, verdict_on_count
from stereorecal.recalibration._evidence import Evidence

PRIOR = 0.2


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
    nothing = np.zeros(len(before))
    facts = Evidence(np.zeros(5), np.zeros((len(before), 5)), *[nothing] * 4, np.arange(len(before)), PRIOR)
    return compared(facts, before, after)


def test_significance_is_that_of_a_paired_test():
    rng = np.random.default_rng(0)
    before = rng.uniform(0, 3, 48)
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


@pytest.mark.parametrize(
    ("before", "after", "rows_before", "rows_after", "lost"),
    [
        (1000, 1000, 0.2, 0.2, False),
        (1000, 1500, 0.2, 0.1, False),
        (1000, 900, 0.2, 0.1, True),  # a tenth of the matches, whatever the rows say
        (1000, 1500, 0.1, 0.3, True),  # rows, whatever the matches say
        (1000, 999, 0.2, 0.201, False),
    ],
)
def test_behind_what_is_there_already(before: int, after: int, rows_before: float, rows_after: float, lost: bool):
    assert behind(before, after, rows_before, rows_after) == lost
