"""Will depth be right? One look at the images through a calibration, without any search."""

import enum
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from stereorecal._arrays import json_data, refuse_tracers
from stereorecal.decision import ENOUGH, LIMITS, Reason, Seen, reason_of
from stereorecal.estimation import check_prior, one_blas_thread, rig_parameters
from stereorecal.geometry import PINHOLE, StereoRig, View, checked_rig, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._as_dict import score_as_dict
from stereorecal.recalibration._assessment import looked, without_mismatch
from stereorecal.recalibration._calibration_warnings import doubts
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._correction import Correction
from stereorecal.recalibration._depth_errors import DepthError, Distance, reported_depths
from stereorecal.recalibration._expected import Interval
from stereorecal.recalibration._frame_choice import selected_frames
from stereorecal.recalibration._matcher_loss import matcher_loss
from stereorecal.recalibration._mismatch import Mismatch, mismatch_of
from stereorecal.recalibration._motion_windows import check_motion, following
from stereorecal.recalibration._prepared_case import what_may_change
from stereorecal.recalibration._prior_use import prior_for_health
from stereorecal.recalibration._row_residuals import row_residuals
from stereorecal.recalibration._settings import HealthOptions, as_settings
from stereorecal.recalibration._verdict_text import advice_of, verdict_of
from stereorecal.recordings import Pairs
from stereorecal.scoring import ImageQuality, Pyramid, host, pyramid
from stereorecal.scoring.host import Score, with_measured_range

_ANGLES, _SHIFTS = ("pitch", "yaw", "roll"), ("y", "z")
HEALTH_LIMITS = {"covered": ENOUGH.covered, "covered_of_texture": ENOUGH.of_texture, **LIMITS}


class Condition(enum.Enum):
    """The verdict on a calibration."""

    HEALTHY = "healthy"
    REPAIR = "repair it"
    WRONG_INPUT = "wrong input"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True, eq=False)
