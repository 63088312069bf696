"""The answer of `recalibrate`, with its views: text, plain data for JSON and tables, a page."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereorecal._arrays import json_data
from stereorecal._errors import as_input_error, extra
from stereorecal.estimation import Estimate
from stereorecal.geometry import AXES, StereoRig
from stereorecal.objectives import BASELINE
from stereorecal.recalibration._facts import SAYS_NOTHING, repair_text
from stereorecal.recalibration._motion_windows import motion_as_dict
from stereorecal.recalibration._result import AbstractResult, Condition
from stereorecal.recalibration._stages import StageRun
from stereorecal.recordings import Pairs, as_pairs
from stereorecal.scoring.host import Score


@dataclass(frozen=True, eq=False)
class Solution(AbstractResult):
    """What a recalibration found, or a look at the images alone (`health`): `solution.rig` is the calibration to use;
    printed, it says what a person wants to know.

    Attributes:
        initial: the calibration that the repair started from.
        candidate: the best calibration found, accepted or not.
        reason: the verdict on the candidate.
        score_before, score_after: of the initial calibration and of the candidate, at full scale, over the pairs that
            were kept.
        selected: numbers of the pairs that were matched, among those that were given.
        used: numbers of the pairs that the candidate rests on, among those that were matched.
        shown: light and texture of the images, of the frame that shows most.
        view, matcher: with which everything was scored; the matcher carries its measured disparity range.
        stages: what each stage of the schedule did.
        status, message: how the search ended.
        cost: units that the repair took, by what they were spent on; `cost.total` is all of it.
        seconds: wall time.
        settings: with which it can be repeated; `free` is what could move in the calibration to use.
        left_out: names of the pairs that show another rig than the others; the candidate does without them.
        disagreeing: the same where they are too many, and nothing is left out.
        intrinsics: what became of intrinsics that could move; None if none could, or nothing was repaired.
        ranges: what became of ranges; None if there were none.
        estimate: of all parameters of the rig; None where too little was found, or the count is all there is.
        decision: on the initial calibration, by the estimate; None in the same cases.
        seen: what the images show besides, that checks look at; None in the same cases.
        mismatch: why so little matches that these cannot be images of this rig; None: more does, or a rotation of the
            rig explains it.
        prior_use: the prior that it began with, and which pairs count: all of them in a look, from which nothing is
            learnt. None inside comparisons and watches.
        searched: False of a look, which says what a repair begins with.
    """

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: lists, text and finite numbers; None where a number is missing or infinite."""
        baseline, telling = float(self.initial.baseline), self.reason not in SAYS_NOTHING
        found = (self.row_errors, self.uncertainty, self.misfit, self.estimate, self.decision)
        rows, known, misfit, estimate, decision = found if telling else (None,) * 5  # of matches by chance
        return json_data(
            {
                "accepted": self.accepted,
                "healthy": self.healthy,
                "condition": self.condition.name.lower(),
                "reason": self.reason.name.lower(),
                "verdict": self.verdict,
                "why": self.reason.value,
                "advice": self.advice,
                "status": self.status.name,
                "message": self.message,
                "doubts": list(self.doubts),
                "brightness": self.shown.brightness,
                "texture": self.shown.texture,
                "covered": self.covered,
                "score_before": _score(self.score_before),
                "score_after": _score(self.score_after),
                "row_error_px": rows,
                "extrinsics": {
                    "before": _extrinsics(self.initial),
                    "candidate": _extrinsics(self.candidate),
                    "used": _extrinsics(self.rig),
                },
                "change": _by_axis(AXES, [*np.degrees(self.change[:3]), *(100 * self.change[3:] / baseline)]),
                "main_axes": self.main_axes if telling and self.condition is Condition.REPAIR else (),
                "interval_95": known and _by_axis(known.names, known.interval),
                "observed": known and dict(zip(known.names, known.observed, strict=True)),
                "undetermined": known and list(known.undetermined),
                "misfit": misfit and misfit.as_dict(),
                "intrinsics": self.intrinsics and self.intrinsics.as_dict(),
                "ranges": self.ranges and self.ranges.as_dict(),
                "left_out": list(self.left_out),
                "disagreeing": list(self.disagreeing),
                "covariance": known and {"axes": known.names, "units": "deg, percent", "matrix": known.covariance},
                "expected": self.expected and self.expected.as_dict(),
                "depth_error_percent": dict(self.depth_error_percent) if telling else {},
                "depth": [
                    {"distance_m": before.distance, "before": before.as_dict(), "used": used.as_dict()}
                    for before, used in zip(self.depth_before, self.depth, strict=True)
                ],
                "estimate": estimate and _estimate(estimate),
                "motion": motion_as_dict(estimate) if estimate and estimate.windows else None,
                "view": self.view.as_dict(),
                "decision": decision and decision.as_dict(),
                "mismatch": self.mismatch and self.mismatch.as_dict(),
                "prior": self.prior_use and self.prior_use.as_dict(),
                "num_disparities": self.matcher.num_disparities,
                "stages": [_stage(stage) for stage in self.stages],
                "evaluations": self.evaluations,
                "cost": self.cost.budgeted,
                "cost_total": self.cost.total,
                "cost_of": self.cost,
                "seconds": self.seconds,
            }
        )

    def to_html(
        self,
        path: str | os.PathLike[str],
        pairs: Pairs,
        *,
        name: str = "",
        command: str | None = None,
        settings: Mapping[str, Any] | None = None,
        absent: Sequence[tuple[str, str]] = (),
        overwrite: bool = True,
    ) -> None:
        """Write one HTML page that needs nothing else, whole or not at all: the verdict, pictures of one pair before
        and after, where rows fit and where not, and what is needed to run it again.

        Args:
            pairs: those that were repaired, in their order.
            name: of the recording.
            command: that repeats it, as it can be pasted into a shell.
            settings: what else is needed to run it again, or was asked for in other words; plain data.
            absent: names of frames that did not come to the repair, each with a reason.
            overwrite: whether an existing file may be replaced.

        Raises:
            InputError: if jinja2 or matplotlib is not installed, the pairs are not those of the solution, a file exists
                that must stay, or the place cannot be written to.
        """
        from stereorecal.io import write_text

        with extra("figures", "an HTML page"):
            from stereorecal.recalibration._repair_report import report_of
            from stereorecal.report.repair_page import repair_page
        page = repair_page(report_of(self, as_pairs(pairs), name, command, settings or {}, absent))
        write_text(path, page, replace=overwrite)

    def to_rerun(
        self, path: str | os.PathLike[str] | None, pairs: Pairs, *, name: str = "", overwrite: bool = True
    ) -> None:
        """Write a recording for Rerun's viewer (`rerun FILE`), whole or not at all, or show it: what the page shows, at
        full size, before and after side by side.

        Args:
            path: of the file, such as "repair.rrd"; None opens the viewer.
            pairs: those that were repaired, in their order.
            name: of the recording.
            overwrite: whether an existing file may be replaced.

        Raises:
            InputError: if rerun-sdk or matplotlib is not installed, the pairs are not those of the solution, a file
                exists that must stay, the place cannot be written to, or there is no screen.
        """
        from stereorecal.io import write_bytes

        with extra("rerun", "a Rerun recording"):
            from stereorecal.recalibration._repair_report import report_of
            from stereorecal.report.repair_recording import log_repair, repair_layout
            from stereorecal.report.rerun_streams import NoViewer, memory_stream, viewer_stream
        report = report_of(self, as_pairs(pairs), name, None, {}, ())
        layout = repair_layout(report)
        if path is None:
            with as_input_error(NoViewer):
                stream = viewer_stream(layout, name)
            log_repair(stream, report)
            stream.flush()
            return
        stream, memory = memory_stream(layout, name)
        log_repair(stream, report)
        write_bytes(path, memory.drain_as_bytes(), replace=overwrite)

    def __str__(self) -> str:
        return repair_text(self)


def _score(score: Score) -> dict[str, Any]:
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
        "cost": done.cost.budgeted,
    }
