"""The assessment of matches: estimate, match again under what loses least, until that moves no rows; then decide, and
check. The same for one look at the images through a calibration, and for the end of a search."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from stereorecal.decision import ENOUGH, Decision, Reason, Seen, decide, is_sparse, reason_of
from stereorecal.estimation import (
    NO_RANGES,
    Estimate,
    Fit,
    MatchedRanges,
    Recording,
    as_prior,
    fitted,
    rig_parameters,
)
from stereorecal.geometry import StereoRig, same_cameras, with_unit_baseline
from stereorecal.objectives import Reach, RigChart
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import match_ranges
from stereorecal.recalibration._motion_windows import windows_of, without_frames
from stereorecal.recalibration._row_residuals import places_of
from stereorecal.recalibration._stages import SETTLED, StageRun, matched, rows_moved
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, host, image_quality
from stereorecal.scoring.host import refuse_swapped_images

_FEWER = 0.5  # of what the frame that matches most covers
MOST_EXCLUDED = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told
_MATCHED_AGAIN = 2  # times that the estimate may, after it


_Fitter = Callable[[Correspondences, Sequence[int], Float[np.ndarray, "n"]], Fit]


def counts(case: Case, candidate: StereoRig) -> Int[np.ndarray, "2 k tiles"]:
    """The counts of the tiles of all frames at full scale, under the initial calibration and a candidate."""
    data, rigs = case.images.at(1.0), (case.rig, candidate)
    extrinsics = np.stack([with_unit_baseline(rig.extrinsics) for rig in rigs])
    if same_cameras(candidate, case.rig):
        return host.counts_by_tile(data, extrinsics, case.matcher)
    through = zip(rigs, extrinsics, strict=True)
    found = [host.counts_by_tile(data.through(rig), of_rig[None], case.matcher) for rig, of_rig in through]
    return np.concatenate(found)


def share_lost(tiles: Int[np.ndarray, "2 k tiles"]) -> float:
    """What a candidate loses in some tiles and does not find there, as a share of all that it matches: a drift leaves
    chance matches, which are few; where half of an image has moved between the exposures, each half fits a rig of its
    own."""
    before, after = tiles.astype(float)
    return float(np.maximum(before - after, 0.0).sum() / max(after.sum(), 1.0))


def without_frames_of(found: Correspondences, frames: Sequence[int]) -> Correspondences:
    """The correspondences of the other frames."""
    if not len(frames):
        return found
    used = np.isin(np.arange(len(found.weight)), frames, invert=True)
    return replace(found, weight=np.asarray(found.weight) * used[:, None])


def unmatched(found: Correspondences, pairs: Sequence[Pair]) -> tuple[int, ...]:
    """Frames with light and texture that hardly match, where another one does match."""
    covered = (np.asarray(found.weight) > 0).mean(axis=1)
    best = int(covered.argmax())
    fewer = [index for index, share in enumerate(covered) if share < _FEWER * covered[best]]
    if not fewer or is_sparse(covered[best], image_quality(pairs[best]).texture):
        return ()
    quality = {index: image_quality(pairs[index]) for index in fewer}
    return tuple(i for i in fewer if quality[i].enough and is_sparse(covered[i], quality[i].texture))


@dataclass(frozen=True, eq=False)
class Assessment:
    """What the correspondences of all frames say together, and what follows.

    Attributes:
        found: of the frames that are used, matched under a rig near the candidate.
        estimate: of the rig that they show.
        decision: on the initial calibration.
        seen: what they show besides.
        reason: the verdict.
        candidate: of the decision.
        tiles: counts at full scale of all frames, under the initial calibration and the candidate.
        excluded: numbers of the frames that show another rig than the others.
        matching_cost: units that matching again took.
    """

    found: Correspondences
    estimate: Estimate
    decision: Decision
    seen: Seen
    reason: Reason
    candidate: StereoRig
    tiles: Int[np.ndarray, "2 k tiles"]
    excluded: tuple[int, ...]
    matching_cost: float

    @property
    def conclusive(self) -> bool:
        """Whether it sees what it would after a search: a rig that is far off matches little, and by chance."""
        return not (self.seen.few or self.seen.sparse or self.seen.frames_disagree)


def assessed(case: Case, run: StageRun, end_rig: StereoRig) -> Assessment | None:
    """What the matches of a stage say; None if they are too few. All that may change is free in the case; `end_rig`,
    where the search ended, has the cameras of the case's rig."""
    if run.found is None or (shown := _seen(case, run.found)).few:
        return None
    chart, fewer, again = rig_parameters(case.rig), len(run.found.weight) < len(case.images.pairs), 0
    at = chart.coordinates_of(end_rig)
    found = _matched(case, run, chart, at) if fewer else run.found
    fit_of, weighed = _fitter(case, found, end_rig), False
    excluded, disagree, fit = _without_other_rigs(case, found, at, fit_of)
    while True:
        last = disagree or again == _MATCHED_AGAIN  # no candidate is asked where it would be matched anew
        estimated = (fit.weighed() if weighed or last else fit.alone).judged_by(case.settings.tolerances.matters)
        likely = at if last else estimated.with_free(case.free.names)
        anew = None
        if not last and rows_moved(found, chart, at, likely) >= SETTLED:
            anew = _matched(case, run, chart, likely)
            again += 1
        if anew is not None and anew.covered >= (1.0 - ENOUGH.lost) * found.covered:
            found, at, weighed = anew, likely, False
            excluded, disagree, fit = _without_other_rigs(case, found, at, fit_of)
        elif weighed or last:
            break
        else:
            weighed = True
    decision = decide(estimated, case.free.names, case.settings.tolerances)
    used = found if disagree else without_frames_of(found, excluded)
    candidate = chart.rig_at(decision.theta)
    tiles = counts(case, candidate)
    used_frames = np.isin(np.arange(len(used.weight)), () if disagree else excluded, invert=True)
    reach = case.settings.reach
    seen = with_candidate(shown, used, estimated, candidate, tiles[:, used_frames], reach, frames_disagree=disagree)
    reason = reason_of(decision, seen)
    if reason in (Reason.FRAMES_DISAGREE, Reason.NO_MATCHES):
        refuse_swapped_images(case.images, excluded if disagree else None)
    cost = (again + fewer) * case.images.at(run.scale).cost
    return Assessment(used, estimated, decision, seen, reason, candidate, tiles, tuple(sorted(excluded)), cost)


