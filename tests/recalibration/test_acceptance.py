"""The verdict: one case for each reason, and what must never be accepted."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.recalibration import Reason, RowErrors
from stereorecal.recalibration._acceptance import Verdict, behind, compared, verdict, verdict_on_count
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence
from stereorecal.recalibration._misfit import Cause, Misfit
from stereorecal.scoring.host import Score

PRIOR = 0.2
EDGE = np.array([0.1, -0.99, 0.0, 0.0, 0.0])


def score(count: int) -> Score:
    return Score(count, 1_000_000)


def left_over(before=2.0, after=0.05, sway=0.0, error=0.01, chance=0.5, lost=0.0, regions=40) -> Misfit:
    """Regions whose rows lie so far apart: numbers, or one for each region."""
    place = np.arange(regions)
    medians = [np.broadcast_to(np.asarray(v, float), regions) * (-1.0) ** place for v in (before, after)]
    return Misfit(0 * place, place, *medians, np.full(regions, error), sway, chance, lost, Cause.REGIONS)


FITS = left_over()


def judged(
    before=200_000,
    after=None,
    rows=(0.2, 0.2, 0.0),
    z=0.1,
    left=FITS,
    places=48,
    covered=0.5,
    frames=1,
    scale=1.0,
    shift=1.0,
) -> Verdict:
    """In images that were measured at a scale, the limits are in their pixels."""
    z = np.broadcast_to(np.asarray(z, float), 5).copy()
    counts = np.array([before, before if after is None else after])
    tile = (np.arange(frames)[:, None] * TILES_OF_A_FRAME + np.arange(places)).reshape(-1)
    nothing = np.zeros(tile.size)
    facts = Evidence(z, np.zeros((tile.size, 5)), nothing, nothing, nothing, nothing, tile, PRIOR, scale)
    errors = RowErrors(float(rows[0]) / scale, float(rows[1]) / scale, float(rows[2]))
    sizes = {name: getattr(left, name) / scale for name in ("before", "after", "error", "sway")}
    return verdict(counts, errors, facts, replace(left, **sizes), covered, shift)


def some(share: float, value: float, others: float) -> np.ndarray:
    """Of forty regions."""
    return np.where(np.arange(40) < 40 * share, value, others)


BETTER = (0.5, 0.1, 10.0)
CASES = {
    "rows better, count the same": (Reason.IMPROVED, {"rows": BETTER}),
    "rows better, count a little lower": (Reason.IMPROVED, {"rows": BETTER, "after": 198_020}),
    "rows the same, count better": (Reason.IMPROVED, {"after": 204_000}),
    "rows a little worse, count better": (Reason.ALREADY_GOOD, {"after": 204_000, "rows": (0.2, 0.205, -1.0)}),
    "both better from nothing": (Reason.IMPROVED, {"before": 0, "after": 1_000, "rows": BETTER}),
    "nothing changed": (Reason.ALREADY_GOOD, {}),
    "a gain below a hundredth of a pixel": (Reason.ALREADY_GOOD, {"rows": (0.109, 0.100, 50.0)}),
    "a gain that may be chance": (Reason.ALREADY_GOOD, {"rows": (0.29, 0.2, 2.9)}),
    "a gain that may be chance, and rows far apart": (Reason.WORSE_ON_HELD_OUT, {"rows": (3.0, 2.0, 2.5)}),
    "count within its noise": (Reason.ALREADY_GOOD, {"after": 201_980}),
    "count within the noise of a small image": (Reason.ALREADY_GOOD, {"before": 14_500, "after": 14_700}),
    "count better in a small image": (Reason.IMPROVED, {"before": 14_500, "after": 14_900}),
    "the same frame ten times": (Reason.ALREADY_GOOD, {"before": 145_000, "after": 147_000, "frames": 10}),
    "count better, rows not": (Reason.ALREADY_GOOD, {"after": 240_000, "rows": (0.2, 0.215, -5.0)}),
    "count lost": (Reason.FEWER_MATCHES, {"rows": BETTER, "after": 197_980}),
    "count lost altogether": (Reason.FEWER_MATCHES, {"rows": BETTER, "after": 0}),
    "count lost, the old rows are good": (Reason.ALREADY_GOOD, {"rows": (0.2, 0.2, 0.0), "after": 180_000}),
    "rows worse than good ones": (Reason.ALREADY_GOOD, {"after": 400_000, "rows": (0.2, 0.25, -1.0)}),
    "rows worse": (Reason.WORSE_ON_HELD_OUT, {"after": 400_000, "rows": (0.5, 0.521, -1.0)}),
    "too little covered": (Reason.TOO_LITTLE_TEXTURE, {"covered": 0.09, "rows": BETTER, "after": 400_000}),
    "too few places": (Reason.TOO_LITTLE_TEXTURE, {"places": 5, "rows": BETTER, "after": 400_000}),
    "at the edge": (Reason.REACH_EDGE, {"rows": BETTER, "z": EDGE}),
    "at the other edge": (Reason.REACH_EDGE, {"rows": BETTER, "z": -EDGE}),
    "far on all axes together": (Reason.IMPLAUSIBLE, {"rows": BETTER, "z": 0.6}),
    "far on one axis": (Reason.IMPROVED, {"rows": BETTER, "z": np.array([0.96, 0, 0, 0, 0])}),
    "a misfit like that of good repairs": (Reason.IMPROVED, {"rows": BETTER, "left": left_over(after=0.3)}),
    "a large misfit": (Reason.MISFIT, {"rows": BETTER, "left": left_over(after=0.45)}),
    "a large misfit, in few regions": (Reason.IMPROVED, {"rows": BETTER, "left": left_over(after=some(0.05, 2, 0.1))}),
    "a misfit, the gain small beside it": (Reason.MISFIT, {"rows": BETTER, "left": left_over(0.5, 0.32)}),
    "a small misfit, the gain small": (Reason.IMPROVED, {"rows": BETTER, "left": left_over(0.2, 0.15)}),
    "some regions worse": (Reason.MISFIT, {"rows": BETTER, "left": left_over(some(0.2, 0.1, 2), some(0.2, 0.2, 0.05))}),
    "worse by noise": (
        Reason.IMPROVED,
        {"rows": BETTER, "left": left_over(some(0.2, 0.1, 2), some(0.2, 0.2, 0.05), error=0.05)},
    ),
    "another effect explains it as well": (Reason.MISFIT, {"rows": BETTER, "left": left_over(sway=0.9)}),
    "an unusual drift that another effect explains in part": (
        Reason.MISFIT,
        {"rows": BETTER, "left": left_over(sway=0.3, chance=0.04)},
    ),
    "a usual drift that another effect explains in part": (
        Reason.IMPROVED,
        {"rows": BETTER, "left": left_over(sway=0.3, chance=0.06)},
    ),
    "another effect explains part of a turn, y and z stay": (
        Reason.IMPROVED,
        {"rows": BETTER, "left": left_over(sway=0.9, chance=0.04), "shift": 0.4},
    ),
    "another effect explains all of a turn": (
        Reason.MISFIT,
        {"rows": BETTER, "left": left_over(sway=1.1), "shift": 0.4},
    ),
    "another effect explains some of it": (Reason.IMPROVED, {"rows": BETTER, "left": left_over(sway=0.08)}),
    "regions that match no longer": (Reason.MISFIT, {"rows": BETTER, "left": left_over(lost=0.3)}),
    "a region that matches no longer": (Reason.IMPROVED, {"rows": BETTER, "left": left_over(lost=0.15)}),
    "a strange drift": (Reason.IMPLAUSIBLE, {"rows": BETTER, "left": left_over(chance=0.0001)}),
    "a strange drift, of rows that were aligned": (
        Reason.ALREADY_GOOD,
        {"rows": (0.28, 0.1, 10.0), "left": left_over(chance=0.0001)},
    ),
    "a misfit, of rows that were aligned": (
        Reason.ALREADY_GOOD,
        {"rows": (0.28, 0.1, 10.0), "left": left_over(after=0.45)},
    ),
    "misfit, but nothing to accept": (Reason.ALREADY_GOOD, {"left": left_over(after=1.0)}),
}


@pytest.mark.parametrize("scale", [1.0, 0.4])
@pytest.mark.parametrize("case", CASES)
def test_verdict(case, scale):
    expected, facts = CASES[case]
    assert judged(**facts, scale=scale).reason is expected


def test_no_gain_is_not_the_same_as_doubt():
    """Both leave a good calibration alone; only the first may be overruled by what is more than rows."""
    assert judged() == Verdict(Reason.ALREADY_GOOD)
    gains = {"rows": (0.28, 0.1, 10.0)}
    assert judged(**gains, left=left_over(chance=0.0001)) == Verdict(Reason.ALREADY_GOOD, Reason.IMPLAUSIBLE)
    assert judged(**gains, z=0.6) == Verdict(Reason.ALREADY_GOOD, Reason.IMPLAUSIBLE)
    assert judged(**gains, left=left_over(after=0.45)) == Verdict(Reason.ALREADY_GOOD, Reason.MISFIT)


def test_every_reason_has_its_case():
    """Two of them are said where the count is all there is, one where nothing could be judged."""
    on_count = {verdict_on_count(a, b, signal=s) for a, b, s in ((5, 6, True), (5, 5, True), (0, 0, False))}
    assert on_count == {Reason.MORE_MATCHES, Reason.NOT_IMPROVED, Reason.TOO_LITTLE_TEXTURE}
    assert on_count | {reason for reason, _ in CASES.values()} == set(Reason) - {
        Reason.OUT_OF_BUDGET,
        Reason.CANNOT_TELL,  # tests/decision
        Reason.FRAMES_DISAGREE,  # test_agreement.py
        Reason.NO_MATCHES,  # test_default_schedule.py
        Reason.RANGES,  # test_ranges.py
    }
    assert {reason for reason in Reason if reason.healthy} == {
        Reason.IMPROVED,
        Reason.MORE_MATCHES,
        Reason.ALREADY_GOOD,
        Reason.RANGES,
    }


@pytest.mark.parametrize(("before", "after"), [(0, 0), (7, 7), (7, 6)])
def test_the_count_alone_must_rise(before, after):
    assert verdict_on_count(before, after, signal=True) is Reason.NOT_IMPROVED
    assert verdict_on_count(before, after, signal=False) is Reason.TOO_LITTLE_TEXTURE


counts = st.one_of(st.integers(0, 400_000), st.integers(196_000, 206_000))
pixels = st.one_of(st.floats(0, 5), st.floats(0.45, 0.55))


@settings(max_examples=300)
@given(
    before=counts,
    after=counts,
    rows=st.tuples(pixels, pixels, st.floats(-50, 50)),
    z=st.tuples(*[st.floats(-1, 1)] * 5),
    left=st.tuples(st.floats(0, 3), st.floats(0, 1), st.floats(0, 1)),
    places=st.integers(0, 48),
    covered=st.floats(0, 1),
)
def test_never_accepted(before, after, rows, z, left, places, covered):
    """Nothing is accepted that loses 1 % of the count or 0.02 pixels, in too few places or too little of the image, or
    where the reach ends, or that leaves more than it takes; and nothing that gains neither."""
    reason = judged(before, after, rows, z, left_over(*left), places, covered).reason
    gain = rows[0] - rows[1]
    if after < 0.99 * before or gain < -0.02 or places < 6 or covered < 0.1:
        assert not reason.accepted
    if reason is Reason.IMPROVED:
        assert (gain > 0.01 and rows[2] > 3) or (after > 1.01 * before and gain > -1e-9)
        assert np.abs(z).max() <= 0.98
        assert np.linalg.norm(z) <= 6 * PRIOR
        assert left[1] <= max(left[0], 0.0) + 0.07
        assert left[1] < 0.42


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
