"""The first two lines of what is said of a repair, or of a look: the verdict, and what to do."""

from collections.abc import Sequence

from stereorecal.decision import Criterion, Decision, Reason
from stereorecal.recalibration._depth_errors import DepthError
from stereorecal.recalibration._mismatch import Mismatch

_NOT_CORRECTED = {
    Criterion.GAINS: "what a correction would gain is too little",
    Criterion.HARMLESS: "a correction may make it worse",
    Criterion.PREDICTS: "parts of the images that were left out do not confirm a correction",
    None: "its correction does not pass all checks",
}
_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def verdict_of(
    reason: Reason,
    decision: Decision | None,
    pairs: int,
    mismatch: Mismatch | None,
    problem: str | None,
    depth_off: bool,
    *,
    repaired: bool,
) -> str:
    """The verdict, in at most twelve words.

    Args:
        decision: None if nothing was decided.
        pairs: that were looked at.
        mismatch: why these cannot be images of this rig, or None.
        problem: why images of too little texture match elsewhere than their scene does, or None.
        depth_off: whether depth was significantly wrong, at a distance that is reported.
        repaired: by a repair, not a look.
    """
    begins = "Repaired" if repaired else "Repair it"
    if mismatch is not None:
        return mismatch.verdict
    if reason is Reason.TOO_LITTLE_TEXTURE and problem is not None:
        return f"Cannot tell: {problem}."
    if decision is None or reason is Reason.MORE_MATCHES:
        begins = begins if reason.accepted else "Cannot tell" if reason.undetermined else "Not repaired"
        return f"{begins}: {reason.value}."
    before, after = decision.rows_px
    if reason is Reason.IMPROVED:
        share = decision.depth_corrected
        corrected = "corrected" if share == 1.0 else "corrected in part"
        depth = "kept as calibrated" if not share else corrected if depth_off else "not measurably off"
        return f"{begins}: epipolar error {before[0]:.2f} -> {after[0]:.2f} px; depth {depth}."
    if reason is Reason.ALREADY_GOOD:
        return f"Good. Epipolar error {before[0]:.2f} px where the images show something."
    if reason is Reason.CANNOT_TELL:
        number = _NUMBERS[pairs] if pairs < len(_NUMBERS) else str(pairs)
        which = f"from {number} pair{'' if pairs == 1 else 's'}"
        return f"Cannot tell {which}: epipolar error {before[1]:.2f} to {before[2]:.2f} px."
    return f"{'Not repaired' if repaired and not reason.undetermined else 'Cannot tell'}: {reason.value}."


def advice_of(reason: Reason, decision: Decision | None, mismatch: Mismatch | None, depth: Sequence[DepthError]) -> str:
    """What to do. Rows make a calibration good; where its depth is off all the same, that is said, and why it stays.

    Args:
        decision, mismatch: as above.
        depth: the errors of depth that are reported, of the initial calibration.
    """
    if mismatch is not None:
        return mismatch.advice
    off = [f"{error} at {error.where}" for error in depth if error.significant]
    if reason is not Reason.ALREADY_GOOD or decision is None or not off:
        return reason.advice
    return f"But depth is {' and '.join(off)}, and {_NOT_CORRECTED[decision.failed]}; pairs of other places may decide."
