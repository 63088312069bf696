"""Success rates and medians of groups of trials."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from stereorecal.comparison._trial import FAILED, SCORE_AT, SKIPPED, THRESHOLDS, Trial, is_harmful
from stereorecal.strategies import Status

_NUMBERS = ("score_initial", "score_final", "score_reference", "ratio", "evaluations", "cost", "cost_total", "seconds")


def succeeded(trial: Trial) -> bool:
    """True if both the score and the rotation came back to within the thresholds."""
    if trial.ratio is None or trial.rotation_error_deg is None:
        return False
    error = trial.rotation_error_deg
    return (
        trial.ratio >= THRESHOLDS["ratio"]
        and max(error["pitch"], error["roll"]) <= THRESHOLDS["pitch_roll_deg"]
        and error["yaw"] <= THRESHOLDS["yaw_deg"]
    )


def summarise(trials: Sequence[Trial]) -> tuple[dict[str, Any], ...]:
    """One row for each scene, strategy, matcher and schedule, in order of first appearance, as the JSON has it: medians
    over the finished trials. What the true rig judges is None where it is not known."""
    groups: dict[tuple[str, str, str, str], list[Trial]] = {}
    for trial in trials:
        groups.setdefault((trial.scene, trial.strategy, trial.matcher, trial.schedule), []).append(trial)
    return tuple(map(_summary, groups.values()))


def _summary(trials: list[Trial]) -> dict[str, Any]:
    first, finished = trials[0], [t for t in trials if t.score_final is not None]
    wanted = [t for t in trials if t.status != SKIPPED]
    judged = [t.by_truth for t in finished if t.by_truth is not None]
    reached = [t.score_at for t in finished if t.score_at]
    return {
        "scene": first.scene,
        "strategy": first.strategy,
        "matcher": first.matcher,
        "schedule": first.schedule,
        "strategies": first.strategies,
        "draws": len(trials),
        "failed": sum(t.status == FAILED for t in trials),
        "skipped": len(trials) - len(wanted),
        "flagged": sum(t.ratio is not None and t.ratio > THRESHOLDS["flagged_ratio"] for t in finished),
        "out_of_budget": sum(t.status == Status.BUDGET.name for t in trials),
        "success_rate": float(np.mean([succeeded(t) for t in wanted])) if wanted else None,
        "rotation_error_deg_median": _median_of_each([t.rotation_error_deg for t in finished]),
        "translation_error_percent_median": _median_of_each([t.translation_error_percent for t in finished]),
        "score_at_median": {cost: _median([scores[cost] for scores in reached]) for cost in map(str, SCORE_AT)},
        **{f"{name}_median": _median([getattr(t, name) for t in finished]) for name in _NUMBERS},
        "harmful": sum(map(_did_harm, judged)) if judged else None,
        "row_error_px_median": _median_of_each([errors["row_error_px"] for errors in judged]),
        "depth_error_percent_median": _median_of_each(
            [{at: abs(error) for at, error in errors["depth_error_percent"]["final"].items()} for errors in judged]
        ),
    }


def _did_harm(by_truth: dict[str, Any]) -> bool:
    rows, depth = by_truth["row_error_px"], by_truth["depth_error_percent"]
    return is_harmful((rows["start"], rows["final"]), (depth["start"]["30"], depth["final"]["30"]))


def _median(values: Sequence[float | None]) -> float | None:
    """The median of those that are known."""
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _median_of_each(rows: Sequence) -> dict[str, float] | None:
    return {key: float(np.median([row[key] for row in rows])) for key in rows[0]} if rows else None
