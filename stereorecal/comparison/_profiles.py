"""What strategies reach for how much: quartiles over cost, and data profiles as of J. J. Moré and S. M. Wild,
Benchmarking derivative-free optimization algorithms, SIAM J. Optim. 20(1), 2009, but with the rig that is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.comparison._trial import SKIPPED, THRESHOLDS, Trial

_POINTS = 60  # of a curve
_LEAST = 1.0  # units over which curves are shown, if none was spent


@dataclass(frozen=True, eq=False)
class Curve:
    """What a strategy in a schedule reached on a scene.

    Attributes:
        scene, strategy, schedule: of the trials.
        cost: (m,) units.
        share: (m,) of the trials that are solved within so many units; failed ones never are; without skipped ones.
        rotation_error_deg: (3, m) quartiles of the angle to the reference rig.
        score: (3, m) quartiles of the best score; None where scores do not compare.
    """

    scene: str
    strategy: str
    schedule: str
    cost: Float[np.ndarray, "m"]
    share: Float[np.ndarray, "m"]
    rotation_error_deg: Float[np.ndarray, "3 m"]
    score: Float[np.ndarray, "3 m"] | None


def curves(trials: Sequence[Trial]) -> tuple[Curve, ...]:
    """A curve for each scene, strategy and schedule that has a finished trial; all of a scene over the same cost, and
    level where they have ended: from the start if nothing was spent."""
    groups: dict[tuple[str, str, str], list[Trial]] = {}
    for trial in trials:
        if trial.status != SKIPPED:
            groups.setdefault((trial.scene, trial.strategy, trial.schedule), []).append(trial)
    ends: dict[str, float] = {}
    for trial in trials:
        if trial.course is not None:
            ends[trial.scene] = max(ends.get(trial.scene, _LEAST), trial.course["cost"][-1], trial.cost or 0.0)
    return tuple(
        _curve(key, group, np.linspace(0.0, ends[key[0]], _POINTS))
        for key, group in groups.items()
        if any(trial.course is not None for trial in group)
    )


def solved_at(trial: Trial) -> float:
    """The units after which a trial's rotation lies, and stays, within the thresholds; infinite if it never does."""
    if trial.course is None:
        return float("inf")
    pitch, yaw, roll = np.array(trial.course["axes_deg"]).T
    inside = (np.maximum(pitch, roll) <= THRESHOLDS["pitch_roll_deg"]) & (yaw <= THRESHOLDS["yaw_deg"])
    if not trial.accepted:
        return 0.0 if inside[0] else float("inf")
    if not inside[-1]:
        return float("inf")
    outside = np.flatnonzero(~inside)
    return float(trial.course["cost"][outside[-1] + 1]) if outside.size else 0.0


def _curve(key: tuple[str, str, str], trials: list[Trial], cost: np.ndarray) -> Curve:
    solved = np.array([solved_at(trial) for trial in trials])
    courses = [trial.course for trial in trials if trial.course is not None]
    scored = all(value is not None for course in courses for value in course["score"])
    return Curve(
        *key,
        cost=cost,
        share=(solved[:, None] <= cost).mean(axis=0),
        rotation_error_deg=_quartiles(courses, "rotation_error_deg", cost),
        score=_quartiles(courses, "score", cost) if scored else None,
    )


def _quartiles(courses: Sequence[dict[str, list]], name: str, cost: np.ndarray) -> Float[np.ndarray, "3 m"]:
    """The quartiles of what the trials had reached after so many units, at the last step before."""
    reached = [
        np.array(course[name], float)[np.searchsorted(course["cost"], cost, side="right") - 1] for course in courses
    ]
    return np.quantile(np.stack(reached), (0.25, 0.5, 0.75), axis=0)
