"""The trials of a method before a judge, in one row."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal_field.judges import DISTANCES
from stereorecal_field.table._field_trial import FAILED, SKIPPED, FieldTrial
from stereorecal_field.table._methods import ACCEPTED, GOOD, REFUSED


@dataclass(frozen=True)
class FieldSummary:
    """Counts, and medians over the trials that were judged.

    Attributes:
        start: "drifted", or "stored" where trials begin with the calibration as a folder has it.
        trials: that were planned and ran, failed ones too.
        accepted, good, refused, failed, skipped, harmful: how many.
        row_error_px: median at the "start" and at the "final".
        depth_error_percent: likewise, of the amount, by distance in baselines.
        rotation_error_deg: median at the final, of pitch, yaw and roll.
        stated, covered: trials that state an interval that the judge can tell, and those in which it held the truth.
        seconds, memory_mib: medians.
    """

    judge: str
    start: str
    method: str
    trials: int
    accepted: int
    good: int
    refused: int
    failed: int
    skipped: int
    harmful: int
    row_error_px: dict[str, float] | None
    depth_error_percent: dict[str, dict[str, float]] | None
    rotation_error_deg: dict[str, float] | None
    stated: int
    covered: int
    seconds: float | None
    memory_mib: float | None


def summarised(trials: Sequence[FieldTrial]) -> tuple[FieldSummary, ...]:
    """A row for each judge, start and method, in order of first appearance."""
    groups: dict[tuple[str, str, str], list[FieldTrial]] = {}
    for trial in trials:
        start = "stored" if trial.draw is None else "drifted"
        groups.setdefault((trial.judge, start, trial.method), []).append(trial)
    return tuple(_summary(*key, group) for key, group in groups.items())


def _summary(judge: str, start: str, method: str, trials: list[FieldTrial]) -> FieldSummary:
    judged = [trial for trial in trials if trial.row_error_px is not None]
    rows = [trial.row_error_px for trial in judged if trial.row_error_px]
    depths = [trial.depth_error_percent for trial in judged if trial.depth_error_percent]
    angles = [trial.rotation_error_deg["final"] for trial in judged if trial.rotation_error_deg]
    stated = [trial.covered for trial in judged if trial.covered is not None]

    def number(status: str) -> int:
        return sum(trial.status == status for trial in trials)

    return FieldSummary(
        judge,
        start,
        method,
        trials=len(trials) - number(SKIPPED),
        accepted=number(ACCEPTED),
        good=number(GOOD),
        refused=number(REFUSED),
        failed=number(FAILED),
        skipped=number(SKIPPED),
        harmful=sum(trial.harmful is True for trial in judged),
        row_error_px={when: _upper_median([row[when] for row in rows]) for when in ("start", "final")}
        if rows
        else None,
        depth_error_percent={
            when: {str(at): _upper_median([abs(depth[when][str(at)]) for depth in depths]) for at in DISTANCES}
            for when in ("start", "final")
        }
        if depths
        else None,
        rotation_error_deg={axis: _upper_median([one[axis] for one in angles]) for axis in angles[0]}
        if angles
        else None,
        stated=len(stated),
        covered=sum(stated),
        seconds=_upper_median([trial.seconds for trial in judged if trial.seconds is not None]) if judged else None,
        memory_mib=_upper_median(known)
        if (known := [t.memory_mib for t in judged if t.memory_mib is not None])
        else None,
    )


def _upper_median(values: Sequence[float]) -> float:
    """The upper one of two in the middle, so that infinite ones may be among them."""
    return float(np.sort(values)[len(values) // 2])
