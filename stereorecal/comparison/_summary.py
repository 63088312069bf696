"""Success rates and medians of groups of trials."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereorecal.comparison._trial import FAILED, SCORE_AT, SKIPPED, Trial, is_harmful
from stereorecal.strategies import Status


@dataclass(frozen=True)
class Thresholds:
    """When a trial counts as a success, and above which ratio it is flagged.

    Attributes:
        ratio: lowest r.
        pitch_roll_deg, yaw_deg: largest errors. 0.05 degrees of pitch are half a row at a focal length of 600 pixels;
            yaw, which rows hardly show, may be off by four times as much.
        harmful_rows_px, harmful_depth_percent: by the true rig, a repair is harmful whose rows are worse than before by
            more than this, or whose |depth error| at 30 baselines has grown by more percentage points.
        flagged_ratio: above it a wrong calibration may score higher than the right one.
    """

    ratio: float = 0.98
    pitch_roll_deg: float = 0.05
    yaw_deg: float = 0.2
    flagged_ratio: float = 1.05
    harmful_rows_px: float = 0.05
    harmful_depth_percent: float = 1.0


@dataclass(frozen=True)
class Summary:
    """The trials of one strategy in one schedule with one matcher on one scene; medians over the finished ones.

    What the true rig judges (`harmful`, a number of trials, and the medians of epipolar error and |depth error| at the
    end) is None where it is not known.
    """

    scene: str
    strategy: str
    matcher: str
    schedule: str
    strategies: tuple[str, ...]
    draws: int
    failed: int
    skipped: int
    flagged: int
    out_of_budget: int
    success_rate: float | None
    score_initial_median: float | None
    score_final_median: float | None
    score_reference_median: float | None
    ratio_median: float | None
    rotation_error_deg_median: dict[str, float] | None
    translation_error_percent_median: dict[str, float] | None
    evaluations_median: float | None
    cost_median: float | None
    cost_total_median: float | None
    seconds_median: float | None
    score_at_median: dict[str, float | None]
    harmful: int | None
    row_error_px_median: dict[str, float] | None
    depth_error_percent_median: dict[str, float] | None


_NUMBERS = ("score_initial", "score_final", "score_reference", "ratio", "evaluations", "cost", "cost_total", "seconds")


def succeeded(trial: Trial, thresholds: Thresholds) -> bool:
    """True if both the score and the rotation came back to within the thresholds."""
    if trial.ratio is None or trial.rotation_error_deg is None:
        return False
    error = trial.rotation_error_deg
    return (
        trial.ratio >= thresholds.ratio
        and max(error["pitch"], error["roll"]) <= thresholds.pitch_roll_deg
        and error["yaw"] <= thresholds.yaw_deg
    )


def summarise(trials: Sequence[Trial], thresholds: Thresholds) -> tuple[Summary, ...]:
    """One Summary for each scene, strategy, matcher and schedule, in order of first appearance."""
    groups: dict[tuple[str, str, str, str], list[Trial]] = {}
    for trial in trials:
        groups.setdefault((trial.scene, trial.strategy, trial.matcher, trial.schedule), []).append(trial)
    return tuple(_summary(key, group, thresholds) for key, group in groups.items())


def _summary(key: tuple[str, str, str, str], trials: list[Trial], thresholds: Thresholds) -> Summary:
    finished = [t for t in trials if t.score_final is not None]
    wanted = [t for t in trials if t.status != SKIPPED]
    judged = [t.by_truth for t in finished if t.by_truth is not None]
    reached = [t.score_at for t in finished if t.score_at]
    limits = thresholds.harmful_rows_px, thresholds.harmful_depth_percent
    return Summary(
        *key,
        trials[0].strategies,
        draws=len(trials),
        failed=sum(t.status == FAILED for t in trials),
        skipped=len(trials) - len(wanted),
        flagged=sum(t.ratio is not None and t.ratio > thresholds.flagged_ratio for t in finished),
        out_of_budget=sum(t.status == Status.BUDGET.name for t in trials),
        success_rate=float(np.mean([succeeded(t, thresholds) for t in wanted])) if wanted else None,
        rotation_error_deg_median=_median_of_each([t.rotation_error_deg for t in finished]),
        translation_error_percent_median=_median_of_each([t.translation_error_percent for t in finished]),
        score_at_median={cost: _median([scores[cost] for scores in reached]) for cost in map(str, SCORE_AT)},
        **{f"{name}_median": _median([getattr(t, name) for t in finished]) for name in _NUMBERS},
        harmful=sum(is_harmful(errors, *limits) for errors in judged) if judged else None,
        row_error_px_median=_median_of_each([errors["row_error_px"] for errors in judged]),
        depth_error_percent_median=_median_of_each(
            [{at: abs(error) for at, error in errors["depth_error_percent"]["final"].items()} for errors in judged]
        ),
    )


def _median(values: Sequence[float | None]) -> float | None:
    """The median of those that are known."""
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _median_of_each(rows: Sequence) -> dict[str, float] | None:
    return {key: float(np.median([row[key] for row in rows])) for key in rows[0]} if rows else None
