"""A solution as plain data: what the JSON of the command line holds and tables show."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from stereorecal._arrays import json_data
from stereorecal.estimation import Estimate
from stereorecal.geometry import AXES, StereoRig
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._motion_report import motion_as_dict
from stereorecal.recalibration._result import AbstractResult, Condition
from stereorecal.recalibration._stages import StageRun
from stereorecal.scoring.host import Score


def solution_as_dict(solution: AbstractResult, *, expected: bool = True) -> dict[str, Any]:
    """Lists, text and finite numbers; None where a number is missing or infinite.

    Args:
        expected: whether to say what to expect, for which a covariance is solved for.
    """
    rows, known, baseline = solution.row_errors, solution.uncertainty, float(solution.initial.baseline)
    return json_data(
        {
            "accepted": solution.accepted,
            "healthy": solution.healthy,
            "condition": solution.condition.name.lower(),
            "reason": solution.reason.name.lower(),
            "verdict": solution.verdict,
            "why": solution.reason.value,
            "advice": solution.advice,
            "status": solution.status.name,
            "message": solution.message,
            "doubts": list(solution.doubts),
            "brightness": solution.shown.brightness,
            "texture": solution.shown.texture,
            "covered": solution.covered,
            "score_before": score_as_dict(solution.score_before),
            "score_after": score_as_dict(solution.score_after),
            "row_error_px": rows and {"before": rows.before, "after": rows.after, "significance": rows.significance},
            "extrinsics": {
                "before": _extrinsics(solution.initial),
                "candidate": _extrinsics(solution.candidate),
                "used": _extrinsics(solution.rig),
            },
            "change": _by_axis(AXES, [*np.degrees(solution.change[:3]), *(100 * solution.change[3:] / baseline)]),
            "main_axes": solution.main_axes if solution.condition is Condition.REPAIR else (),
            "interval_95": known and _by_axis(known.names, known.interval),
            "interval_95_by_chance": known and _by_axis(known.names, known.interval_by_chance),
            "observed": known and dict(zip(known.names, known.observed, strict=True)),
            "undetermined": known and list(known.undetermined),
            "misfit": solution.misfit and solution.misfit.as_dict(),
            "intrinsics": solution.intrinsics and solution.intrinsics.as_dict(),
            "ranges": solution.ranges and solution.ranges.as_dict(),
            "left_out": list(solution.left_out),
            "disagreeing": list(solution.disagreeing),
            "covariance": known and {"axes": known.names, "units": "deg, percent, px", "matrix": known.covariance},
            "expected": solution.expected.as_dict() if expected and solution.expected else None,
            "depth_error_percent": dict(solution.depth_error_percent),
            "depth": [
                {"distance_m": before.distance, "before": before.as_dict(), "used": used.as_dict()}
                for before, used in zip(solution.depth_before, solution.depth, strict=True)
            ],
            "estimate": solution.estimate and _estimate(solution.estimate),
            "motion": motion_as_dict(solution.estimate) if solution.estimate and solution.estimate.windows else None,
            "view": solution.view.as_dict(),
            "decision": solution.decision and solution.decision.as_dict(),
            "mismatch": solution.mismatch and solution.mismatch.as_dict(),
            "prior": solution.prior_use and solution.prior_use.as_dict(),
            "num_disparities": solution.matcher.num_disparities,
            "stages": [_stage(stage) for stage in solution.stages],
            "evaluations": solution.evaluations,
            "cost": solution.cost.budgeted,
            "cost_total": solution.cost.total,
            "cost_of": asdict(solution.cost),
            "seconds": solution.seconds,
        }
    )


def score_as_dict(score: Score) -> dict[str, Any]:
    """A count, what it is out of, and the share."""
    return {"count": score.count, "pixels": score.pixels, "fraction": score.fraction}


def _estimate(estimate: Estimate) -> dict[str, Any]:
    """All parameters of the rig, whatever was free: changes from the initial calibration."""
    low, high = estimate.intervals.T
    return {
        "names": estimate.names,
        "units": estimate.units,
        "mean": estimate.theta,
        "low_95": low,
        "high_95": high,
        "covariance": estimate.posterior.covariance,
        "misfit_px": {"of_a_frame": estimate.misfit[0], "common": estimate.misfit[1]},
        "residual_px": estimate.residual_px,
        "groups": estimate.groups,
    }


def _extrinsics(rig: StereoRig) -> dict[str, Any]:
    angles, shift = np.degrees(rig.extrinsics[:3]), rig.extrinsics[3:]
    return {
        "rotation_deg": dict(zip(AXES[:3], angles, strict=True)),
        "translation_m": dict(zip(AXES[3:], shift, strict=True)),
    }


def _by_axis(names: Sequence[str], values: Sequence[float] | np.ndarray) -> dict[str, Any]:
    """Rotations in degrees and translations in percent of the baseline, by name."""
    named = dict(zip(names, values, strict=True))
    return {
        "rotation_deg": {name: value for name, value in named.items() if name in AXES[:3]},
        "translation_percent": {name: value for name, value in named.items() if name in (*AXES[3:], BASELINE)},
    }


def _stage(done: StageRun) -> dict[str, Any]:
    return {
        "score": done.stage.score.name.lower(),
        "strategy": done.stage.solver,
        "scale": done.scale,
        "evaluations": done.evaluations,
        "cost": done.cost,
    }
