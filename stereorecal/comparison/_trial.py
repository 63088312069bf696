"""One trial: one strategy repairs one decalibration of one scene; how it went, and what it did by the true rig."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._errors import NeedNotMet
from stereorecal.comparison._entrants import Entrant
from stereorecal.geometry import AXES, StereoRig, View, angle_between, axis_errors
from stereorecal.matching import AbstractMatcher, name_of
from stereorecal.objectives import Parameters, Reach, count_chart, count_objective
from stereorecal.recalibration import Case, Solution, as_settings, difference, recalibrate_case
from stereorecal.recordings import Scene
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import score
from stereorecal.strategies import Budget, Objective

DISTANCES = (10, 30)  # baselines, at which depth is compared

SCORE_AT = (100, 300, 1000)  # units, at which the best score is noted: spread evenly over a logarithmic axis
SKIPPED, FAILED = "SKIPPED", "FAILED"  # the status of a trial that did not run, or crashed; else the name of a `Status`

THRESHOLDS = {
    "ratio": 0.98,  # of a success, at least
    "pitch_roll_deg": 0.05,  # errors of a success, at most: half a row at a focal length of 600 pixels
    "yaw_deg": 0.2,  # rows hardly show it
    "flagged_ratio": 1.05,  # above it a wrong calibration may score higher than the right one
    "harmful_rows_px": 0.05,  # by which the epipolar error may grow
    "harmful_depth_percent": 1.0,  # points by which the |error| of depth at 30 baselines may grow
}


def errors_by_truth(start: StereoRig, final: StereoRig, truth: StereoRig, view: View) -> dict[str, Any]:
    """The errors of both rigs, under "start" and "final": "row_error_px", the median |epipolar error| over the view of
    points at 10 baselines and at infinity (NaN where nothing is seen), and "depth_error_percent" by distance in
    baselines (positive: too far; infinite where rays do not meet)."""
    wrong = {name: difference(rig, truth, view=view) for name, rig in (("start", start), ("final", final))}
    return {
        "row_error_px": {name: one.row_error_median for name, one in wrong.items()},
        "depth_error_percent": {
            name: {str(distance): one.depth_error_percent[distance] for distance in DISTANCES}
            for name, one in wrong.items()
        },
    }


def is_harmful(rows_px: tuple[float, float], depth_percent: tuple[float, float] = (0.0, 0.0)) -> bool:
    """Whether the epipolar error, before and after, grows by more than matters, or the |error| of depth at 30 baselines
    does, or either was known before and is not any more."""
    before, after = map(abs, depth_percent)
    worse_depth = _grows(before, after, THRESHOLDS["harmful_depth_percent"])
    return worse_depth or _grows(*rows_px, THRESHOLDS["harmful_rows_px"])


def _grows(before: float, after: float, most: float) -> bool:
    return bool(after > before + most or (np.isnan(after) and not np.isnan(before)))


@dataclass(frozen=True)
class JudgedScene:
    """A scene, and what its trials are run and judged with.

    Attributes:
        rig: its calibration, from which drifts are drawn.
        matcher: with its disparity range.
        reference: the rig that N_GT is counted with and errors are measured against.
        worth: of the reference: "truth", "consensus" or "stored".
    """

    scene: Scene
    rig: StereoRig
    matcher: AbstractMatcher
    reference: StereoRig
    worth: str


@dataclass(frozen=True)
class Task:
    """All that a worker needs for one trial; pickles small when the scene's pairs came from files.

    Attributes:
        start: the decalibrated rig.
        free: what the strategies search.
    """

    judged: JudgedScene
    entrant: Entrant
    start: StereoRig
    draw: int
    reach: Reach
    budget: Budget
    seed: int
    free: Parameters


@dataclass(frozen=True)
class Trial:
    """One row of a comparison; numbers that a skipped or failed trial does not have are None.

    Attributes:
        score_initial, score_final, score_reference: the paper's N_i, N_o and N_GT (of the reference rig): counts at
            full scale, all in the view of the start and over all frames.
        ratio: the paper's r = N_o / N_GT.
        rotation_error_deg: |pitch|, |yaw|, |roll| error against the reference rig.
        translation_error_percent: |y|, |z| error in percent of the baseline.
        strategies: names of all strategies that ran; `strategy` is the one that was asked for.
        evaluations: number of evaluations of the score.
        cost: units spent on them and on finding correspondences, which is what a budget pays for.
        cost_total: units of the whole repair, with the survey, the choice of a start and the judging.
        score_at: best value of the stage's own score after 100, 300 and 1000 units; None where a schedule has several
            stages, whose scores do not compare.
        course: how it went, after each step: "cost" [units], "rotation_error_deg" (angle to the reference),
            "axes_deg" (its pitch, yaw and roll) and "score" (the best so far; None where scores do not compare). Of the
            candidate, accepted or not. A strategy that evaluates nothing itself, inside JAX or on images, has no steps
            between its start and its end.
        extrinsics: "start", "final" and "reference": pitch, yaw, roll [rad], x, y, z [m].
        by_truth: `errors_by_truth` of the start and of what the repair ended with; None unless the reference is the
            truth.
    """

    scene: str
    strategy: str
    matcher: str
    schedule: str
    draw: int
    status: str
    message: str
    accepted: bool
    reason: str | None
    reference: str
    strategies: tuple[str, ...]
    score_initial: int | None = None
    score_final: int | None = None
    score_reference: int | None = None
    ratio: float | None = None
    rotation_error_deg: dict[str, float] | None = None
    translation_error_percent: dict[str, float] | None = None
    evaluations: int | None = None
    cost: float | None = None
    cost_total: float | None = None
    seconds: float | None = None
    score_at: dict[str, float | None] | None = None
    course: dict[str, list] | None = None
    extrinsics: dict[str, list[float]] | None = None
    by_truth: dict[str, Any] | None = None


def run_trial(task: Task) -> Trial:
    """Run one trial. Whatever goes wrong becomes a SKIPPED or FAILED row, never an exception."""
    try:
        return _trial_of_solution(task, _repair(task))
    except NeedNotMet as error:
        return _unfinished(task, SKIPPED, str(error))
    except Exception as error:
        return failed(task, error)


def failed(task: Task, error: BaseException) -> Trial:
    """The FAILED row of a task whose worker raised."""
    return _unfinished(task, FAILED, str(error) or repr(error))


def _repair(task: Task) -> Solution:
    matcher, named = task.judged.matcher, ("reach", "budget", "seed", "free")
    options = {"matcher": matcher, "schedule": task.entrant.schedule} | {name: getattr(task, name) for name in named}
    settings = as_settings(options)
    return recalibrate_case(Case(pyramid(task.start, task.judged.scene.pairs), settings, matcher, settings.free))


def _trial_of_solution(task: Task, solution: Solution) -> Trial:
    reference, one_score = task.judged.reference, len(task.entrant.schedule.stages) == 1
    initial, final, target = _counts(task, solution)
    errors = axis_errors(solution.rig, reference)
    return Trial(
        **_key(task),
        status=solution.status.name,
        message=solution.message,
        accepted=solution.accepted,
        reason=solution.reason.name.lower(),
        score_initial=initial,
        score_final=final,
        score_reference=target,
        ratio=final / target if target else None,
        rotation_error_deg={name: errors[name] for name in AXES[:3]},
        translation_error_percent={name: errors[name] for name in "yz"},
        evaluations=solution.evaluations,
        cost=solution.cost.budgeted,
        cost_total=solution.cost.total,
        seconds=solution.seconds,
        score_at=_scores_at(task, solution) if one_score else None,
        course=course_of(reference, solution, one_score=one_score),
        extrinsics={
            when: list(map(float, rig.extrinsics))
            for when, rig in (("start", task.start), ("final", solution.rig), ("reference", reference))
        },
        by_truth=(
            errors_by_truth(task.start, solution.rig, reference, solution.view)
            if task.judged.worth == "truth"
            else None
        ),
    )


def _counts(task: Task, solution: Solution) -> tuple[int, int, int]:
    """The counts of the start, of what the repair ended with and of the reference, over all frames: strategies do not
    compare on those that each of them left out."""
    pairs, how = task.judged.scene.pairs, {"matcher": task.judged.matcher, "view": solution.view}
    before, after = solution.score_before, solution.score_after
    if len(solution.used) < len(pairs):
        before, after = (score(rig, pairs, **how) for rig in (solution.initial, solution.candidate))
    final = after if solution.accepted else before
    return before.count, final.count, score(task.judged.reference, pairs, **how).count


def _scores_at(task: Task, solution: Solution) -> dict[str, float | None] | None:
    """What a strategy had reached at each mark. Points that it declared without a value are evaluated now; one that
    spent nothing had its candidate from the beginning."""
    trace = solution.trace
    if trace is None:  # the budget ended before the stage began
        return None
    found = {cost: [trace.best_within(cost)] for cost in SCORE_AT}
    if len(trace.values):
        unvalued = {cost: trace.charged_within(cost) for cost in SCORE_AT}
    else:
        point = count_chart(task.start, task.reach, task.free).coordinates_of(solution.candidate)
        unvalued = dict.fromkeys(SCORE_AT, np.clip(point, -1.0, 1.0))
    wanted = {cost: point for cost, point in unvalued.items() if point is not None}
    if wanted:
        judge = _judge(task, solution.view)
        for cost, point in wanted.items():
            found[cost].append(judge.value(point))
    return {str(cost): max((v for v in values if v is not None), default=None) for cost, values in found.items()}


def _judge(task: Task, view: View) -> Objective:
    """The score of the only stage."""
    images, matcher = pyramid(task.start, task.judged.scene.pairs, view), task.judged.matcher
    chart = count_chart(task.start, task.reach, task.free)
    return count_objective(images, matcher, chart, scale=task.entrant.schedule.stages[0].scale)


def _unfinished(task: Task, status: str, message: str) -> Trial:
    return Trial(**_key(task), status=status, message=message, accepted=False, reason=None)


def _key(task: Task) -> dict:
    return {
        "scene": task.judged.scene.name,
        "strategy": task.entrant.name,
        "matcher": name_of(task.judged.matcher),
        "schedule": task.entrant.schedule.name,
        "draw": task.draw,
        "reference": task.judged.worth,
        "strategies": tuple(task.entrant.running),
    }


def course_of(reference: StereoRig, solution: Solution, *, one_score: bool) -> dict[str, list]:
    """See `Trial.course`; `one_score`: all of the schedule has the same score."""
    steps = solution.path
    rigs = [solution.initial.with_extrinsics(step.extrinsics) for step in steps]
    cost = [float(step.cost) for step in steps]
    score: list[float | None] = [None] * len(steps)
    runs = [run for stage in solution.stages for run in stage.runs]
    if one_score and runs:
        start, trace = runs[-1].start_value, runs[-1].trace
        reached = [trace.best_within(spent) for spent in cost]
        *before, last = (float(start if best is None else max(start, best)) for best in reached)
        # The nomination, which the core has judged, is all that a strategy has which evaluates nothing itself.
        score = [*before, max(last, float(runs[-1].value))]
    return {
        "cost": cost,
        "rotation_error_deg": [float(np.degrees(angle_between(rig.rotation, reference.rotation))) for rig in rigs],
        "axes_deg": [list(axis_errors(rig, reference).values())[:3] for rig in rigs],
        "score": score,
    }
