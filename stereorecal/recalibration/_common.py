"""The common estimate of recordings of one rig, and the rigs that it gives them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.estimation import (
    NO_BEAMS,
    Beams,
    Estimate,
    Prior,
    Recording as Shown,
    estimate_together,
    rig_parameters,
    with_free_together,
)
from stereorecal.geometry import StereoRig
from stereorecal.objectives import Parameters, read_by, row_chart
from stereorecal.recalibration._acceptance import Reason, RowErrors, Verdict, compared
from stereorecal.recalibration._agreement import MOST_APART
from stereorecal.recalibration._evidence import TILES_OF_A_FRAME, Evidence, evidence
from stereorecal.recalibration._judging import judged
from stereorecal.recalibration._misfit import Misfit
from stereorecal.recalibration._ranged import said_by_ranges
from stereorecal.recalibration._recording import Recording
from stereorecal.recalibration._stages import FEWEST
from stereorecal.recalibration._tasks import Each, beams_of, matched
from stereorecal.scoring import Correspondences

_MOST_WORSE = 0.01  # probability


@dataclass(frozen=True, eq=False)
class Common:
    """What recordings say together.

    Attributes:
        recordings: those that take part.
        free: own and shared parameters.
        shown: what each shows, or all where they have the same extrinsics.
        estimates: one for each of these.
        thetas: what is used of them: the same shared parameters for all.
        beams: the ranges of each recording that have a sure match.
    """

    recordings: Sequence[Recording]
    free: Parameters
    shown: tuple[Shown, ...]
    estimates: tuple[Estimate, ...]
    thetas: tuple[Float[np.ndarray, "n"], ...]
    beams: tuple[Beams, ...]

    @property
    def one(self) -> bool:
        """Whether several recordings have the same extrinsics."""
        return len(self.shown) < len(self.recordings)

    def of(self, index: int) -> int:
        """Which of the estimates is a recording's."""
        return 0 if len(self.shown) == 1 else index

    def rig(self, index: int) -> StereoRig:
        """That a recording is given."""
        at = self.of(index)
        return self.estimates[at].chart.rig_at(self.thetas[at])

    def facts(self, at: int, free: Parameters) -> tuple[Evidence, RowErrors]:
        """The evidence at the rig of an estimate if no more than this had been free, and its row errors against those
        of the initial rig."""
        repair, seen = self.recordings[at].repair, self.estimates[at]
        theta = self.thetas[at] if free is self.free else seen.with_free(free.names)
        chart = row_chart(repair.initial, repair.reach, free)
        facts = evidence(chart, self.shown[at].found, chart.coordinates_of(seen.chart.rig_at(theta)))
        return facts, compared(facts, facts.medians(facts.start_residual), facts.medians(facts.residual))

    def verdict(self, at: int, tiles: Int[np.ndarray, "2 k tiles"]) -> tuple[Verdict, RowErrors, Misfit]:
        """On the rig of an estimate; its tiles have these counts before and after."""
        (facts, rows), seen, found = self.facts(at, self.free), self.estimates[at], self.shown[at].found
        # Where lenses change, extrinsics follow along axes that rows hardly see: the estimate says how far is far.
        own, settled = len(self.free.axes), self.free.names if self.free.lenses else self.free.shared
        said, left = judged(facts, self.free.names, own, tiles, rows, found.covered, settled=settled)
        if said.reason.accepted and not seen.probability_worse(self.thetas[at]) < _MOST_WORSE:
            said = Verdict(Reason.IMPLAUSIBLE)
        if len(seen.other_rigs) > MOST_APART * facts.frames:
            said = Verdict(Reason.FRAMES_DISAGREE)
        return said_by_ranges(said, seen, seen.chart.rig_at(self.thetas[at])), rows, left


def common(recordings: Sequence[Recording], free: Parameters, prior: Prior, *, one: bool, each: Each) -> Common:
    """Solved, matched again, solved again.

    Args:
        one: all recordings have the same extrinsics.
        each: runs a task for each recording.
    """
    beams = (NO_BEAMS,) * len(recordings)
    if any(r.ranges for r in recordings):
        beams = tuple(each(beams_of, [r.task(r.repair.candidate, ranges=True) for r in recordings]))
    shown = [_shown(r, r.found, r.repair.candidate, some) for r, some in zip(recordings, beams, strict=True)]
    first = _solved(recordings, free, prior, shown, beams, one=one, each=each)
    rigs = [first.rig(index) for index in range(len(recordings))]
    again = each(matched, [r.task(rig) for rig, r in zip(rigs, recordings, strict=True)])
    shown = [
        _shown(r, read_by(found, taken=rig, rig=r.repair.initial) if found.found >= FEWEST else r.found, rig, some)
        for r, found, rig, some in zip(recordings, again, rigs, beams, strict=True)
    ]
    return _solved(recordings, free, prior, shown, beams, one=one, each=each)


def _solved(
    recordings: Sequence[Recording],
    free: Parameters,
    prior: Prior,
    shown: Sequence[Shown],
    beams: tuple[Beams, ...],
    *,
    one: bool,
    each: Each,
) -> Common:
    several = (_merged(shown),) if one else tuple(shown)
    estimates = tuple(estimate_together(several, prior, each=each))
    thetas = tuple(with_free_together(estimates, free.names))
    if _worse(estimates, thetas) >= _MOST_WORSE:  # depth that is not known may at least stay as it was calibrated
        kept = tuple(with_free_together(estimates, free.names, depth_kept=True))
        thetas = min(thetas, kept, key=lambda some: _worse(estimates, some))
    return Common(recordings, free, several, estimates, thetas, beams)


def _worse(estimates: Sequence[Estimate], thetas: Sequence[Float[np.ndarray, "n"]]) -> float:
    """The largest probability that one of them is worse off."""
    return max(one.probability_worse(theta) for one, theta in zip(estimates, thetas, strict=True))


def _shown(recording: Recording, found: Correspondences, near: StereoRig, beams: Beams) -> Shown:
    initial = recording.repair.initial
    return Shown(found, initial, rig_parameters(initial).coordinates_of(near), beams)


def _merged(several: Sequence[Shown]) -> Shown:
    """All as one recording, from the middle of their solutions."""
    found = [one.found for one in several]
    first = np.cumsum([0, *(len(one.weight) for one in found)])

    def all_of(name: str) -> Float[np.ndarray, "..."]:
        return np.concatenate([np.asarray(getattr(one, name)) for one in found])

    tiles = [np.asarray(one.tile) + before * TILES_OF_A_FRAME for one, before in zip(found, first, strict=False)]
    rays = {name: all_of(name) for name in ("left", "right", "weight")}
    middle = np.median([one.start for one in several if one.start is not None], axis=0)
    every = replace(found[0], **rays, tile=np.concatenate(tiles))
    return Shown(every, several[0].rig, middle, Beams.of_all([one.beams for one in several]))
