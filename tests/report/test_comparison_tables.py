"""Terminal tables of a comparison: they fit, and say which strategies ran in which schedule."""

import io
from itertools import pairwise
from typing import Any

import pytest
from rich.console import Console

from stereorecal.report.comparison_tables import comparison_tables

LEVENBERG = "optimistix-levenberg-marquardt"
BOTH = [("default", "compass", ["compass", LEVENBERG]), ("count", "compass", ["compass"])]
AXES = {"rotation_error_deg": ("pitch", "yaw", "roll"), "translation_error_percent": ("y", "z")}


def comparison(entrants, scenes=("data/harbour-0",), draws=2) -> dict[str, Any]:
    """The JSON of a comparison, as plain data."""
    rows = [
        {"scene": scene, "schedule": schedule, "strategy": name, "strategies": ran}
        for scene in scenes
        for schedule, name, ran in entrants
    ]
    errors = {kind: dict.fromkeys(axes, 0.0123) for kind, axes in AXES.items()}
    counts = {"score_initial": 65_649, "score_final": 174_325, "score_reference": 174_235}
    trial = {**counts, **errors, "ratio": 1.001, "status": "CONVERGED", "message": "it met its own stopping rule"}
    medians = {f"{key}_median": value for key, value in {**counts, **errors, "ratio": 1.001}.items()}
    medians |= {
        "evaluations_median": 204.0,
        "cost_median": 12.0,
        "seconds_median": 138.5,
        "score_at_median": {"100": None},
    }
    return {
        "settings": {
            "strategies": list(dict.fromkeys(name for _, name, _ in entrants)),
            "entrants": [{"schedule": s, "strategy": name, "strategies": ran} for s, name, ran in entrants],
            "matcher": {"name": "sad"},
            "schedule": " and ".join(sorted({schedule for schedule, _, _ in entrants})),
            "scale": 0.5,
            "draws": draws,
            "budget": {"evaluations": None},
            "thresholds": {
                "ratio": 0.98,
                "flagged_ratio": 1.05,
                "pitch_roll_deg": 0.05,
                "yaw_deg": 0.2,
                "harmful_rows_px": 0.02,
                "harmful_depth_percent": 1.0,
            },
        },
        "scenes": [{"name": scene, "reference": "truth"} for scene in scenes],
        "trials": [{**row, **trial, "draw": draw} for row in rows for draw in range(draws)],
        "summary": [{**row, **medians, "draws": draws, "success_rate": 1.0} for row in rows],
    }


def printed(data: dict[str, Any], width: int) -> list[str]:
    """The lines on a terminal of that width."""
    console = Console(file=io.StringIO(), width=width, color_system=None)
    console.print(comparison_tables(data, width))
    assert isinstance(console.file, io.StringIO)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


def heads(lines: list[str]) -> list[list[str]]:
    """The words above the line of each table."""
    return [above.split() for above, line in pairwise(lines) if line.startswith(" ───")]


def test_scores_and_errors_stand_side_by_side_where_no_word_is_broken_for_it():
    lines = printed(comparison(BOTH), 136)
    assert len(heads(printed(comparison(BOTH), 120))) == 1 + 2
    trials, medians = heads(lines)
    assert trials[:2] == ["schedule", "draw"]
    assert medians[:4] == ["schedule", "strategy", "success", "N_i"]
    assert {"r", "pitch°", "yaw°", "roll°"} <= set(trials) & set(medians)
    assert "evals" not in medians  # of the count and of residuals: they do not compare
    assert not any("…" in line for line in lines)
    (first,) = [i for i, line in enumerate(lines) if line.startswith(" default") and "compass +" in line]
    assert lines[first].split()[:3] == ["default", "compass", "+"]
    assert lines[first + 1].split() == ["optimistix-levenberg-marquardt"]
    assert lines[first + 2].split()[:3] == ["count", "compass", "100"]
    assert "medians over 2 draws (harbour-0, matcher sad)" in lines
    assert "schedule count: the paper's way, the count alone, at scale 0.5." in lines
    assert any(line.startswith("schedule default: coarse to fine") for line in lines)


