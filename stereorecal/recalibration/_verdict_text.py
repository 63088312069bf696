"""The first two lines of what is said: a verdict, and what to do."""

from stereorecal.decision import Decision, Reason

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def verdict_of(reason: Reason, decision: Decision | None, pairs: int, *, repaired: bool) -> str:
    """The verdict, in at most twelve words.

    Args:
        decision: None if nothing was decided.
        pairs: that were looked at.
        repaired: by a repair, not a look.
    """
    begins = "Repaired" if repaired else "Repair it"
    if decision is None or reason is Reason.MORE_MATCHES:
        begins = begins if reason.accepted else "Cannot tell" if reason.undetermined else "Not repaired"
        return f"{begins}: {reason.value}."
    before, after = decision.rows_px
    if reason is Reason.IMPROVED:
        share = decision.depth_corrected
        depth = "corrected" if share == 1.0 else "corrected in part" if share else "kept as calibrated"
        return f"{begins}: row error {before[0]:.2f} -> {after[0]:.2f} px; depth {depth}."
    if reason is Reason.ALREADY_GOOD:
        return f"Good. Row error {before[0]:.2f} px where the images show something."
    if reason is Reason.CANNOT_TELL:
        number = _NUMBERS[pairs] if pairs < len(_NUMBERS) else str(pairs)
        which = f"from {number} pair{'' if pairs == 1 else 's'}"
        return f"Cannot tell {which}: row error {before[1]:.2f} to {before[2]:.2f} px."
    return f"{'Not repaired' if repaired and not reason.undetermined else 'Cannot tell'}: {reason.value}."


def advice_of(reason: Reason, *, intrinsics_change: bool = False) -> str:
    """What to do."""
    note = " The intrinsics change too; to keep them, free the extrinsics alone (--free extrinsics)."
    return reason.advice + (note if intrinsics_change else "")
