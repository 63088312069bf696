"""Rows and depth by the true rig, and what counts as harm."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import stereorecal as sr
from stereorecal.comparison import Trial, errors_by_truth, is_harmful, summarise

RIG = sr.synthetic.default_rig()
AMOUNT = st.floats(0.0, 50.0)


def errors(rows=(1.0, 1.0), depth=(5.0, 5.0)):
    """Epipolar errors at the start and the end, and depth errors at 30 baselines."""
    at = {when: {"10": one / 3.0, "30": one} for when, one in zip(("start", "final"), depth, strict=True)}
    return {"row_error_px": dict(zip(("start", "final"), rows, strict=True)), "depth_error_percent": at}


@pytest.mark.parametrize(
    ("rows", "depth", "harmful"),
    [
        ((1.0, 1.0), (5.0, 5.0), False),
        ((0.1, 0.149), (5.0, 5.0), False),
        ((0.1, 0.151), (5.0, 5.0), True),
        ((1.0, 1.0), (5.0, 5.9), False),
        ((1.0, 1.0), (5.0, 6.1), True),
        ((1.0, 1.0), (5.0, -6.1), True),
        ((1.0, 1.0), (-5.0, 4.0), False),
        ((9.0, 0.1), (0.5, 3.0), True),
        ((1.0, 1.0), (np.inf, 40.0), False),
        ((1.0, 1.0), (np.inf, np.inf), False),
        ((1.0, 1.0), (40.0, np.inf), True),
        ((np.nan, 1.0), (5.0, 5.0), False),
        ((1.0, np.nan), (5.0, 5.0), True),
        ((1.0, 1.0), (1.0, np.nan), True),
    ],
)
def test_harm(rows, depth, harmful):
    assert is_harmful(rows, depth) is harmful


@given(AMOUNT, AMOUNT, AMOUNT, AMOUNT)
def test_there_and_back_is_harmful_once_at_most(rows, other_rows, depth, other_depth):
    same = (depth, depth)
    assert not (is_harmful((rows, other_rows), same) and is_harmful((other_rows, rows), same))
    assert not is_harmful((rows, rows), same)
    assert is_harmful((rows, rows), (depth, other_depth)) == (other_depth > depth + 1.0)


def test_errors_are_those_of_the_axes():
    """A pitch moves rows by the focal length times its angle, a yaw disparity by the same."""
    start = RIG.with_extrinsics(RIG.extrinsics + np.radians([0.1, 0, 0, 0, 0, 0]))
    final = RIG.with_extrinsics(RIG.extrinsics + np.radians([0, 0.02, 0, 0, 0, 0]))
    view = sr.view(RIG)
    found = errors_by_truth(start, final, RIG, view)
    focal = float(view.focal)
    assert found["row_error_px"]["start"] == pytest.approx(focal * np.radians(0.1), rel=0.15)
    assert found["row_error_px"]["final"] < 0.05
    for distance in (10, 30):  # the disparity there is f / distance
        share = np.radians(0.02) * distance
        assert abs(found["depth_error_percent"]["final"][str(distance)]) == pytest.approx(100 * share, rel=0.05)
    same = errors_by_truth(RIG, RIG, RIG, view)
    assert same["row_error_px"]["final"] == pytest.approx(0.0, abs=1e-9)
    assert same["depth_error_percent"]["final"]["30"] == pytest.approx(0.0, abs=1e-9)


def trial(by_truth, **changes) -> Trial:
    reference = "stored" if by_truth is None else "truth"
    about = {"scene": "s", "strategy": "a", "matcher": "sad", "schedule": "count", "draw": 0, "strategies": ("a",)}
    numbers = ("score_initial", "score_final", "score_reference", "evaluations", "cost", "cost_total", "seconds")
    zero = {"rotation_error_deg": dict.fromkeys(("pitch", "yaw", "roll"), 0.0), "translation_error_percent": {"y": 0.0}}
    about |= zero | dict.fromkeys(numbers, 1)
    end = {"status": "CONVERGED", "message": "", "accepted": True, "reason": "better", "reference": reference}
    return Trial(**(about | end | {"by_truth": by_truth} | changes))


def test_a_summary_counts_harm_where_the_truth_is_known():
    judged = [errors(), errors(depth=(5.0, -9.0)), errors(rows=(1.0, 3.0))]
    (summary,) = summarise([*map(trial, judged), trial(None, status="FAILED", score_final=None)])
    assert summary["harmful"] == 2
    assert summary["row_error_px_median"] == {"start": 1.0, "final": 1.0}
    assert summary["depth_error_percent_median"] == {"10": pytest.approx(5.0 / 3.0), "30": 5.0}
    (unknown,) = summarise([trial(None)])
    assert [unknown[key] for key in ("harmful", "row_error_px_median", "depth_error_percent_median")] == [None] * 3
