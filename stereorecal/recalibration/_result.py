"""What a recalibration found, as data, and what follows from it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from jaxtyping import Float

from stereorecal.decision import Decision, Reason, Seen, Tolerances
from stereorecal.estimation import NO_RANGES, Estimate, MatchedRanges, SavedPrior
from stereorecal.geometry import StereoRig, View
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._acceptance import RowErrors
from stereorecal.recalibration._calibration_warnings import doubts
from stereorecal.recalibration._cost import Cost
from stereorecal.recalibration._difference import Difference, difference
from stereorecal.recalibration._expected import Expected, expected_of
from stereorecal.recalibration._freed_intrinsics import Intrinsics
from stereorecal.recalibration._match_ranges import RangesSeen
from stereorecal.recalibration._mismatch import Mismatch
from stereorecal.recalibration._prior_use import PriorUse, known_after
from stereorecal.recalibration._regional_misfit import Misfit
from stereorecal.recalibration._row_residuals import TILES_OF_A_FRAME
from stereorecal.recalibration._search_path import Waypoint, path_of
from stereorecal.recalibration._settings import Settings
from stereorecal.recalibration._stages import StageRun
from stereorecal.recalibration._uncertainty import Uncertainty
from stereorecal.recalibration._verdict_text import advice_of, verdict_of
from stereorecal.scoring import Correspondences
from stereorecal.scoring.host import Score
from stereorecal.strategies import Status, Trace


@dataclass(frozen=True, eq=False)
class Findings:
    """What the images say of the candidate, and of the initial calibration.

    Attributes:
        score_before, score_after: of the initial calibration and of the candidate, at full scale, over the pairs that
            were kept.
        row_errors: epipolar errors before and after; None if the schedule has no epipolar stage, or it found nothing.
        uncertainty, misfit: of the candidate; None in the same cases.
        intrinsics: what became of intrinsics that could move; None if none could, or nothing was repaired.
        ranges: what became of ranges; None if there were none.
        matched_ranges: ranges that had a sure match.
        estimate: of all parameters of the rig; None where too little was found, or the count is all there is.
        decision: on the initial calibration, by the estimate; None in the same cases.
        seen: what the images show besides, that checks look at; None in the same cases.
        mismatch: why so little matches that these cannot be images of this rig; None: more does, or a rotation of the
            rig explains it.
    """

    score_before: Score
    score_after: Score
    row_errors: RowErrors | None = None
    uncertainty: Uncertainty | None = None
    misfit: Misfit | None = None
    intrinsics: Intrinsics | None = None
    ranges: RangesSeen | None = None
    matched_ranges: MatchedRanges = NO_RANGES
    estimate: Estimate | None = None
    decision: Decision | None = None
    seen: Seen | None = None
    mismatch: Mismatch | None = None


@dataclass(frozen=True)
class FramesUsed:
    """Which pairs a repair rests on.

    Attributes:
        selected: numbers of the pairs that were matched; None: all of them.
        used: which of those the candidate rests on.
        left_out: names of the pairs that show another rig than the others; the candidate does without them.
        disagreeing: the same where they are too many, and nothing is left out.
    """

    selected: tuple[int, ...] | None
    used: tuple[int, ...]
    left_out: tuple[str, ...] = ()
    disagreeing: tuple[str, ...] = ()

    @property
    def used_of_all(self) -> tuple[int, ...]:
        """`used`, numbered among all pairs that were given."""
        return self.used if self.selected is None else tuple(self.selected[number] for number in self.used)


@dataclass(frozen=True, eq=False)
class SearchRun:
    """How the search went.

    Attributes:
        view, matcher: with which everything was scored; the matcher carries its measured disparity range.
        stages: what each stage did.
        status, message: how the last one ended.
        cost: units that the repair took, by what they were spent on; `cost.total` is all of it.
        seconds: wall time.
    """

    view: View
    matcher: AbstractMatcher
    stages: tuple[StageRun, ...]
    status: Status
    message: str
    cost: Cost
    seconds: float


@dataclass(frozen=True, eq=False)
class AbstractResult:
    """A `Solution` without its views, which read it.

    Attributes:
        initial: the calibration that the repair started from.
        candidate: the best calibration found, accepted or not.
        reason: the verdict on the candidate.
        findings: what the images say.
        frames: which pairs it rests on.
        search: how it was searched.
        settings: with which it can be repeated; `free` is what could move in the calibration to use.
        prior_use: the prior that it began with, and which pairs count.
    """

    initial: StereoRig
    candidate: StereoRig
    reason: Reason
    findings: Findings
    frames: FramesUsed
    search: SearchRun
    settings: Settings
    prior_use: PriorUse | None = None

    def with_findings(self, **changes: Any) -> Self:
        """The same with other findings, by the names of `Findings`."""
        return replace(self, findings=replace(self.findings, **changes))

    @property
    def accepted(self) -> bool:
        """Whether the candidate is the calibration to use."""
        return self.reason.accepted

    @property
    def verdict(self) -> str:
        """In one short sentence."""
        if self.findings.mismatch is not None:
            return self.findings.mismatch.verdict
        if self.reason is Reason.TOO_LITTLE_TEXTURE and self.findings.seen is not None and self.findings.seen.problem:
            return f"Cannot tell: {self.findings.seen.problem}."
        pairs = len(self.frames.used) + len(self.frames.left_out)
        return verdict_of(self.reason, self.decision, pairs, repaired=True)

    @property
    def advice(self) -> str:
        """What to do."""
        if self.findings.mismatch is not None:
            return self.findings.mismatch.advice
        return advice_of(self.reason, intrinsics_change=self.intrinsics is not None and self.intrinsics.changed)

    @property
    def rig(self) -> StereoRig:
        """The calibration to use: the candidate if accepted, else the initial one."""
        return self.candidate if self.accepted else self.initial

    @property
    def score_before(self) -> Score:
        """Of the initial calibration, at full scale, over the pairs that were kept."""
        return self.findings.score_before

    @property
    def score_after(self) -> Score:
        """The same of the candidate."""
        return self.findings.score_after

    @property
    def row_errors(self) -> RowErrors | None:
        """Epipolar errors before and after; None if the schedule has no epipolar stage, or it found nothing."""
        return self.findings.row_errors

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of the candidate; None in the same cases."""
        return self.findings.uncertainty

    @property
    def misfit(self) -> Misfit | None:
        """Of the candidate; None in the same cases."""
        return self.findings.misfit

    @property
    def intrinsics(self) -> Intrinsics | None:
        """What became of intrinsics that could move; None if none could, or nothing was repaired."""
        return self.findings.intrinsics

    @property
    def ranges(self) -> RangesSeen | None:
        """What became of ranges; None if there were none."""
        return self.findings.ranges

    @property
    def estimate(self) -> Estimate | None:
        """Of all parameters of the rig; None where too little was found, or the count is all there is."""
        return self.findings.estimate

    @property
    def decision(self) -> Decision | None:
        """On the initial calibration, by the estimate; None in the same cases."""
        return self.findings.decision

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the pairs that show another rig than the others; the candidate does without them."""
        return self.frames.left_out

    @property
    def disagreeing(self) -> tuple[str, ...]:
        """The same where they are too many, and nothing is left out."""
        return self.frames.disagreeing

    @property
    def view(self) -> View:
        """In which everything was scored."""
        return self.search.view

    @property
    def matcher(self) -> AbstractMatcher:
        """With its measured disparity range."""
        return self.search.matcher

    @property
    def stages(self) -> tuple[StageRun, ...]:
        """What each stage of the schedule did."""
        return self.search.stages

    @property
    def status(self) -> Status:
        """How the search ended."""
        return self.search.status

    @property
    def message(self) -> str:
        """The same in words."""
        return self.search.message

    @property
    def cost(self) -> Cost:
        """Units that it took, by what they were spent on; `cost.total` is all of it."""
        return self.search.cost

    @property
    def seconds(self) -> float:
        """Wall time."""
        return self.search.seconds

    @property
    def leaves_epipolar_error(self) -> bool:
        """Whether it is a repair that leaves, as likely as not, more epipolar error than good calibrations have."""
        if not self.accepted or self.decision is None:
            return False
        return bool(self.decision.rows_px[1, 0] > self.tolerances.good_rows_px)

    @property
    def tolerances(self) -> Tolerances:
        """By which it was decided."""
        return self.settings.tolerances

    @cached_property
    def prior(self) -> SavedPrior | None:
        """What is known of the calibration to use, for the next `recalibrate` with it (`prior=`) and for
        `sr.io.save_rig`; None: no more than of any calibration. Where the images fit no rig, it is what was known
        before."""
        if self.prior_use is None:
            return None
        good = self.reason.healthy
        return known_after(self.prior_use, self.estimate, self.initial, self.rig, self.frames.used_of_all, good=good)

    @property
    def used_images(self) -> tuple[str, ...]:
        """Fingerprints of the pairs that it rests on."""
        use = self.prior_use
        return () if use is None else tuple(use.images[number] for number in self.frames.used_of_all)

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
        if self.estimate is None or self.decision is None or self.found is None or not self.reason.healthy:
            return None
        rows_px = float(self.decision.rows_px[int(self.accepted), 0])
        return expected_of(self.estimate, self.rig, self.view, rows_px)

    @property
    def found(self) -> Correspondences | None:
        """The last correspondences, of the pairs that are kept; of fewer, if a budget ended in a stage that looks at
        fewer."""
        found, used = next((s.found for s in reversed(self.stages) if s.found is not None), None), self.frames.used
        if found is None or len(used) >= len(found.weight):
            return found
        parts = {name: np.asarray(getattr(found, name))[list(used)] for name in ("left", "right", "weight")}
        tile = np.asarray(found.tile)[list(used)] % TILES_OF_A_FRAME
        return replace(found, **parts, tile=tile + TILES_OF_A_FRAME * np.arange(len(tile), dtype=np.int32)[:, None])

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
