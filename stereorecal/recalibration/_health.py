"""Will depth be right? One look at the images through a calibration, without any search."""

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from stereorecal._arrays import refuse_tracers
from stereorecal._json_data import json_data
from stereorecal._renamed import renamed_attributes
from stereorecal.decision import LIMITS, Verdict
from stereorecal.estimation import check_prior, rig_parameters
from stereorecal.geometry import StereoRig, View, with_unit_baseline
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._acceptance import FALSE, LEAST_COVERED, Reason, loses_regions, row_errors
from stereorecal.recalibration._as_dict import score_as_dict
from stereorecal.recalibration._calibration_warnings import doubts
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._correction import Correction, correction_of
from stereorecal.recalibration._ending import counts
from stereorecal.recalibration._estimate_and_decide import Answer, rows_of
from stereorecal.recalibration._expected import depth_error_intervals
from stereorecal.recalibration._health_text import health_text
from stereorecal.recalibration._initial_assessment import assess_initial_rig
from stereorecal.recalibration._motion_windows import check_motion, following
from stereorecal.recalibration._prior_use import prior_for_health
from stereorecal.recalibration._settings import HealthOptions, as_settings
from stereorecal.recalibration._unmatched import LIKELY, is_sparse
from stereorecal.recordings import Pairs
from stereorecal.scoring import ImageQuality, Pyramid, host, image_quality, pyramid
from stereorecal.scoring.host import Score, refuse_swapped_images, with_measured_range

HEALTH_LIMITS = {"covered": LEAST_COVERED, "covered_of_texture": LIKELY, "false_rows_px": FALSE, **LIMITS}


class Condition(enum.Enum):
    """The verdict on a calibration; the value is the message."""

    HEALTHY = "healthy: the rows are aligned, and there is no significant improvement"
    REPAIR = "repair it"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Health:
    """How well the images fit together under a calibration, and the correction that they ask for.

    Attributes:
        score: the count, in the view that was looked through.
        row_error: epipolar (row) error, as `RowErrors.before` measures it, of the matches found under the calibration
            itself: the mean over tiles of a tile's median |row difference|, pixels at full size; NaN if hardly anything
            matches, since false matches lie on the rows that they were searched on.
        covered: share of the image in which correspondences were found that are good to a fraction of a pixel, of the
            frame that shows most. False matches count as pixels, but hardly here.
        shown: light and texture of the images, of the frame that shows most.
        correction: of the extrinsics, that the images ask for; None if hardly anything matches.
        disagreeing: names of frames that show another rig than others, where they are too many to be left out.
        doubts: sentences on values of the calibration that hardly any rig has.
        loses: the correction would lose whole regions that match now.
        view: that was looked through.
    """

    score: Score
    row_error: float
    covered: float
    shown: ImageQuality
    correction: Correction | None
    disagreeing: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    loses: bool = False
    view: View | None = None

    if not TYPE_CHECKING:
        __getattr__ = renamed_attributes({"mending": "correction"})

    @property
    def condition(self) -> Condition:
        """Repair, if hardly anything matches of images that show enough; or if a change of the extrinsics is better for
        sure, and hardly ever worse. Healthy, if none is, and rows lie within 0.3 pixels, with 95 %. Cannot tell,
        otherwise."""
        return self._diagnosis[0]

    @property
    def healthy(self) -> bool:
        """True if the condition is."""
        return self.condition is Condition.HEALTHY

    @property
    def verdict(self) -> str:
        """The condition, and why, in one sentence."""
        condition, why = self._diagnosis
        return f"{condition.value}: {why}" if why else condition.value

    @property
    def _diagnosis(self) -> tuple[Condition, str]:
        if self.disagreeing:
            return Condition.CANNOT_TELL, f"the frames show different rigs ({', '.join(self.disagreeing)})"
        if self.correction is None:
            if self.shown.dark:
                return Condition.CANNOT_TELL, "the images are too dark"
            if self.shown.noise:
                return Condition.CANNOT_TELL, "an image shows nothing but noise; uncover the lens, or give light"
            if not self.shown.textured:
                return Condition.CANNOT_TELL, "the images have too little texture"
            if self.shown.coarse:
                return Condition.CANNOT_TELL, "an image has only a few grey levels; expose longer, or give more bits"
            if self.doubts:
                return Condition.CANNOT_TELL, f"almost nothing matches; {self.doubts[0]}"
            return Condition.REPAIR, "almost nothing matches, though the images have texture"
        decision = self.correction.decision
        if self.doubts and decision.verdict is not Verdict.GOOD:
            return Condition.CANNOT_TELL, self.doubts[0]
        if decision.verdict is Verdict.REPAIR and self.loses:
            return Condition.CANNOT_TELL, Reason.FEWER_MATCHES.value
        if decision.verdict is Verdict.REPAIR:
            depth_note = "; depth stays as it was calibrated" if decision.keeps_depth else ""
            return Condition.REPAIR, f"{_listed(self.correction.main_axes)}{depth_note}"
        if decision.verdict is Verdict.GOOD and is_sparse(self.covered, self.shown.texture):
            return (
                Condition.CANNOT_TELL,
                "only a small part of the texture matches, perhaps by chance; recalibrate, or give other scenes",
            )
        if decision.verdict is Verdict.GOOD:
            return Condition.HEALTHY, ""
        if not decision.explains:
            return (
                Condition.CANNOT_TELL,
                "no change of the extrinsics explains what matches through this calibration; recalibrate matches "
                "again through better ones, and four scenes or more would help",
            )
        return Condition.CANNOT_TELL, "the images do not determine what is better; other scenes, or more frames, may"

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
                "verdict": self.verdict,
                "probability_worse": correction and correction.decision.worse,
                "probability_better": correction and correction.decision.better,
                "view": self.view and self.view.as_dict(),
                "disagreeing": self.disagreeing,
                "doubts": self.doubts,
                "axes": correction and (correction.main_axes if self.condition is Condition.REPAIR else ()),
                "correction": correction
                and {
                    "rotation_deg": {name: correction.axes[name].as_dict() for name in ("pitch", "yaw", "roll")},
                    "translation_percent": {name: correction.axes[name].as_dict() for name in ("y", "z")},
                    "row_error_px": correction.row_error,
                },
                "rows_apart_px": correction and correction.rows_px.as_dict(),
                "depth_error_percent": correction
                and {distance: error.as_dict() for distance, error in correction.depth_percent.items()},
            }
        )

    def __str__(self) -> str:
        return health_text(
            self.verdict, self.doubts, self.score, self.view, self.covered, self.row_error, self.correction
        )


