"""Will depth be right? One look at the images through a calibration, without any search."""

import enum
from dataclasses import dataclass
from typing import Any

from stereorecal._arrays import refuse_tracers
from stereorecal._plain import plain
from stereorecal.geometry import StereoRig
from stereorecal.matching import AbstractMatcher
from stereorecal.recalibration._acceptance import FEWEST_PLACES, LEAST_COVERED, ROWS_APART, ROWS_MATTER, row_errors
from stereorecal.recalibration._agreement import LIKELY, without
from stereorecal.recalibration._as_dict import score_as_dict
from stereorecal.recalibration._consequences import Interval
from stereorecal.recalibration._look import look
from stereorecal.recalibration._mending import Mending, mending
from stereorecal.recordings import Pairs
from stereorecal.report.cells import change
from stereorecal.scoring import Legible, legible, pyramid
from stereorecal.scoring.host import Score, ranged, refuse_mixed_up

FALSE = 0.4  # pixels left by the mending: false matches lie evenly within a row of where they were sought, median 0.5
SIGNIFICANT = 3.0  # standard errors
DEPTH_MATTERS = 5.0  # percent at FAR
DEPTH_WRONG = 10.0  # percent at FAR: what a calibration that is called healthy may hide
FAR = 30  # baselines
HEALTH_LIMITS = {
    "covered": LEAST_COVERED,
    "covered_of_texture": LIKELY,
    "false_rows_px": FALSE,
    "significance": SIGNIFICANT,
    "repair_rows_px": ROWS_MATTER,
    "repair_depth_percent": DEPTH_MATTERS,
    "healthy_rows_px": ROWS_APART,
    "healthy_depth_percent": DEPTH_WRONG,
    "at_baselines": FAR,
}


