"""Terminal tables of `recalibrate` and `score`: they fit, and no word or number is cut."""

import io
from typing import Any

import pytest
from rich.console import Console, RenderableType

from stereorecal.recalibration import Reason
from stereorecal.report.repair_tables import repairs_table, scores_table

NAME = "recordings/2026-06-02-harbour"


def repair(scene: str, reason: Reason, **changes: Any) -> dict[str, Any]:
    """The row of a repair."""
    return {
        "scene": scene,
        "error": None,
        "fault": None,
        "accepted": reason.accepted,
        "healthy": reason.healthy,
        "reason": reason.name.lower(),
        "row_error_px": {"before": 1.234, "after": 0.081},
        "score_before": {"fraction": 0.34},
        "score_after": {"fraction": 0.62},
        "change": {
            "rotation_deg": {"pitch": -0.512, "yaw": 0.231, "roll": 0.45},
            "translation_percent": {"y": 0.1, "z": -12.04},
        },
        "interval_95": {"rotation_deg": {"pitch": 0.012}, "translation_percent": {"z": 1.04}},
        "seconds": 123.4,
        **changes,
    }


def repairs() -> list[dict[str, Any]]:
    """One of each verdict, and one that failed."""
    rows = [repair(f"{NAME}-{number}", reason) for number, reason in enumerate(Reason)]
    return [*rows, repair("KITTI/2011_09_26_drive_0001_extract", Reason.IMPROVED, error="it broke", fault="input")]


def score(scene: str, **changes: Any) -> dict[str, Any]:
    depth = [{"distance_m": 3.6, "before": {"metres": {"value": 0.2, "low": -0.14, "high": None}}}]
    decision = {"rows_px": {"before": {"value": 1.234}}}
    numbers = {"decision": decision, "mismatch": None, "score_before": {"fraction": 0.34}, "depth": depth}
    return {"scene": scene, "error": None, "verdict": "cannot tell (too little texture)", **numbers, **changes}


def printed(table: RenderableType, width: int) -> list[str]:
    console = Console(file=io.StringIO(), width=width, color_system=None)
    console.print(table)
    assert isinstance(console.file, io.StringIO)
    lines = [line.rstrip() for line in console.file.getvalue().splitlines()]
    assert all(len(line) <= width for line in lines)
    assert not any("…" in line for line in lines)
    return lines


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_repairs_are_whole(width: int):
    words = " ".join(printed(repairs_table(repairs(), width), width)).split()
    for reason in Reason:
        assert set(reason.name.lower().split("_")) <= set(words)
    assert {"failed", "(input)", "matched", "pitch", "-12.040", "±1.040", "123.4", "1.23", "0.08"} <= set(words)


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_scores_are_whole(width: int):
    rows = [score(f"{NAME}-1"), score("KITTI/drive_0001", decision=None, depth=[]), score("b", error="bad")]
    words = " ".join(printed(scores_table(rows, width), width)).split()
    assert {"cannot", "tell", "(too", "little", "texture)", "matched", "1.23", "-14", "3.6"} <= set(words)
    assert f"{NAME}-1" in words or width < 200  # names are folded first
    wrong = scores_table([score("wrong input", decision=None)], width)
    assert "1.23" not in " ".join(printed(wrong, width)), "of chance matches"


def test_wide_terminals_hold_one_table_of_repairs():
    heads = {
        width: sum(" scene " in line for line in printed(repairs_table(repairs(), width), width)) for width in (80, 120)
    }
    assert heads == {80: 2, 120: 1}
