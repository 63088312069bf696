"""The answer of `recalibrate`."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal._extras import extra
from stereorecal.decision import DEFAULT as UNCHANGED, Decision, Tolerances
from stereorecal.estimation import DEFAULT, EXACT, NO_BEAMS, Beams, Estimate, SavedPrior
from stereorecal.geometry import AXES, PINHOLE, StereoRig, View
from stereorecal.io import write_text
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import BASELINE, Parameters, Reach
from stereorecal.recalibration._acceptance import Reason, RowErrors
from stereorecal.recalibration._calibration_warnings import doubts
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._difference import Difference, difference
from stereorecal.recalibration._estimated import expected_by
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME
from stereorecal.recalibration._expected import Expected
from stereorecal.recalibration._intrinsics import Intrinsics
from stereorecal.recalibration._misfit import WORTH_SAYING, Cause, Misfit
from stereorecal.recalibration._path import Waypoint, path_of
from stereorecal.recalibration._prior_use import PriorUse, known_after
from stereorecal.recalibration._ranges import RangesSeen
from stereorecal.recalibration._repair_report import report_of
from stereorecal.recalibration._request import Asked
from stereorecal.recalibration._stages import StageRun
from stereorecal.recalibration._uncertainty import Uncertainty
from stereorecal.recalibration._windows import described
from stereorecal.recordings import Pairs, as_pairs
from stereorecal.report.number_text import change, depths
from stereorecal.scoring import Correspondences
from stereorecal.scoring.host import Score
from stereorecal.strategies import Status, Trace

_SYSTEMATIC = 0.05  # pixels of radial misfit that regions share; right intrinsics leave 0.01


@dataclass(frozen=True, eq=False)
class Solution:
    """What a recalibration found.

    Attributes:
        rig: the calibration to use: the candidate if accepted, else the initial one.
        candidate: the best calibration found, accepted or not.
        initial: the calibration that the repair started from.
        accepted, reason: the verdict.
        status, message: how the search of the last stage ended.
        view, matcher: with which everything was scored; the matcher carries its measured disparity range.
        reach: within which it was searched.
        free: what could move in the calibration to use.
        cost: units that it took, by what they were spent on; `cost.total` is all of it.
        score_before, score_after: of `initial` and `candidate`, at full scale in `view`, over the pairs in `kept`.
        row_errors: epipolar errors before and after; None if the schedule has no epipolar stage, or it found nothing.
        uncertainty: of the candidate; None in the same cases.
        misfit: of the candidate; None in the same cases.
        intrinsics: what became of intrinsics that were freed; None if none were.
        looked_at: numbers of the pairs that were looked at; None: all of them.
        kept: which of those the candidate rests on.
        left_out: names of the pairs that show another rig than the others; the candidate does without them.
        disagreeing: the same where they are too many, and nothing is left out.
        stages: what each stage did.
        seconds: wall time.
        beams: ranges that had a sure match.
        ranges: what became of ranges; None if there were none.
        asked: the settings with which it can be repeated.
        estimate: of all parameters of the rig; None where the intrinsics are taken as exact, or nothing was found.
        decision: on the initial calibration, by the estimate; None in the same cases.
        prior_use: the prior that it began with, and which pairs count.
    """

    rig: StereoRig
    candidate: StereoRig
    initial: StereoRig
    accepted: bool
    reason: Reason
    status: Status
    message: str
    view: View
    matcher: AbstractMatcher
    reach: Reach
    free: Parameters
    cost: Cost
    score_before: Score
    score_after: Score
    row_errors: RowErrors | None
    uncertainty: Uncertainty | None
    misfit: Misfit | None
    intrinsics: Intrinsics | None
    kept: tuple[int, ...]
    left_out: tuple[str, ...]
    disagreeing: tuple[str, ...]
    stages: tuple[StageRun, ...]
    seconds: float
    looked_at: tuple[int, ...] | None = None
    beams: Beams = NO_BEAMS
    ranges: RangesSeen | None = None
    asked: Asked | None = None
    estimate: Estimate | None = None
    decision: Decision | None = None
    prior_use: PriorUse | None = None

    @cached_property
    def prior(self) -> SavedPrior | None:
        """What is known of the calibration to use, for the next `recalibrate` with it (`prior=`) and for
        `sr.io.save_rig`; None: no more than of any calibration. Where the images fit no rig, it is what was known
        before."""
        if self.prior_use is None:
            return None
        good = self.reason.healthy
        return known_after(self.prior_use, self.estimate, self.initial, self.rig, self._kept_of_all, good=good)

    @property
    def images_kept(self) -> tuple[str, ...]:
        """Fingerprints of the pairs that it rests on."""
        use = self.prior_use
        return () if use is None else tuple(use.images[number] for number in self._kept_of_all)

    @property
    def _kept_of_all(self) -> tuple[int, ...]:
        """Among all pairs that were given."""
        return self.kept if self.looked_at is None else tuple(self.looked_at[number] for number in self.kept)

    @property
    def trace(self) -> Trace | None:
        """The evaluations of the last run of a strategy; None if there was nothing to run one on."""
        runs = [run for stage in self.stages for run in stage.runs]
        return runs[-1].trace if runs else None

    @property
    def path(self) -> tuple[Waypoint, ...]:
        """Where the repair began, where each stage began and ended, and each new best of the stages on the count."""
        before = self.cost.survey + self.cost.starts - sum(stage.survey_cost for stage in self.stages)
        path = path_of(self.initial, before, self.stages)
        if self.estimate is None:
            return path
        return (*path[:-1], replace(path[-1], extrinsics=np.asarray(self.candidate.extrinsics)))

    @property
    def evaluations(self) -> int:
        """Number of evaluations over all stages."""
        return sum(stage.evaluations for stage in self.stages)

    @property
    def covariance(self) -> Float[np.ndarray, "n n"] | None:
        """Of the parameters of `uncertainty.names`: degrees, percent of the baseline or of the focal length, pixels;
        of pitch, yaw, roll, y, z by default. Around the candidate; None without an epipolar
        stage."""
        return None if self.uncertainty is None else self.uncertainty.covariance

    @property
    def change(self) -> Float[np.ndarray, "6"]:
        """Candidate minus given extrinsics: pitch, yaw, roll [rad], x, y, z [m]."""
        return np.asarray(self.candidate.extrinsics) - np.asarray(self.initial.extrinsics)

    @cached_property
    def expected(self) -> Expected | None:
        """What to expect of the calibration to use: rows over the view and depth, with what misfit and intrinsics that
        were held may do; None without an epipolar stage, or where the calibration is known to be bad."""
        if self.estimate is None or self.found is None or not self.reason.healthy:
            return None
        return expected_by(self.estimate, self.rig, self.view)

    @property
    def found(self) -> Correspondences | None:
        """The last correspondences, of the pairs that are kept."""
        found = next((stage.found for stage in reversed(self.stages) if stage.found is not None), None)
        if found is None or len(self.kept) == len(found.weight):
            return found
        parts = {name: np.asarray(getattr(found, name))[list(self.kept)] for name in ("left", "right", "weight")}
        tile = np.asarray(found.tile)[list(self.kept)] % TILES_OF_A_FRAME
        return replace(found, **parts, tile=tile + TILES_OF_A_FRAME * np.arange(len(tile), dtype=np.int32)[:, None])

    @property
    def tolerances(self) -> Tolerances:
        """By which it was decided."""
        return UNCHANGED if self.asked is None else self.asked.tolerances

    @property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on values of the initial calibration that hardly any rig has."""
        return doubts(self.initial)

    @property
    def difference(self) -> Difference:
        """What the candidate changes against the initial calibration: axes, rows over the view, depth."""
        return difference(self.initial, self.candidate, view=self.view)

    @property
    def depth_error_percent(self) -> Mapping[int, float]:
        """The depth error of the initial calibration in percent, if the candidate is right, at 5, 10, 30 and 100
        baselines; infinite where a point seems to lie beyond infinity."""
        return self.difference.depth_error_percent

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
        with extra("figures", "an HTML page"):
            from stereorecal.report.repair_page import repair_page
        every = as_pairs(pairs)
        if self.looked_at is not None:
            if not every or max(self.looked_at) >= len(every):
                raise InputError("these are not the pairs that were repaired; give the same, in the same order.")
            dropped = 0 if self.prior_use is None else self.prior_use.dropped
            if dropped:
                absent = (*absent, (f"{dropped} {'pair' if dropped == 1 else 'pairs'}", "used by an earlier repair"))
            if rest := len(every) - len(self.looked_at) - dropped:
                absent = (*absent, (f"{rest} other {'pair' if rest == 1 else 'pairs'}", "others show more texture"))
            every = tuple(every[number] for number in self.looked_at)
        page = repair_page(report_of(self, every, name, command, settings or {}, absent))
        write_text(path, page, replace=overwrite)

    def __str__(self) -> str:
        verdict = "accepted" if self.accepted else "not accepted, the initial calibration stays"
        lines = [
            f"{verdict}: {self.reason.value}",
            f"search   {self.message} ({self.evaluations} evaluations, {self.seconds:.1f} s)",
            f"before   {self.score_before}" + self._rows("before"),
            f"after    {self.score_after}" + self._rows("after"),
            *(self._axis(index, name) for index, name in enumerate(AXES)),
        ]
        if self.view.projection != PINHOLE:
            lines.append(f"view     {self.view}")
        lines += [f"check    {doubt}" for doubt in self.doubts]
        if self.prior_use is not None and str(self.prior_use) not in (DEFAULT, EXACT):
            lines.append(f"prior    {self.prior_use}")
        if self.misfit is not None and (said := self._of(self.misfit)):
            lines.append(f"misfit   {said}")
        if self.intrinsics is not None:
            lines.append(str(self.intrinsics))
        if self.ranges is not None:
            lines.append(f"ranges   {self.ranges}")
        if self.estimate is not None and self.estimate.windows:
            lines.append(f"motion   {described(self.estimate)}")
        if self.left_out:
            lines.append(f"left out, since they disagree with the others: {', '.join(self.left_out)}")
        if self.disagreeing:
            lines.append(f"these disagree with others: {', '.join(self.disagreeing)}")
        if self.uncertainty is not None and self.uncertainty.undetermined:
            lines.append(f"not determined by these images: {'; '.join(self.uncertainty.undetermined)}")
        if self.expected is not None:
            lines.append(f"expect   {self.expected}")
        if self.accepted:
            lines.append(self._depth_before)
        return "\n".join(lines)

    @property
    def _depth_before(self) -> str:
        """What the repair says of the depth of the initial calibration."""
        if self.decision is not None and self.decision.keeps_depth:
            if self.estimate is not None and self.estimate.windows:
                return "depth    stays as it was calibrated: neither rows nor the rig's motion tell it better"
            return "depth    stays as it was calibrated: rows do not tell it; frames that move, or ranges, would"
        if self.estimate is None:
            return f"depth was off: {depths(self.depth_error_percent)}"
        errors = self.estimate.depth_error_percent(np.zeros(len(self.estimate.names)))
        ends = {d: dict.fromkeys(change(end, "far") for end in (low, high)) for d, (_, low, high) in errors.items()}
        return "depth was off: " + ", ".join(f"{' to '.join(both)} at {d} B" for d, both in ends.items())

    def _of(self, left: Misfit) -> str | None:
        """What is worth saying of the misfit."""
        if left.cause is Cause.RADIAL and left.alike > _SYSTEMATIC:
            remedy = "; free them with several scenes" if self.intrinsics is None else ""
            return f"the intrinsics do not fit: {left.alike:.2f} px of the rows' error is systematic{remedy}"
        if left.high > WORTH_SAYING or self.reason is Reason.MISFIT:
            return f"{left.high:.2f} px in the worst tenth of the regions; {left.cause.value}"
        return None

    def _rows(self, when: str) -> str:
        return "" if self.row_errors is None else f", row error {getattr(self.row_errors, when):.2f} px"

    def _axis(self, index: int, name: str) -> str:
        before, change = self.initial.extrinsics[index], self.change[index]
        factor, unit = (180 / np.pi, "deg") if index < 3 else (1e3, "mm")
        after = before + change
        line = (
            f"{name:<6} {factor * before:+9.3f} -> {factor * after:+9.3f} {unit:<3} changed by {factor * change:+8.3f}"
        )
        name = BASELINE if name == "x" else name
        if self.uncertainty is None or name not in self.uncertainty.names or not self.reason.healthy:
            return line  # no interval: it would be that of an answer that was found wrong
        half_width = self.uncertainty.interval[self.uncertainty.names.index(name)]
        if index >= 3:
            half_width *= 10.0 * float(self.initial.baseline)  # percent of the baseline to mm
        return f"{line} ± {half_width:.3f}"
