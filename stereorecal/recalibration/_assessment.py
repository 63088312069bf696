"""The assessment of matches: estimate, match again under what loses least, until that moves no rows; then decide, and
check. The same for one look at the images through a calibration, and for the end of a search."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.decision import ENOUGH, Reason, Seen, decide, is_sparse, reason_of
from stereorecal.estimation import NO_RANGES, Estimate, Fit, Recording, as_prior, fitted, rig_parameters
from stereorecal.geometry import StereoRig, same_cameras, with_unit_baseline
from stereorecal.objectives import Reach, RigChart
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._match_ranges import RangesSeen, match_ranges
from stereorecal.recalibration._mismatch import are_aligned, mismatch_of
from stereorecal.recalibration._motion_windows import windows_of, without_frames
from stereorecal.recalibration._row_residuals import places_of
from stereorecal.recalibration._schedule import watching_scale
from stereorecal.recalibration._solution import Solution
from stereorecal.recalibration._stages import SETTLED, Cost, StageRun, last_matched, matched, rows_moved, with_found
from stereorecal.recalibration._uncertainty import IntrinsicsOutcome, intrinsics_of
from stereorecal.recordings import Pair
from stereorecal.scoring import Correspondences, Pyramid, host, image_quality
from stereorecal.scoring.host import Score, refuse_swapped_images
from stereorecal.strategies import Status

_FEWER = 0.5  # of what the frame that matches most covers
MOST_EXCLUDED = 1.0 / 3.0  # of the frames; if more disagree, which of them are wrong cannot be told
_MATCHED_AGAIN = 2  # times that the estimate may, after it
_SOME = 4  # frames in which chance is measured, those with most texture
_ROWS_OFF = (-17, -11, -7, 7, 11, 17)  # pixels: what matches there does so by chance, or repeats itself


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


def assessed(
    case: Case,
    stages: tuple[StageRun, ...],
    cost: Cost,
    began: float,
    *,
    conclusive: bool = False,
) -> tuple[Solution | None, Cost]:
    """The solution that the last matches of some stages come to, None if they are too few; and the cost, with what it
    took to see that.

    Args:
        stages: that were run; they ended at a rig with the cameras of the case's rig.
        cost: of what came before the stages.
        began: when the clock was started.
        conclusive: None also where a search would see more: a rig that is far off matches little, and by chance.
    """
    run = last_matched(stages)
    if run is None or run.found is None or (shown := _seen(case, run.found)).few:
        return None, cost
    estimated, found, excluded, disagree, matching_cost = _estimated(case, run, run.found, stages[-1].ended)
    free, reach = case.settings.free, case.settings.reach
    decision = decide(estimated, free.names, case.settings.tolerances)
    used = found if disagree else without_frames_of(found, excluded)
    used_frames = _used_frames(case, excluded, disagree)
    candidate = estimated.chart.rig_at(decision.theta)
    tiles = counts(case, candidate)
    seen = with_candidate(shown, used, estimated, candidate, tiles[:, used_frames], reach, frames_disagree=disagree)
    if sparse := is_sparse(seen.covered, 2.0 * seen.texture):
        by_chance, chance_cost = _by_chance(case, estimated.chart, decision.theta, used_frames)
        seen, matching_cost = replace(seen, by_chance=by_chance), matching_cost + chance_cost
    reason = reason_of(decision, seen)
    if reason in (Reason.FRAMES_DISAGREE, Reason.NO_MATCHES):
        refuse_swapped_images(case.images, excluded if disagree else None)
    cost += Cost(judging=matching_cost)
    if conclusive and (disagree or seen.few or seen.by_chance):
        return None, cost + Cost(judging=2.0 * case.images.at(1.0).cost)
    covered = seen.covered
    if not reason.healthy:  # a candidate that is refused may match by what it should not change
        covered = min(covered, _covered_at(case, run.began))
    aligned, by_chance = are_aligned(case.rig, used), seen.by_chance or not sparse
    if mismatch := mismatch_of(case.images, case.matcher, covered, by_chance=by_chance, aligned=aligned):
        seen = replace(seen, wrong_input=True)
        reason = reason_of(decision, seen)
    shared = free.shared if reason.accepted else ()
    solution = solution_of(
        case,
        with_found(stages, used),
        candidate,
        reason,
        tiles,
        cost,
        began,
        excluded=excluded,
        intrinsics=intrinsics_of(estimated, decision.theta, shared, IntrinsicsOutcome.REFINED) if shared else None,
        estimate=estimated,
        decision=decision,
        seen=seen,
        mismatch=mismatch,
    )
    return solution, solution.cost


def _estimated(
    case: Case, run: StageRun, found: Correspondences, end_rig: StereoRig
) -> tuple[Estimate, Correspondences, tuple[int, ...], bool, float]:
    """The estimate of the matches of a stage, which are made again under what loses least until that moves no rows.

    Returns:
        The estimate; the matches that it rests on, of all frames; the numbers of the frames that show another rig than
        the others; whether these are too many to say which are wrong, so that the estimate rests on all; and the units
        that matching again took.
    """
    data, chart, again = case.images.at(run.scale), rig_parameters(case.rig), 0
    at, fewer = chart.coordinates_of(end_rig), len(found.weight) < len(case.images.pairs)
    found = matched(data, chart, at, case.matcher) if fewer else found
    fit_of, weighed = _fitter(case, found, end_rig), False
    excluded, disagree, fit = _without_other_rigs(case, found, at, fit_of)
    while True:
        last = disagree or again == _MATCHED_AGAIN  # no candidate is asked where it would be matched anew
        estimated = (fit.weighed() if weighed or last else fit.alone).judged_by(case.settings.tolerances.matters)
        likely = at if last else estimated.with_free(case.settings.free.names)
        anew = None
        if not last and rows_moved(found, chart, at, likely) >= SETTLED:
            anew = matched(data, chart, likely, case.matcher)
            again += 1
        if anew is not None and anew.covered >= (1.0 - ENOUGH.lost) * found.covered:
            found, at, weighed = anew, likely, False
            excluded, disagree, fit = _without_other_rigs(case, found, at, fit_of)
        elif weighed or last:
            return estimated, found, tuple(sorted(excluded)), disagree, (again + fewer) * data.cost
        else:
            weighed = True


def _by_chance(
    case: Case, chart: RigChart, theta: Float[np.ndarray, "n"], used: Bool[np.ndarray, "k"]
) -> tuple[bool, float]:
    """Whether the rig at θ hardly matches more than with its rows off, in some of the frames that it rests on; and the
    units that it took to see that."""
    pairs = tuple(case.images.pairs[frame] for frame in np.flatnonzero(used))
    data = Pyramid(case.rig, pairs, case.images.view).at(watching_scale(case.rig.left.size), _SOME)
    pitch = np.degrees(np.array([0, *_ROWS_OFF]) / float(data.view.focal))
    away = theta + np.outer(pitch, np.eye(chart.dim)[chart.names.index("pitch")])
    here, *off = (matched(data, chart, one, case.matcher).found for one in away)
    return bool(here < ENOUGH.by_chance * np.median(off)), len(away) * data.cost


def _covered_at(case: Case, rig: StereoRig) -> float:
    """The share that matches under a rig, at half scale: at full scale, one that is degrees off covers as little as one
    with other cameras."""
    data, chart = case.images.at(watching_scale(case.rig.left.size)), case.chart
    return matched(data, chart, chart.coordinates_of(rig), case.matcher).covered


def solution_of(
    case: Case,
    stages: tuple[StageRun, ...],
    candidate: StereoRig,
    reason: Reason,
    tiles: Int[np.ndarray, "2 k tiles"],
    cost: Cost,
    began: float,
    *,
    excluded: tuple[int, ...] = (),
    estimate: Estimate | None = None,
    **findings: Any,
) -> Solution:
    """The solution with a candidate, accepted or not.

    Args:
        tiles: counts at full scale of all frames, under the initial calibration and the candidate.
        excluded: numbers of the frames that show another rig than the others; all of them count all the same where they
            are too many to say which are wrong.
        findings: what else is found, as `Solution` names it.
    """
    disagree = reason is Reason.FRAMES_DISAGREE
    frames, whole = len(case.images.pairs), case.images.at(1.0)
    used = _used_frames(case, excluded, disagree)
    pixels = whole.pixels * int(used.sum()) // frames  # all of one size
    before, after = (Score(int(found.sum()), pixels) for found in tiles[:, used])
    names = tuple(case.images.pairs[frame].name for frame in excluded)
    matched_ranges = NO_RANGES if estimate is None else estimate.matched_ranges
    return Solution(
        initial=case.rig,
        candidate=candidate,
        reason=reason,
        score_before=before,
        score_after=after,
        used=tuple(np.flatnonzero(used).tolist()),
        shown=case.images.best_quality,
        view=case.images.view,
        matcher=case.matcher,
        stages=stages,
        status=Status.CONVERGED,
        message="one look at the images was enough",
        cost=sum((stage.cost for stage in stages), cost + Cost(judging=2 * whole.cost)),
        seconds=time.perf_counter() - began,
        settings=case.settings,
        selected=tuple(range(frames)) if case.selected is None else case.selected,
        left_out=() if disagree else names,
        disagreeing=names if disagree else (),
        ranges=RangesSeen.of(len(case.ranges), matched_ranges, case.rig, candidate, reason),
        estimate=estimate,
        prior_use=case.prior_use,
        **findings,
    )


def _used_frames(case: Case, excluded: tuple[int, ...], disagree: bool) -> Bool[np.ndarray, "k"]:
    """Which frames count: where too many disagree to say which are wrong, all."""
    return np.isin(np.arange(len(case.images.pairs)), () if disagree else excluded, invert=True)


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
    turned = np.degrees(np.asarray(candidate.extrinsics) - np.asarray(estimated.chart.rig.extrinsics))
    return replace(
        seen,
        matches=found.found,
        covered=found.covered,
        places=len(places_of(found)),
        by_chance=seen.by_chance and is_sparse(found.covered, 2.0 * seen.texture),
        frames_disagree=frames_disagree,
        late=estimated.is_late,
        misfit_px=max(estimated.misfit),
        lens_change=estimated.lens_change,
        lost=share_lost(tiles),
        away=float(np.abs(turned[[0, 2]]).max() / reach.degrees),  # in pitch and roll, which rows tell
    )


def _fitter(case: Case, first: Correspondences, end_rig: StereoRig) -> _Fitter:
    """The fit of matches of other frames than some, begun at a θ; tracks and ranges are sought once.

    Args:
        first: beside which they are sought.
        end_rig: under which these were matched.
    """
    tracks, prior = windows_of(case, first), as_prior(case.prior, rig_parameters(case.rig))
    data, pairs = case.images.at(float(first.scale)), case.images.pairs

    def fit_of(found: Correspondences, without: Sequence[int], start: Float[np.ndarray, "n"]) -> Fit:
        away = [pairs[frame] for frame in without]
        of_others = [one for one in case.ranges if not any(one.pair is pair for pair in away)]
        ranges = match_ranges(data, end_rig, case.matcher, pairs, of_others) if of_others else NO_RANGES
        windows = without_frames(case, tracks, without)
        used = without_frames_of(found, without)
        return fitted(Recording(used, case.rig, prior, start, ranges, windows, case.images.view))

    return fit_of


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
