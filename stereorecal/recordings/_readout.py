"""Rolling shutters: how much of the time between two pairs it takes them to read an image."""

from stereorecal._errors import InputError
from stereorecal.recordings._pair import Pair


def share_of(first: Pair, second: Pair) -> float:
    """The readout as a share of the time between two pairs; 0 where all rows are taken at once.

    Raises:
        InputError: if that time is not known, or not longer than the readout.
    """
    readout = max(first.readout, second.readout)
    if not readout:
        return 0.0
    if first.time is None or second.time is None or second.time - first.time < readout:
        raise InputError(
            f"{first.name} and {second.name}: rolling shutters read an image in {readout:g} s, and the pairs do not "
            "know times that are at least as far apart; give times, leave the readout (readout_s) out, or say "
            "motion=False (--motion off)."
        )
    return readout / (second.time - first.time)
