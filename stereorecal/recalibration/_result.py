"""What a recalibration found, as data, and what follows from it; its verdict, and what to do."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from stereorecal.decision import Decision, Reason, Seen
from stereorecal.estimation import Estimate, SavedPrior
from stereorecal.geometry import StereoRig, View
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import EXTRINSICS, differences_at
from stereorecal.recalibration._difference import Difference, difference
from stereorecal.recalibration._expected import DepthError, Expected, reported_depths
from stereorecal.recalibration._match_ranges import RangesSeen
from stereorecal.recalibration._mismatch import Mismatch, doubts
from stereorecal.recalibration._prior_use import PriorUse, known_after
from stereorecal.recalibration._row_residuals import Misfit, RowErrors, row_errors_and_misfit
from stereorecal.recalibration._settings import Settings
from stereorecal.recalibration._stages import Cost, StageRun, Waypoint, last_matched, path_of
from stereorecal.recalibration._uncertainty import Intrinsics, Uncertainty, uncertainty_of
from stereorecal.scoring import Correspondences, ImageQuality
from stereorecal.scoring.host import Score
from stereorecal.strategies import Status, Trace

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


class Condition(enum.Enum):
    """The verdict on a calibration."""

    HEALTHY = "healthy"
    REPAIR = "repair it"
    WRONG_INPUT = "wrong input"
    CANNOT_TELL = "cannot tell"


class DepthOutcome(enum.Enum):
    """What an improvement does to depth; the value is what a verdict says."""

    KEPT = "kept as calibrated"
    CORRECTED = "corrected"
    IN_PART = "corrected in part"
    INSIGNIFICANT = "not significantly changed"


@dataclass(frozen=True, eq=False)
class AbstractResult:
    """A `Solution`, which says what its attributes are, without its views, which read it."""

    initial: StereoRig
    candidate: StereoRig
    reason: Reason
    score_before: Score
    score_after: Score
    selected: tuple[int, ...]
    used: tuple[int, ...]
    shown: ImageQuality
    view: View
    matcher: AbstractMatcher
    stages: tuple[StageRun, ...]
    status: Status
    message: str
    cost: Cost
    seconds: float
    settings: Settings
    left_out: tuple[str, ...] = ()
    disagreeing: tuple[str, ...] = ()
    intrinsics: Intrinsics | None = None
    ranges: RangesSeen | None = None
    estimate: Estimate | None = None
    decision: Decision | None = None
    seen: Seen | None = None
    mismatch: Mismatch | None = None
    prior_use: PriorUse | None = None
    searched: bool = True

    @property
    def accepted(self) -> bool:
        """Whether the candidate is the calibration to use."""
        return self.reason.accepted

    @property
    def condition(self) -> Condition:
        """The condition of the initial calibration. Repair, if a change is an improvement, or hardly anything matches
        of images that show enough. Healthy, if none is, and the rows are aligned where the images show something. Wrong
        input, if the images cannot be of this rig. Cannot tell, otherwise."""
        if self.mismatch is not None:
            return Condition.WRONG_INPUT
        if self.reason is Reason.ALREADY_GOOD:
            return Condition.HEALTHY
        repair = (self.accepted or self.reason is Reason.NO_MATCHES) and not self.doubts
        return Condition.REPAIR if repair else Condition.CANNOT_TELL

    @property
    def healthy(self) -> bool:
        """Whether the calibration to use is good; of a look, the initial one."""
        if not self.searched:
            return self.condition is Condition.HEALTHY
        return self.reason.healthy and not self.leaves_epipolar_error

    @property
    def doubts(self) -> tuple[str, ...]:
        """Sentences on values of the initial calibration that hardly any rig has."""
        return doubts(self.initial)

    @property
    def _doubtful(self) -> bool:
        """Whether a look has nothing to say but its doubts."""
        return not self.searched and self.condition is Condition.CANNOT_TELL and bool(self.doubts)

    @property
    def verdict(self) -> str:
        """The verdict in one short sentence, of at most twelve words."""
        if self._doubtful:
            return "Cannot tell: the calibration has values that hardly any rig has."
        if not self.searched and self.mismatch is None and self.reason is Reason.NO_MATCHES:
            return f"Repair it: {self.reason.value}."
        reason, decision, repaired = self.reason, self.decision, self.searched
        begins = "Repaired" if repaired else "Repair it"
        if self.mismatch is not None:
            return self.mismatch.verdict
        if reason is Reason.TOO_LITTLE_TEXTURE and self.shown.problem is not None:
            return f"Cannot tell: {self.shown.problem}."
        if decision is None or reason is Reason.MORE_MATCHES:
            begins = begins if reason.accepted else "Cannot tell" if reason.undetermined else "Not repaired"
            return f"{begins}: {reason.value}."
        before, after = decision.rows_px
        if reason is Reason.IMPROVED:
            depth = depth_outcome(self, decision).value
            return f"{begins}: epipolar error {before[0]:.2f} -> {after[0]:.2f} px; depth {depth}."
        if reason is Reason.ALREADY_GOOD:
            return f"Good. Epipolar error {before[0]:.2f} px where the images show something."
        if reason is Reason.CANNOT_TELL:
            pairs = len(self.used) + len(self.left_out)
            which = f"from {_NUMBERS[pairs] if pairs < len(_NUMBERS) else pairs} pair{'' if pairs == 1 else 's'}"
            return f"Cannot tell {which}: epipolar error {before[1]:.2f} to {before[2]:.2f} px."
        return f"{'Not repaired' if repaired and not reason.undetermined else 'Cannot tell'}: {reason.value}."

    @property
    def advice(self) -> str:
        """What to do. Rows make a calibration good; where its depth is off all the same, that is said, and why it
        stays."""
        if self._doubtful:
            return "Check the calibration file."
        if not self.searched and self.condition is Condition.REPAIR:
            return "Run recalibrate with these images."
        if self.mismatch is not None:
            return self.mismatch.advice
        off = [f"{error} at {error.where}" for error in self.depth_before if error.significant]
        if self.reason is not Reason.ALREADY_GOOD or self.decision is None or not off:
            return self.reason.advice
        failed = self.decision.failed
        why = "its correction does not pass all checks" if failed is None else failed.value
        return f"But depth is {' and '.join(off)}, and {why}; pairs of other places may decide."

    @property
    def covered(self) -> float:
        """Share of the image in which correspondences were found that are good to a fraction of a pixel, of the frame
        that shows most. False matches count as pixels, but hardly here."""
        return self.seen.covered if self.seen is not None else self.found.covered if self.found is not None else 0.0

    @cached_property
    def main_axes(self) -> tuple[str, ...]:
        """The extrinsics whose change alone moves rows or depth by what is noticed, what moves most first; if none
        does, the first of them. Empty where nothing was decided."""
        estimate, decision = self.estimate, self.decision
        if estimate is None or decision is None:
            return ()
        effects = {
            name: estimate.effect(np.where(np.arange(len(estimate.names)) == index, decision.theta, 0.0))
            for index, name in enumerate(estimate.names)
            if name in EXTRINSICS
        }
        most = sorted(effects, key=lambda name: -effects[name])
        return tuple(name for name in most if effects[name] > 1.0) or tuple(most[:1])

    @property
    def rig(self) -> StereoRig:
        """The calibration to use: the candidate if accepted, else the initial one."""
        return self.candidate if self.accepted else self.initial

    @property
    def leaves_epipolar_error(self) -> bool:
        """Whether it is a repair that leaves, as likely as not, more epipolar error than good calibrations have."""
        if not self.accepted or self.decision is None:
            return False
        return bool(self.decision.rows_px[1, 0] > self.settings.tolerances.good_rows_px)

    @cached_property
    def prior(self) -> SavedPrior | None:
        """What is known of the calibration to use, for the next `recalibrate` with it (`prior=`) and for
        `sr.io.save_rig`; None: no more than of any calibration. Where the images fit no rig, it is what was known
        before. None of a look, from which nothing is learnt."""
        if self.prior_use is None or not self.searched:
            return None
        good = self.reason.healthy
        return known_after(self.prior_use, self.estimate, self.initial, self.rig, self.used_images, good=good)

    @property
    def used_images(self) -> tuple[str, ...]:
        """Fingerprints of the pairs that it rests on."""
        if self.prior_use is None:
            return ()
        return tuple(self.prior_use.images[self.selected[number]] for number in self.used)

    @property
    def trace(self) -> Trace | None:
        """The evaluations of the last run of a strategy; None if there was nothing to run one on."""
        runs = [run for stage in self.stages for run in stage.runs]
        return runs[-1].trace if runs else None

    @property
    def path(self) -> tuple[Waypoint, ...]:
        """Where the repair began, where each stage began and ended, and each new best of the stages on the count."""
        before = self.cost.survey + self.cost.starts - sum(stage.cost.survey for stage in self.stages)
        stages = self.stages
        if self.estimate is not None:
            stages = (*stages[:-1], replace(stages[-1], ended=self.candidate))
        return path_of(self.initial, before, stages)

    @property
    def evaluations(self) -> int:
        """Number of evaluations over all stages."""
        return sum(stage.evaluations for stage in self.stages)

    @property
    def covariance(self) -> Float[np.ndarray, "n n"] | None:
        """The covariance of the parameters of `uncertainty.names` around the candidate, in degrees and percent of the
        baseline; of pitch, yaw, roll, y, z by default. None without an epipolar stage."""
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
        return Expected(self.estimate, self.rig, self.view, rows_px)

    @cached_property
    def _of_rows(self) -> tuple[RowErrors | None, Misfit | None]:
        """What row differences of the last correspondences show, whichever frames are kept; they themselves, a number
        for each pixel, are not kept."""
        estimate, found = self.estimate, self.found
        if estimate is None or found is None:
            return None, None
        chart, valid = estimate.chart, np.asarray(found.weight) > 0
        ends = np.zeros(chart.dim), chart.coordinates_of(self.candidate)
        before, after = (differences_at(found, chart, at)[valid] / float(found.scale) for at in ends)
        tile, independent = np.asarray(found.tile)[valid], float(found.independent)
        return row_errors_and_misfit(before, after, tile, independent, late=estimate.is_late)

    @property
    def row_errors(self) -> RowErrors | None:
        """Epipolar errors before and after; None if the schedule has no epipolar stage, or it found nothing."""
        return self._of_rows[0]

    @property
    def misfit(self) -> Misfit | None:
        """What no rig explains of the row differences, by regions; None in the same cases."""
        return self._of_rows[1]

    @cached_property
    def uncertainty(self) -> Uncertainty | None:
        """The uncertainty of the extrinsics, and of the length of the baseline where it is free, marginal over all
        others; None in the same cases."""
        if self.estimate is None:
            return None
        free = self.settings.free.of(self.initial, self.settings.reach)
        return uncertainty_of(self.estimate, self.candidate, [one for one in free if "." not in one.name])

    @property
    def found(self) -> Correspondences | None:
        """The last correspondences, without weight in pairs that are left out; of fewer pairs, if a budget ended in a
        stage that looks at fewer."""
        last = last_matched(self.stages)
        return None if last is None else last.found

    @property
    def difference(self) -> Difference:
        """What the candidate changes against the initial calibration: axes, rows over the view, depth."""
        return difference(self.initial, self.candidate, view=self.view)

    @cached_property
    def depth_before(self) -> tuple[DepthError, ...]:
        """The errors of depth of the initial calibration, at the distances of the settings; none where a check found
        the answer wrong, or that matches may be by chance. Where the images only do not determine what is better, the
        intervals hold what may be."""
        return self._depth_errors(self.initial)

    @cached_property
    def depth(self) -> tuple[DepthError, ...]:
        """The same of the calibration to use."""
        return self._depth_errors(self.rig)

    def _depth_errors(self, used: StereoRig) -> tuple[DepthError, ...]:
        by_chance = self.seen is None or self.seen.by_chance
        told = self.reason.healthy or (self.reason is Reason.CANNOT_TELL and not by_chance)
        if self.estimate is None or self.decision is None or not told:
            return ()
        theta, best = map(self.estimate.chart.coordinates_of, (used, self.rig))
        return reported_depths(self.estimate, theta, self.settings.distances, best)

    @property
    def depth_error_percent(self) -> Mapping[int, float]:
        """The depth error of the initial calibration in percent, if the candidate is right, at 5, 10, 30 and 100
        baselines; infinite where a point seems to lie beyond infinity."""
        return self.difference.depth_error_percent


def depth_outcome(result: AbstractResult, decision: Decision) -> DepthOutcome:
    """What an improvement does to depth, by its decision."""
    if not decision.depth_corrected:
        return DepthOutcome.KEPT
    if not any(error.significant for error in result.depth_before):
        return DepthOutcome.INSIGNIFICANT
    return DepthOutcome.CORRECTED if decision.depth_corrected == 1.0 else DepthOutcome.IN_PART