@pytest.mark.parametrize("scenes", [("data/harbour-0",), ("data/harbour-0", "data/motorcycle_quarter")])
def test_80_columns_hold_scores_and_errors_one_below_the_other(scenes):
    lines = printed(comparison(BOTH, scenes), 80)
    found = heads(lines)
    assert len(found) == 4
    assert ["N_i" in head for head in found] == [True, False, True, False]
    assert ["pitch°" in head for head in found] == [False, True, False, True]
    assert all("schedule" in head for head in found)
    text = " ".join(lines)
    for word in ("CONVERGED", "65 649", "174 325", "174 235", "1.001", "0.012", "100 %", "138.5", "compass +"):
        assert word in text
    assert "…" not in text
    assert ["strategy" in head for head in found] == [False, False, True, False]  # the schedule says which


@pytest.mark.parametrize("entrants", [BOTH, [("count", "compass", ["compass"]), ("count", "secant", ["secant"])]])
def test_names_are_folded_before_a_number_is_cut(entrants):
    lines = printed(comparison(entrants, ("data/harbour-0", "data/motorcycle_quarter")), 60)
    assert all(len(line) <= 60 for line in lines)
    assert not any("…" in line for line in lines)
    rows = [line.split() for line in lines]
    scores = ["65", "649", "174", "325", "174", "235", "1.001"]
    assert sum(scores == row[i : i + 7] for row in rows for i in range(len(row))) == 8 + 4  # trials, and medians
    assert sum(row.count("0.012") == 3 and row.count("0.01") == 2 for row in rows) == 8 + 4


def test_one_schedule_has_no_column_of_its_own():
    lines = printed(comparison([("count", "compass", ["compass"]), ("count", "secant", ["secant"])]), 120)
    trials, medians = heads(lines)
    assert trials[:2] == ["strategy", "draw"]
    assert medians[:2] == ["strategy", "success"]
    assert "evals" in medians
    assert "medians over 2 draws (harbour-0, matcher sad, schedule count at scale 0.5)" in lines
    assert not any(line.startswith("schedule ") for line in lines)

    lines = printed(comparison([BOTH[0]], draws=1), 120)
    assert "medians over 1 draw (harbour-0, matcher sad, schedule default)" in lines
    assert any("compass +" in line for line in lines)
    assert any(LEVENBERG in line for line in lines)


def test_draws_that_are_missing_or_failed():
    """Their number is a column then; the reason of a row without numbers names its schedule."""
    data = comparison(BOTH)
    data["summary"][1]["draws"] = 1
    data["trials"][-1] |= {"status": "FAILED", "message": "it crashed"}
    lines = printed(data, 120)
    assert "draws" in heads(lines)[1]
    assert "medians over the finished draws (harbour-0, matcher sad)" in lines
    assert "count FAILED: it crashed" in lines


@pytest.mark.parametrize("width", [120, 80, 60])
def test_what_the_true_rig_says_has_a_table_of_its_own(width):
    data = comparison(BOTH)
    judged = {
        "row_error_px_median": {"start": 8.84, "final": 0.09},
        "depth_error_percent_median": {"10": 0.7, "30": 2.1},
    }
    data["summary"][0] |= {"harmful": 0, **judged}
    data["summary"][1] |= {"harmful": None}
    lines = printed(data, width)
    (head,) = [words for words in heads(lines) if "harmful" in words]
    below = lines[next(index for index, line in enumerate(lines) if line.split() == head) :]
    row = next(line for line in below if "default" in line)
    assert row.split()[-2:] == ["2.1", "0"]
    assert "8.84      0.09     0.7" in row
    assert not any("…" in line for line in lines)
    assert all(len(line) <= width for line in lines if set(line.strip()) == {"─"})
    assert "harmful: trials after which the epipolar error is larger by more than 0.02 px" in " ".join(lines)