class Condition(enum.Enum):
    """The verdict on a calibration; the value is the message."""

    HEALTHY = "healthy: rows are aligned and depth is right"
    REPAIR = "repair it"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Health:
    """How well the images fit together under a calibration, and what would mend it.

    Attributes:
        score: the count, in the rig's own view.
        row_error: epipolar (row) error, as `RowErrors.before` measures it, of the matches found under the calibration
            itself: the mean over tiles of a tile's median |row difference|, pixels at full size; NaN if hardly anything
            matches, since false matches lie on the rows that they were searched on.
        covered: share of the image in which correspondences were found that are good to a fraction of a pixel, of the
            frame that shows most. False matches count as pixels, but hardly here.
        shown: light and texture of the images, of the frame that shows most.
        mending: what would mend it; None if hardly anything matches.
        scale: pixels in which rows were measured, per pixel at full size; the limits of rows are in those.
        disagreeing: names of frames that show another rig than others, where they are too many to be left out.
    """

    score: Score
    row_error: float
    covered: float
    shown: Legible
    mending: Mending | None
    scale: float = 1.0
    disagreeing: tuple[str, ...] = ()

    @property
    def condition(self) -> Condition:
        """Repair, if hardly anything matches of images that show enough; or if a change is significant (3 standard
        errors) and matters: 0.1 pixels of row, or 5 % of depth at 30 baselines. Healthy, if no change that matters is
        in sight, and the 95 % intervals stay within 0.3 pixels and 10 %. Cannot tell, otherwise."""
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
    def significance(self) -> float:
        """Of the change that would mend it against none, in standard errors; NaN if it is not known."""
        return float("nan") if self.mending is None else self.mending.significance

    @property
    def _diagnosis(self) -> tuple[Condition, str]:
        if self.disagreeing:
            return Condition.CANNOT_TELL, f"the frames show different rigs ({', '.join(self.disagreeing)})"
        if self.mending is None:
            if self.shown.dark:
                return Condition.CANNOT_TELL, "the images are too dark"
            if not self.shown.enough:
                return Condition.CANNOT_TELL, "the images have too little texture"
            return Condition.REPAIR, "hardly anything matches, though the images have texture"
        rows, depth = self.mending.consequences.rows_px, self.mending.consequences.depth_percent[FAR]
        matters = rows.value * self.scale > ROWS_MATTER or abs(depth.value) > DEPTH_MATTERS
        if matters and self.significance > SIGNIFICANT:
            return Condition.REPAIR, f"{_listed(self.mending.named)} ({self.significance:.0f} standard errors)"
        if matters or rows.high * self.scale > ROWS_APART or depth.farthest > DEPTH_WRONG:
            return Condition.CANNOT_TELL, "the images do not determine it well enough; more frames may"
        if self.mending.row_error * self.scale > ROWS_APART:
            return Condition.CANNOT_TELL, "rows lie apart, and no rotation mends that; check lenses and shutters"
        return Condition.HEALTHY, ""

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON and tables; what is missing or infinite is None."""
        mended = self.mending
        return plain(
            {
                **score_as_dict(self.score),
                "row_error_px": self.row_error,
                "covered": self.covered,
                "brightness": self.shown.brightness,
                "texture": self.shown.texture,
                "healthy": self.healthy,
                "condition": self.condition.name.lower(),
                "verdict": self.verdict,
                "significance": self.significance,
                "disagreeing": self.disagreeing,
                "axes": mended and (mended.named if self.condition is Condition.REPAIR else ()),
                "mending": mended
                and {
                    "rotation_deg": {name: _ends(mended.axes[name]) for name in ("pitch", "yaw", "roll")},
                    "translation_percent": {name: _ends(mended.axes[name]) for name in ("y", "z")},
                    "row_error_px": mended.row_error,
                },
                "rows_apart_px": mended and _ends(mended.consequences.rows_px),
                "depth_error_percent": mended
                and {distance: _ends(error) for distance, error in mended.consequences.depth_percent.items()},
            }
        )

    def __str__(self) -> str:
        lines = [self.verdict, f"matched    {self.score}"]
        if self.mending is None:
            sure = f"matches that passed all checks cover {100 * self.covered:.0f} % of the image"
            return "\n".join([*lines, f"row error  not measured: {sure} (chance matches count as matched)"])
        by, found = self.mending.axes, self.mending.consequences
        angles = ", ".join(f"{name} {_about(by[name], 3)}" for name in ("pitch", "yaw", "roll"))
        shifts = ", ".join(f"{name} {_about(by[name], 2)}" for name in ("y", "z"))
        errors = "; ".join(f"{_range(error)} at {distance} B" for distance, error in found.depth_percent.items())
        return "\n".join(
            [
                *lines,
                f"row error  {self.row_error:.2f} px; {self.mending.row_error:.2f} px if mended",
                f"to mend    {angles} deg; {shifts} % of the baseline",
                f"rows       {found.rows_px.value:.2f} px by the calibration, at most {found.rows_px.high:.2f} px",
                f"depth      {errors}",
            ]
        )


def health(rig: StereoRig, pairs: Pairs, *, matcher: AbstractMatcher | str | None = None) -> Health:
    """Match the pairs under the rig's calibration and solve once for what would mend it.

    Args:
        matcher: a matcher, or "sad" (default), "bm" or "sgbm"; without `num_disparities` the range is measured.

    Raises:
        InputError: if images and calibration do not fit, or the images are no left and right image of this rig.
    """
    refuse_tracers("sr.health", "sr.correspondences and sr.row_differences", rig)
    images = pyramid(rig, pairs)
    seen, shown = (
        look(images, ranged(matcher, images)),
        max((legible(pair) for pair in images.pairs), key=lambda one: one.texture),
    )
    frames, scale = seen.frames, float(seen.found.scale)
    covered = seen.found.covered if frames is None else without(seen.found, frames.apart).covered
    if frames is not None and frames.refused:
        names = tuple(images.pairs[f].name for f in frames.apart)
        return Health(seen.score, float("nan"), covered, shown, None, scale, names)
    facts = None if frames is None else frames.facts
    rows = None if facts is None or facts.places < FEWEST_PLACES or covered < LEAST_COVERED else row_errors(facts)
    if facts is None or rows is None or (covered < LIKELY * shown.texture and rows.after * scale > FALSE):
        refuse_mixed_up(images)
        return Health(seen.score, float("nan"), covered, shown, None, scale)
    return Health(seen.score, rows.before, covered, shown, mending(rig, seen.chart, facts, rows.after), scale)


def _listed(names: tuple[str, ...]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _ends(found: Interval) -> dict[str, float]:
    return {"value": found.value, "low": found.low, "high": found.high}


def _about(found: Interval, digits: int) -> str:
    return f"{found.value:+z.{digits}f} ± {found.high - found.value:.{digits}f}"


def _range(error: Interval) -> str:
    return f"{change(error.value, 'far')} ({change(error.low, 'far')} to {change(error.high, 'far')})"