class Health:
    """How well the images fit together under a calibration, and the correction that they ask for.

    Attributes:
        score: the count, in the view that was looked through.
        row_error: epipolar (row) error, as `RowErrors.before` measures it, of the matches found under the calibration
            itself: the mean over tiles of a tile's median |row difference|, pixels at full size; NaN if hardly anything
            matches, since false matches lie on the rows that they were searched on.
        reason: of the verdict, as `recalibrate` has it.
        covered: share of the image in which correspondences were found that are good to a fraction of a pixel, of the
            frame that shows most. False matches count as pixels, but hardly here.
        shown: light and texture of the images, of the frame that shows most.
        correction: of the extrinsics, that the images ask for; None if hardly anything matches.
        mismatch: why so little matches that these cannot be images of this rig; None: more does, or a rotation of the
            rig explains it.
        disagreeing: names of frames that show another rig than others, where they are too many to be left out.
        doubts: sentences on values of the calibration that hardly any rig has.
        view: that was looked through.
        pairs: how many were looked at: of many those that `recalibrate` selects.
        distances: at which errors of depth are reported; none: those that the images show.
    """

    score: Score
    row_error: float
    reason: Reason
    covered: float
    shown: ImageQuality
    correction: Correction | None
    mismatch: Mismatch | None = None
    disagreeing: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    view: View | None = None
    pairs: int = 1
    distances: tuple[Distance, ...] = ()

    @property
    def condition(self) -> Condition:
        """Repair, if a change is an improvement, or hardly anything matches of images that show enough. Healthy, if
        none is, and the rows are aligned where the images show something. Wrong input, if the images cannot be of this
        rig. Cannot tell, otherwise."""
        if self.mismatch is not None:
            return Condition.WRONG_INPUT
        if self.reason is Reason.ALREADY_GOOD:
            return Condition.HEALTHY
        repair = self.reason in (Reason.IMPROVED, Reason.NO_MATCHES) and not self.doubts
        return Condition.REPAIR if repair else Condition.CANNOT_TELL

    @property
    def healthy(self) -> bool:
        """True if the condition is."""
        return self.condition is Condition.HEALTHY

    @property
    def verdict(self) -> str:
        """In one short sentence."""
        if self.mismatch is None and self.doubts and not self.healthy:
            return "Cannot tell: the calibration has values that hardly any rig has."
        if self.mismatch is None and self.reason is Reason.NO_MATCHES:
            return f"Repair it: {self.reason.value}."
        decision = None if self.correction is None else self.correction.decision
        off, problem = any(one.significant for one in self.depth), self.shown.problem
        return verdict_of(self.reason, decision, self.pairs, self.mismatch, problem, off, repaired=False)

    @cached_property
    def depth(self) -> tuple[DepthError, ...]:
        """The errors of depth of the calibration; none where hardly anything matches."""
        if self.correction is None:
            return ()
        estimated, theta = self.correction.estimate, self.correction.decision.theta
        given = np.zeros_like(theta)
        return reported_depths(estimated, given, self.distances, theta if self.reason.accepted else given)

    @property
    def advice(self) -> str:
        """What to do."""
        if self.mismatch is None and self.doubts and not self.healthy:
            return "Check the calibration file."
        if self.condition is Condition.REPAIR:
            return "Run recalibrate with these images."
        decision = None if self.correction is None else self.correction.decision
        return advice_of(self.reason, decision, self.mismatch, self.depth)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables; what is missing or infinite is None."""
        correction = self.correction
        return json_data(
            {
                **score_as_dict(self.score),
                "row_error_px": self.row_error,
                "covered": self.covered,
                "brightness": self.shown.brightness,
                "texture": self.shown.texture,
                "healthy": self.healthy,
                "condition": self.condition.name.lower(),
                "reason": self.reason.name.lower(),
                "verdict": self.verdict,
                "advice": self.advice,
                "probability_worse": correction and correction.decision.worse,
                "probability_better": correction and correction.decision.better,
                "view": self.view and self.view.as_dict(),
                "mismatch": self.mismatch and self.mismatch.as_dict(),
                "disagreeing": self.disagreeing,
                "doubts": self.doubts,
                "axes": correction and (correction.main_axes if self.condition is Condition.REPAIR else ()),
                "correction": correction
                and {
                    "rotation_deg": {name: correction.axes[name].as_dict() for name in _ANGLES},
                    "translation_percent": {name: correction.axes[name].as_dict() for name in _SHIFTS},
                    "row_error_px": correction.row_error,
                },
                "rows_apart_px": correction and correction.rows_px.as_dict(),
                "depth_error_percent": correction
                and {distance: error.as_dict() for distance, error in correction.depth_percent.items()},
                "depth": [{"distance_m": error.distance, **error.as_dict()} for error in self.depth],
            }
        )

    def __str__(self) -> str:
        lines = [self.verdict, self.advice, *(f"check      {doubt}" for doubt in self.doubts)]
        found = self.correction
        differ = "; their rows differ by {:.2f} px in the median, {:.2f} px if corrected"
        rows = "" if found is None else differ.format(self.row_error, found.row_error)
        lines.append(f"matched    {self.score}{rows}")
        if self.view is not None and self.view.projection != PINHOLE:
            lines.append(f"view       {self.view}")
        if found is None:
            sure = f"matches that passed all checks cover {100 * self.covered:.0f} % of the image"
            return "\n".join([*lines, f"epipolar   not measured: {sure} (chance matches count as matched)"])
        rows, axes = found.rows_px, found.axes
        angles = ", ".join(f"{name} {_plus_minus(axes[name], 3)}" for name in _ANGLES)
        shifts = ", ".join(f"{name} {_plus_minus(axes[name], 2)}" for name in _SHIFTS)
        lines += [
            f"epipolar   {rows.value:.2f} px ({rows.low:.2f} to {rows.high:.2f}) where the images show something",
            f"matchers   {matcher_loss(*found.estimate.rows_seen(np.zeros_like(found.decision.theta)))}",
            *(f"depth      error at {error.where} {error}" for error in self.depth),
            f"correction {angles} deg; {shifts} % of the baseline",
        ]
        return "\n".join(lines)


def _plus_minus(found: Interval, digits: int) -> str:
    return f"{found.value:+z.{digits}f} ± {found.high - found.value:.{digits}f}"


@one_blas_thread()
def health(rig: StereoRig, pairs: Pairs, **options: Unpack[HealthOptions]) -> Health:
    """Match the pairs under the rig's calibration, and estimate once the correction that they ask for.

    `recalibrate` begins with the same look: what is healthy here stays there, what is to be repaired here is repaired.

    Args:
        options: those of `HealthOptions`, by name: `matcher, view, prior, motion, tolerances, distances`. Pairs that a
            saved prior rests on count, for nothing is learnt here.

    Raises:
        InputError: if images and calibration do not fit, the images are no left and right image of this rig, the
            prior makes no sense, or nothing can have moved.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    rig = checked_rig(rig)
    settings = as_settings(options, HealthOptions.__optional_keys__)
    images, doubtful = pyramid(rig, pairs, settings.view), doubts(rig)
    check_prior(settings.prior, rig_parameters(rig))
    prior = prior_for_health(settings.prior, rig)
    check_motion(settings.motion, len(images.pairs), prior)
    free, numbers = what_may_change(rig, replace(settings, prior=prior)), range(len(images.pairs))
    if free.shared:
        numbers = selected_frames(images.pairs, ())
        images = pyramid(rig, [images.pairs[number] for number in numbers], images.view)
    windows = following(images.pairs, numbers, settings.motion, prior)
    matcher, limits = with_measured_range(settings.matcher, images), settings.tolerances
    case = Case(images, matcher, settings.reach, free, prior, windows=windows, tolerances=limits)
    look = looked(case, settings.schedule.stages[-1])
    assert look is not None  # the default schedule ends on matches
    run, assessment = look
    covered = 0.0 if run.found is None else run.found.covered
    nothing = Health(
        score=_score(images, matcher),
        row_error=float("nan"),
        reason=reason_of(None, Seen(enough=images.enough)),
        covered=covered,
        shown=images.best_quality,
        correction=None,
        doubts=doubtful,
        view=images.view,
        pairs=len(images.pairs),
        distances=settings.distances,
    )
    if assessment is None:
        return replace(nothing, mismatch=mismatch_of(images, matcher, covered))
    assessment = without_mismatch(case, assessment)
    nothing = replace(nothing, reason=assessment.reason, mismatch=assessment.mismatch)
    if assessment.reason is Reason.FRAMES_DISAGREE:
        return replace(nothing, disagreeing=tuple(images.pairs[frame].name for frame in assessment.excluded))
    if assessment.reason in (Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES):
        return nothing
    rows = row_residuals(case.chart, assessment.found, assessment.candidate).errors
    correction = Correction(assessment.estimate, assessment.decision, rows.after)
    return replace(nothing, row_error=rows.before, covered=assessment.seen.covered, correction=correction)


def _score(images: Pyramid, matcher: AbstractMatcher) -> Score:
    whole, extrinsics = images.at(1.0), with_unit_baseline(images.rig.extrinsics)
    return Score(int(host.counts_one_by_one(whole, extrinsics[None], matcher)[0]), whole.pixels)
