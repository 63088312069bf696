"""A repaired recording, as others that share parameters with it see it."""

from dataclasses import dataclass

from stereorecal.decision import ENOUGH, Reason
from stereorecal.estimation import NO_WINDOWS, Windows
from stereorecal.geometry import StereoRig
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._worker_tasks import MatchTask
from stereorecal.recordings import Pair, Range
from stereorecal.scoring import Correspondences

_UNUSABLE = (Reason.OUT_OF_BUDGET, Reason.TOO_LITTLE_TEXTURE, Reason.NO_MATCHES)


@dataclass(frozen=True, eq=False)
class RepairedRecording:
    """Pairs, the repair of their rig's extrinsics with the intrinsics as they were, and ranges of what they show; the
    frames that the repair left out take no part.
    """

    pairs: tuple[Pair, ...]
    repair: Solution
    ranges: tuple[Range, ...] = ()

    @property
    def found(self) -> Correspondences:
        """The last correspondences of the repair.

        Raises:
            ValueError: if it is not usable.
        """
        if self.repair.found is None:
            raise ValueError("a recording without correspondences has no part in a joint solution")
        return self.repair.found

    @property
    def kept(self) -> tuple[Pair, ...]:
        """The pairs that it rests on."""
        return tuple(self.pairs[index] for index in self.repair.used)

    @property
    def windows(self) -> Windows:
        """Of the kept pairs that follow each other, numbered as these."""
        estimate = self.repair.estimate
        return NO_WINDOWS if estimate is None else estimate.windows.numbered(self.repair.used)

    def usable(self, *, intrinsics_free: bool) -> bool:
        """Whether it can take part. Frames may disagree by intrinsics that are free; that is judged at the end."""
        found, reason = self.repair.found, self.repair.reason
        if reason in _UNUSABLE or (reason is Reason.FRAMES_DISAGREE and not intrinsics_free):
            return False
        return found is not None and found.found >= ENOUGH.matches

    def task(self, *rigs: StereoRig, ranges: bool = False) -> MatchTask:
        """To look at the kept pairs through rigs, as the repair looked at them."""
        repair, own = self.repair, self.ranges if ranges else ()
        return MatchTask(rigs, self.kept, repair.view, repair.matcher, repair.stages[-1].scale, own)
