"""What rows say together: hand-made rows, and the paper's own tables."""

import numpy as np
import pytest
from stereorecal_paper import Reproduction


def summary(name: str, rows=()) -> list[dict]:
    """The summary of the rows of an experiment."""
    return Reproduction({}, {}, {name: tuple(rows)}, {}, 0).summary[name]


def of_repairs(rows) -> list[dict]:
    """Below what the paper says of its own."""
    return summary("repair", rows)[1:]


def row(
    final, reference, schedule="count", starred=False, before=(1.0, 1.0, 1.0), after=(0.1, 0.1, 0.1), accepted=True
):
    axes = ("pitch", "yaw", "roll")
    return {
        "schedule": schedule,
        "score_final": final,
        "score_reference": reference,
        "starred": starred,
        "accepted": accepted,
        "seconds": 2.0,
        "rotation_error_deg": dict(zip(axes, after, strict=True)),
        "translation_error_percent": {"y": 0.1, "z": 0.2},
        "start_error": {"rotation_error_deg": dict(zip(axes, before, strict=True))},
    }


def test_the_paper_as_it_says_itself():
    one, two = (summary(name, [row(1, 1)])[0] for name in ("repair", "ex_nihilo"))
    assert one["schedule"] == two["schedule"] == "the paper"
    assert (one["rows"], two["rows"]) == (11, 17)
    assert round(one["share_r_1"] * 11) == 2
    assert round(two["share_r_1"] * 17) == 13
    assert two["r_median"] == pytest.approx(1.034, abs=6e-4)


def test_repairs_by_schedule_without_starred_pairs():
    rows = [row(99, 100), row(101, 100), row(50, 100, starred=True, accepted=False), row(98, 100, schedule="default")]
    count, default = of_repairs(rows)
    assert (count["schedule"], count["rows"], default["rows"]) == ("count", 2, 1)
    assert count["r_median"] == pytest.approx(1.0)
    assert (count["share_r_1"], count["share_r_0.99"], default["share_r_0.99"]) == (0.5, 1.0, 0.0)
    assert (count["starred"], count["starred_refused"], count["starred_worse"]) == (1, 1, 0)


def test_a_pair_that_matches_nothing_under_the_reference_has_no_ratio():
    (found,) = of_repairs([row(5, 0), row(90, 100)])
    assert found["rows"] == 2
    assert found["r_median"] == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("accepted", "after", "worse"), [(True, 1.5, True), (True, 1.01, False), (False, 1.5, False), (True, 0.2, False)]
)
def test_worse_is_accepted_and_farther_from_the_truth(accepted, after, worse):
    (found,) = of_repairs([row(1, 1, after=(after, 0.1, 0.1), accepted=accepted, starred=True)])
    assert found["starred_worse"] == worse


def test_only_starred_pairs():
    (found,) = of_repairs([row(5, 10, starred=True)])
    assert found["r_median"] is None
    assert found["rotation_error_deg_median"] is None


def test_the_shape_of_a_sweep():
    x = np.linspace(-3, 3, 601)
    bell = np.rint(1e6 * np.exp(-((x - 0.2) ** 2))).astype(int)
    shapes = {"pitch": bell, "yaw": np.full(601, 7)}
    rows = [
        {"axis": axis, "matcher": "sad", "offsets": x.tolist(), "counts": counts.tolist()}
        for axis, counts in shapes.items()
    ]
    pitch, yaw = summary("sweeps", rows)
    assert pitch["peak"] == pytest.approx(0.2, abs=0.006)
    assert pitch["half_width"] == pytest.approx(2 * np.sqrt(np.log(2)), abs=0.02)
    assert pitch["flat_width"] == pytest.approx(2 * np.sqrt(-np.log(0.99)), abs=0.02)
    assert yaw["half_width"] == pytest.approx(6.0)  # never falls
    assert (pitch["half_cut"], yaw["half_cut"]) == (False, True)


def test_validity_counts_the_pairs_whose_own_calibration_wins():
    rows = [
        {"own": "b", "starred": False, "counts": {"a": 3, "b": 5}},
        {"own": "b", "starred": False, "counts": {"a": 6, "b": 5}},
        {"own": "b", "starred": True, "counts": {"a": 9, "b": 5}},
    ]
    (found,) = summary("validity", [{**row, "sequence": "x"} for row in rows])
    assert (found["pairs"], found["own_highest"]) == (2, 1)
    assert found["next_best_share"] == pytest.approx(0.9)
    tied = {"sequence": "x", "own": "b", "starred": False, "counts": {"b": 5, "a": 5}}
    assert summary("validity", [tied])[0]["own_highest"] == 0


def test_generalisation_leaves_out_pairs_without_matches_and_starred_ones():
    others = {
        "1": {"starred": False, "score_initial": 20, "score_final": 90, "score_reference": 100},
        "2": {"starred": False, "score_initial": 40, "score_final": 30, "score_reference": 100},
        "3": {"starred": False, "score_initial": 0, "score_final": 0, "score_reference": 0},
        "4": {"starred": True, "score_initial": 9, "score_final": 9, "score_reference": 9},
    }
    (found,) = summary("generalise", [{**row(95, 100), "calibration": "old", "others": others}])
    assert (found["others"], found["improved"]) == (2, 1)
    assert found["r_others_before"] == pytest.approx(0.3)
    assert found["r_others_after"] == pytest.approx(0.6)
    assert found["start_error_deg"] == 1.0


def test_sequences_are_judged_on_pairs_without_a_star():
    steps = [row(10, 100, starred=True, accepted=False), row(90, 100), row(101, 100), row(150, 100, starred=True)]
    (found,) = summary("sequential", [{**row(0, 1), "order": "random", "steps": steps}])
    assert (found["steps"], found["accepted"]) == (4, 3)
    assert (found["r_first"], found["r_last"]) == (0.9, 1.01)
