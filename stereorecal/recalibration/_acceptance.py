"""The verdict: is the candidate better on data that it has not seen?"""

import enum
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from stereorecal.recalibration._evidence import Evidence
from stereorecal.recalibration._misfit import Misfit

_COUNT_LOSS = 0.01  # of the count, which is flat to half of that around the optimum (measured on real scenes)
_COUNT_GAIN = 0.01  # likewise
_ROW_LOSS = 0.02  # pixels: what a repair that ends well may lose by noise
_ROW_GAIN = 0.01  # pixels: less than that no matcher notices
_SIGNIFICANT = 3.0  # standard errors, over the places of tiles
FEWEST_PLACES = 6  # of tiles: a covariance of five parameters from fewer says nothing
_EDGE = 0.98  # of the box of the epipolar stages, which is twice the reach
# Chance of a drift as far or farther, over all axes together: six standard deviations of five numbers. One by 2.5
# degrees and 2.5 % on every axis, which users may have, is five and a half.
_PLAUSIBLE = 1e-6
_MOST_MISFIT = 0.4  # pixels, in the worst tenth of the regions; intrinsics of real rigs leave 0.12 to 0.35
_SOME_MISFIT = 0.2  # pixels, likewise: as much must be small beside the gain
_BESIDE_GAIN = 0.5  # of the row differences before
MOST_WORSE = 0.1  # share of the regions
WORSE = 0.05  # pixels by which a region is worse, beyond two standard errors
_MOST_LOST = 0.2  # share of the tiles
# Of the row differences before: what one more effect may take of the solution. Where intrinsics fit it takes up to 0.04
# of a drift; where they do not, and the drift is small, up to 0.25. A shutter that poses as a drift makes an unusual
# one, which moves the rows less than most drifts would.
_SWAY = 0.05
_MOST_SWAY = 0.25
# What poses as a drift moves y or z, by 0.74 of its prior's standard deviation and more in all harmful repairs that
# nothing but sway gave away: where both stay, the drift is a rotation, which rows tell for sure.
_STAYS = 0.5
_SWAY_OF_ROTATIONS = 0.5
_UNUSUAL = 0.05  # share of drifts in random directions that would move the rows as little
_STRANGE = 0.0002  # share of drifts in random directions that would move the rows as little
LEAST_COVERED = 0.1  # of the image; good rigs cover a half, rigs half a degree out 0 to 6 %: what false matches cover
ROWS_APART = 0.3  # pixels; 0.03 degrees of pitch at a focal length of 600 pixels: no good calibration leaves that
ROWS_MATTER = 0.1  # pixels: what a matcher notices


class Reason(enum.Enum):
    """Why a candidate was accepted or not; the value is the message."""

    IMPROVED = "the candidate is better, and that is sure"
    MORE_MATCHES = "the candidate matches more pixels"
    RANGES = "the candidate agrees with the ranges, which the initial calibration does not, and its rows are as good"
    ALREADY_GOOD = "the initial calibration is already good; there is nothing to gain that is sure"
    NOT_IMPROVED = "no candidate matches more pixels than the initial calibration"
    FEWER_MATCHES = "the candidate matches fewer pixels than the initial calibration"
    WORSE_ON_HELD_OUT = "the candidate is no better on image regions that were held out"
    TOO_LITTLE_TEXTURE = "too little of the images matches: too little light or texture"
    NO_MATCHES = "hardly anything matches, though the images have texture: a drift beyond the reach, or another rig"
    OUT_OF_BUDGET = "the budget ended before the row error of a candidate could be judged; give a larger one"
    MISFIT = "the candidate leaves rows of whole regions apart, which no rotation or shift of the cameras explains"
    FRAMES_DISAGREE = "the frames show different rigs; take them at rest, or check the synchronisation of the cameras"
    CANNOT_TELL = (
        "the images do not tell for sure what is better; other scenes, frames that move, or ranges would tell more"
    )
    IMPLAUSIBLE = "the candidate is an unlikely drift: too far on all axes together, or far where rows hardly tell"
    REACH_EDGE = (
        "the search ended at twice the reach: the drift is larger, so give a larger reach, or something moved between "
        "the two exposures"
    )

    @property
    def accepted(self) -> bool:
        """True if the candidate replaces the initial calibration."""
        return self in (Reason.IMPROVED, Reason.MORE_MATCHES, Reason.RANGES)

    @property
    def healthy(self) -> bool:
        """True if the calibration to use is good: repaired, or good from the start."""
        return self.accepted or self is Reason.ALREADY_GOOD


@dataclass(frozen=True, eq=False)
class RowErrors:
    """|Row difference| of the correspondences, pixels at full size: the mean over the tiles of a tile's median.

    Attributes:
        before: under the initial calibration.
        after: under the candidate; with exact intrinsics, each part of the images judged by a solution that has not
            seen it.
        significance: of the gain, in standard errors over the places of tiles in the frames.
    """

    before: float
    after: float
    significance: float


def row_errors(found: Evidence) -> RowErrors:
    """The paired comparison of tiles that no solution has seen; frames that repeat each other prove nothing twice."""
    return compared(found, *found.held_out())


def compared(found: Evidence, before: Float[np.ndarray, "t"], after: Float[np.ndarray, "t"]) -> RowErrors:
    """The comparison of what each tile of the evidence shows, before and after."""
    gain = found.by_place(before - after)
    error = float(np.std(gain, ddof=1)) / np.sqrt(len(gain)) if len(gain) > 1 else np.inf
    return RowErrors(float(np.mean(before)), float(np.mean(after)), float(np.mean(gain)) / max(error, 1e-9))


