"""One ordered list of checks: what vetoes a repair or a good verdict, and what explains that neither is given."""

import enum
from collections.abc import Callable
from dataclasses import dataclass

from stereorecal.decision._rule import Criterion, Decision, Verdict
from stereorecal.decision._tolerances import ENOUGH


class Reason(enum.Enum):
    """Why a calibration is replaced, or stays; the value says it."""

    IMPROVED = "another calibration is a significant improvement"
    MORE_MATCHES = "another calibration matches more pixels"
    ALREADY_GOOD = "the rows are aligned where the images show something"
    NOT_IMPROVED = "no calibration matches more pixels"
    OUT_OF_BUDGET = "the budget ended before a candidate could be judged"
    TOO_LITTLE_TEXTURE = "the images have too little light, texture or grey levels"
    NO_MATCHES = "almost nothing matches, though the images have texture"
    FRAMES_DISAGREE = "the images show different rigs"
    REACH_EDGE = "the rig moved farther than was searched"
    FEWER_MATCHES = "whole regions would no longer match"
    LATE_SHUTTER = "one of the two shutters is late"
    OTHER_LENSES = "the lenses differ more from their calibration than calibrations err"
    MISFIT = "parts of the images contradict each other"
    CANNOT_TELL = "these images do not determine what is better"

    @property
    def advice(self) -> str:
        """What to do."""
        return "Use the new calibration (solution.rig, --output FILE)." if self.accepted else _ADVICE[self]

    @property
    def accepted(self) -> bool:
        """True if the candidate replaces the initial calibration."""
        return self in (Reason.IMPROVED, Reason.MORE_MATCHES)

    @property
    def healthy(self) -> bool:
        """True if the calibration to use is good: repaired, or good from the start."""
        return self.accepted or self is Reason.ALREADY_GOOD

    @property
    def undetermined(self) -> bool:
        """True if it cannot be told whether the calibration is good, whatever the candidate is."""
        return self in (*_UNSURE, Reason.CANNOT_TELL)


_UNSURE = (Reason.TOO_LITTLE_TEXTURE, Reason.FRAMES_DISAGREE, Reason.LATE_SHUTTER, Reason.OTHER_LENSES, Reason.MISFIT)
_ADVICE = {
    Reason.ALREADY_GOOD: "Nothing to do.",
    Reason.NOT_IMPROVED: "Use the default schedule, which judges by epipolar error.",
    Reason.OUT_OF_BUDGET: "Give a larger budget.",
    Reason.TOO_LITTLE_TEXTURE: "Take a pair with more light and texture; of interlaced images take every second row.",
    Reason.NO_MATCHES: "Give a larger reach, or images that show more.",
    Reason.FRAMES_DISAGREE: "Give one pair, if the rig moved; else take them at rest, or check the synchronisation.",
    Reason.REACH_EDGE: "Give a larger reach, or another pair, if something moved between the exposures.",
    Reason.FEWER_MATCHES: "Take another pair; something moved between the exposures, or a lens does not fit its model.",
    Reason.LATE_SHUTTER: "Trigger both cameras at once, or take frames at rest.",
    Reason.OTHER_LENSES: "Check that calibration and images belong together: as taken, or rectified, both.",
    Reason.MISFIT: "Take one more pair of another place; something moved, or a lens does not fit its model.",
    Reason.CANNOT_TELL: "Take one more pair of another place; frames in motion, or ranges, determine depth as well.",
}


def is_sparse(covered: float, texture: float) -> bool:
    """Whether matches cover less of an image than under an aligned rig, of what has texture; both are shares of the
    image. So many may be there by chance."""
    return covered < ENOUGH.of_texture * texture


@dataclass(frozen=True)
class Seen:
    """What images show of a rig besides.

    Attributes:
        matches: correspondences.
        covered: share of the image that they cover, of the frame that shows most.
        places: tiles of a frame that show something.
        texture: share of the image that has texture, likewise.
        enough: whether light and texture are enough for an aligned rig to match.
        problem: why all images match elsewhere than their scene does.
        by_chance: with the rows off about as much matches.
        wrong_input: the images cannot be of this rig.
        frames_disagree: too many frames show another rig than the others.
        late: one of the two shutters is, more probably than not.
        misfit_px: systematic errors that are in no parameter.
        lens_change: the largest one of a focal length or k1, in standard deviations of the worst calibrations.
        lost: of what the candidate matches, what it loses where the initial calibration matches, as a share.
        away: of the candidate, in reaches.
        cut: the budget ended before matches could be found.
    """

    matches: int = 0
    covered: float = 0.0
    places: int = 0
    texture: float = 0.0
    enough: bool = True
    problem: str | None = None
    by_chance: bool = False
    wrong_input: bool = False
    frames_disagree: bool = False
    late: bool = False
    misfit_px: float = 0.0
    lens_change: float = 0.0
    lost: float = 0.0
    away: float = 0.0
    cut: bool = False

    @property
    def few(self) -> bool:
        """Too little matches for any verdict: in few places, or hardly any but by chance."""
        by_chance = self.by_chance and self.covered < ENOUGH.covered
        return self.matches < ENOUGH.matches or self.places < ENOUGH.places or by_chance


@dataclass(frozen=True)
class Check:
    """One of the checks.

    Attributes:
        reason: what is said if it holds.
        holds: whether it does.
        vetoes: a repair.
        doubts: a good verdict.
    """

    reason: Reason
    holds: Callable[[Seen], bool]
    vetoes: bool = True
    doubts: bool = True


CHECKS = (
    Check(Reason.OUT_OF_BUDGET, lambda seen: seen.cut),
    Check(Reason.TOO_LITTLE_TEXTURE, lambda seen: seen.problem is not None or (seen.few and not seen.enough)),
    Check(Reason.NO_MATCHES, lambda seen: seen.few or seen.wrong_input),
    Check(Reason.FRAMES_DISAGREE, lambda seen: seen.frames_disagree),
    Check(Reason.CANNOT_TELL, lambda seen: seen.by_chance),
    Check(Reason.LATE_SHUTTER, lambda seen: seen.late, vetoes=False, doubts=False),
    Check(Reason.REACH_EDGE, lambda seen: not seen.away <= ENOUGH.reach, doubts=False),
    Check(Reason.FEWER_MATCHES, lambda seen: not seen.lost <= ENOUGH.lost, doubts=False),
    Check(Reason.OTHER_LENSES, lambda seen: not seen.lens_change <= ENOUGH.lens_change, doubts=False),
    Check(Reason.MISFIT, lambda seen: not seen.misfit_px < ENOUGH.misfit_px, doubts=False),
)


def reason_of(decision: Decision | None, seen: Seen) -> Reason:
    """The first check that holds, where one vetoes or doubts the verdict, or there is none; else the verdict's own.
    None: too few matches for any decision."""
    held = [check for check in CHECKS if check.holds(seen)]
    if decision is None or decision.verdict is Verdict.CANNOT_TELL:
        own = Reason.MISFIT if decision and decision.failed is Criterion.PREDICTS else Reason.CANNOT_TELL
        return held[0].reason if held else own
    if decision.verdict is Verdict.REPAIR:
        return held[0].reason if any(check.vetoes for check in held) else Reason.IMPROVED
    return held[0].reason if any(check.doubts for check in held) else Reason.ALREADY_GOOD