def health(rig: StereoRig, pairs: Pairs, **options: Unpack[HealthOptions]) -> Health:
    """Match the pairs under the rig's calibration, and estimate once the correction that they ask for.

    `recalibrate` begins with the same look: what is healthy here stays there, what is to be repaired here is repaired.

    Args:
        options: those of `HealthOptions`, by name: `matcher, view, prior, motion, tolerances`. Pairs that a saved prior
            rests on count, for nothing is learnt here.

    Raises:
        InputError: if images and calibration do not fit, the images are no left and right image of this rig, the
            prior makes no sense, or nothing can have moved.
        TypeError: if there is no option of a name.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    settings = as_settings(options, HealthOptions.__optional_keys__)
    images, doubtful = pyramid(rig, pairs, settings.view), doubts(rig)
    check_prior(settings.prior, rig_parameters(rig))
    prior = prior_for_health(settings.prior, rig)
    check_motion(settings.motion, len(images.pairs), prior)
    windows = following(images.pairs, range(len(images.pairs)), settings.motion, prior)
    matcher, limits = with_measured_range(settings.matcher, images), settings.tolerances
    case = Case(images, matcher, settings.reach, settings.free, prior, windows=windows, tolerances=limits)
    initial = assess_initial_rig(case, settings.schedule.stages[-1])
    score = _score(images, case.matcher)
    quality = max((image_quality(pair) for pair in images.pairs), key=lambda one: one.texture)
    answer = initial.answer if initial is not None else None

    def unmeasured(covered: float, disagreeing: tuple[str, ...] = ()) -> Health:
        return Health(score, float("nan"), covered, quality, None, disagreeing, doubtful, view=images.view)

    if answer is None:
        refuse_swapped_images(images)
        return unmeasured(0.0 if initial is None else initial.covered)
    covered = answer.found.covered
    if answer.frames_disagree:
        refuse_swapped_images(images, answer.excluded)
        names = tuple(images.pairs[f].name for f in answer.excluded)
        return unmeasured(covered, names)
    estimated, rows = answer.estimate, row_errors(rows_of(case, answer))
    if not answer.enough or (answer.sparse and rows.after > FALSE):  # rows as far apart as those of chance matches
        refuse_swapped_images(images)
        return unmeasured(covered)
    depth = depth_error_intervals(estimated, np.zeros(len(estimated.names)))
    correction = correction_of(estimated, answer.decision, depth, rows.after)
    loses = not answer.decision.refused and _loses_regions(case, answer)
    return Health(score, rows.before, covered, quality, correction, (), doubtful, loses, images.view)


def _loses_regions(case: Case, answer: Answer) -> bool:
    tiles = counts(case, answer.estimate.chart.rig_at(answer.decision.theta))
    return loses_regions(np.delete(tiles, answer.excluded, axis=1))


def _score(images: Pyramid, matcher: AbstractMatcher) -> Score:
    whole, extrinsics = images.at(1.0), with_unit_baseline(images.rig.extrinsics)
    return Score(int(host.counts_one_by_one(whole, extrinsics[None], matcher)[0]), whole.pixels)


def _listed(names: tuple[str, ...]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