def verdict_on_count(before: int, after: int, *, signal: bool) -> Reason:
    """Where the count is all there is: more is better."""
    if not signal:
        return Reason.TOO_LITTLE_TEXTURE
    return Reason.MORE_MATCHES if after > before else Reason.NOT_IMPROVED


def misfits(left: Misfit, scale: float, shift: float) -> bool:
    """Whether a repair leaves, or rests on, what the parameters cannot explain: regions are worse than before or match
    no longer, the misfit is large, or large beside the gain, or an effect that is in no model would explain much of the
    gain as well.

    No fixed number of pixels tells: good repairs of real rigs, whose intrinsics are imperfect, leave as much as some
    harmful ones.

    Args:
        scale: pixels in which rows were measured, per pixel at full size.
        shift: by how much the candidate moves y or z, in standard deviations of their priors.
    """
    sway = _SWAY if left.chance < _UNUSUAL else _MOST_SWAY
    if shift < _STAYS:
        sway = _SWAY_OF_ROTATIONS
    return bool(
        left.high * scale > _MOST_MISFIT
        or (left.high * scale > _SOME_MISFIT and left.rms > _BESIDE_GAIN * left.rms_before)
        or regions_worse(left, scale)
        or left.sway > sway * left.rms_before
    )


def regions_worse(left: Misfit, scale: float) -> bool:
    """Whether regions lie farther apart than before, or match no longer."""
    worse = np.abs(left.after) - np.abs(left.before) > WORSE / scale + 2.0 * left.error
    return bool((worse.size and np.mean(worse) > MOST_WORSE) or left.lost > _MOST_LOST)


@dataclass(frozen=True)
class Verdict:
    """What is said of a candidate.

    Attributes:
        reason: as users read it.
        doubt: why a candidate that gains is refused all the same, where the calibration before it is good and the
            reason is that; else None. What has no gain may be replaced by something that fits more than rows; what is
            doubted may not.
    """

    reason: Reason
    doubt: Reason | None = None

    @property
    def why(self) -> Reason:
        """The reason why it is refused, if it is."""
        return self.doubt or self.reason


def chance_of_farther(deviations: Float[np.ndarray, "n"]) -> float:
    """Of as many numbers, normal with unit variance, that lie together as far from zero or farther."""
    from scipy.special import chdtrc  # a third of a second to import

    return float(chdtrc(deviations.size, float(deviations @ deviations)))


def implausible(z: Float[np.ndarray, "n"], prior: float) -> bool:
    """Whether a point of the box lies too far from its centre, on all axes together."""
    return chance_of_farther(z / prior) < _PLAUSIBLE


def at_the_edge(z: Float[np.ndarray, "n"]) -> bool:
    """Whether a point lies at the edge of the box of the epipolar stages."""
    return bool(np.any(np.abs(z) > _EDGE))


def behind(before: int, after: int, rows_before: float, rows_after: float) -> bool:
    """Whether a calibration loses against another that is there already: in matches, or in rows by pixels at which they
    were measured."""
    return after < (1.0 - _COUNT_LOSS) * before or rows_after - rows_before > _ROW_LOSS


def verdict(
    counts: Int[np.ndarray, "2"], rows: RowErrors, facts: Evidence, left: Misfit, covered: float, shift: float
) -> Verdict:
    """The verdict on a candidate with correspondences.

    Accepted: a significant gain in count or in row error on held-out regions, no loss beyond 1 % of the count and
    0.02 pixels, plausible under the prior as a whole, and no misfit (`misfits`). The counts of equally good
    calibrations scatter: by about 1 over the root of the count of a frame, measured on rendered scenes; frames that
    repeat each other prove nothing twice. Pixels are those of the images in which rows were measured.

    Where rows were aligned before, what is left to mend of a good calibration lies along axes that rows hardly see, as
    what poses as a drift does: such a calibration stays, as good. So it does where the candidate is the worse one.

    Args:
        counts: of all frames, under the initial calibration and the candidate.
        facts: the evidence of all parameters whose prior says how far they may be, at the candidate.
        left: the misfit of the candidate.
        covered: by correspondences, share of the frame that shows most.
        shift: as `misfits` has it.
    """
    before, after = counts
    if facts.places < FEWEST_PLACES or covered < LEAST_COVERED:
        return Verdict(Reason.TOO_LITTLE_TEXTURE)
    aligned = rows.before * facts.scale <= ROWS_APART
    if after < (1.0 - _COUNT_LOSS) * before:
        return _refused(Reason.FEWER_MATCHES, aligned)
    gain = (rows.before - rows.after) * facts.scale
    if gain < -_ROW_LOSS:
        return _refused(Reason.WORSE_ON_HELD_OUT, aligned)
    if at_the_edge(facts.z):
        return Verdict(Reason.REACH_EDGE)
    better_rows = gain > _ROW_GAIN and rows.significance > _SIGNIFICANT
    scatter = 1.0 / np.sqrt(max(after / facts.frames, 1.0))
    better_count = after > (1.0 + max(_COUNT_GAIN, _SIGNIFICANT * scatter)) * before and gain >= 0.0
    if not (better_rows or better_count):
        return Verdict(Reason.ALREADY_GOOD if aligned else Reason.WORSE_ON_HELD_OUT)
    if implausible(facts.z, facts.prior) or left.chance < _STRANGE:
        return _refused(Reason.IMPLAUSIBLE, aligned)
    if misfits(left, facts.scale, shift):
        return _refused(Reason.MISFIT, aligned)
    return Verdict(Reason.IMPROVED)


def _refused(doubt: Reason, aligned: bool) -> Verdict:
    """A calibration whose rows are aligned stays as good, whatever speaks against the candidate."""
    return Verdict(Reason.ALREADY_GOOD, doubt) if aligned else Verdict(doubt)