def _seen(case: Case, found: Correspondences) -> Seen:
    quality = case.images.best_quality
    return Seen(
        matches=found.found,
        covered=found.covered,
        places=len(places_of(found)),
        texture=quality.texture,
        enough=case.images.enough,
        problem=quality.problem if all(one.misleading for one in case.images.quality) else None,
    )


def with_candidate(
    seen: Seen,
    found: Correspondences,
    estimated: Estimate,
    candidate: StereoRig,
    tiles: Int[np.ndarray, "2 k tiles"],
    reach: Reach,
    *,
    frames_disagree: bool,
) -> Seen:
    """What images show, with what their matches say of a candidate."""
    return replace(
        seen,
        matches=found.found,
        covered=found.covered,
        places=len(places_of(found)),
        frames_disagree=frames_disagree,
        late=estimated.is_late,
        misfit_px=max(estimated.misfit),
        lens_change=estimated.lens_change,
        lost=share_lost(tiles),
        away=_turned_by(estimated.chart.rig, candidate, reach),
    )


def _turned_by(initial: StereoRig, candidate: StereoRig, reach: Reach) -> float:
    """How far a candidate is turned in pitch and roll, which rows tell, in reaches."""
    turned = np.degrees(np.asarray(candidate.extrinsics) - np.asarray(initial.extrinsics))[[0, 2]]
    return float(np.abs(turned).max() / reach.degrees)


def _matched(case: Case, run: StageRun, chart: RigChart, theta: Float[np.ndarray, "n"]) -> Correspondences:
    """The correspondences under a candidate, of all frames: a stage may look at fewer."""
    return matched(case.images.at(run.scale), chart, theta, case.matcher)


def _fitter(case: Case, first: Correspondences, end_rig: StereoRig) -> _Fitter:
    """The fit of matches of other frames than some, begun at a θ; tracks and ranges are sought once.

    Args:
        first: beside which they are sought.
        end_rig: under which these were matched.
    """
    tracks, prior = windows_of(case, first), as_prior(case.prior, rig_parameters(case.rig))

    def fit_of(found: Correspondences, without: Sequence[int], start: Float[np.ndarray, "n"]) -> Fit:
        ranges = _matched_ranges(case, first, end_rig, without)
        windows = without_frames(case, tracks, without)
        used = without_frames_of(found, without)
        return fitted(Recording(used, case.rig, prior, start, ranges, windows, case.images.view))

    return fit_of


def _matched_ranges(case: Case, found: Correspondences, end_rig: StereoRig, excluded: Sequence[int]) -> MatchedRanges:
    """The ranges of a case that have a sure match beside correspondences, without those of some frames."""
    away = [case.images.pairs[frame] for frame in excluded]
    ranges = [one for one in case.ranges if not any(one.pair is pair for pair in away)]
    if not ranges:
        return NO_RANGES
    return match_ranges(case.images.at(float(found.scale)), end_rig, case.matcher, case.images.pairs, ranges)


def _without_other_rigs(
    case: Case, found: Correspondences, start: Float[np.ndarray, "n"], fit_of: _Fitter
) -> tuple[tuple[int, ...], bool, Fit]:
    """The fit without the frames that show another rig, one more excluded at a time: their numbers, whether they are
    too many to say which are wrong, and the fit, of all frames in that case."""
    excluded = unmatched(found, case.images.pairs) if len(found.weight) > 1 else ()
    seeing = int(np.any(np.asarray(without_frames_of(found, excluded).weight) > 0, axis=1).sum())
    most = MOST_EXCLUDED * (seeing + len(excluded))
    while True:
        fit = fit_of(found, excluded, start)
        if len(excluded) > most:
            return excluded, True, fit_of(found, (), start)
        if not fit.alone.other_rigs:
            return excluded, False, fit
        excluded, start = (*excluded, fit.alone.other_rigs[0].frame), fit.alone.theta
