"""The rule: replace a calibration by one that is better with 99 %, and worse with less than 1 % probability."""

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._json_data import json_data
from stereorecal.decision._tolerances import DEFAULT, Tolerances
from stereorecal.estimation import Estimate, with_free_together
from stereorecal.objectives import BASELINE


class Verdict(enum.Enum):
    """What to do with a calibration."""

    REPAIR = "another calibration is a significant improvement"
    GOOD = "the rows are aligned, and there is no significant improvement"
    CANNOT_TELL = "the rows may be misaligned, and there is no significant improvement"


@dataclass(frozen=True, eq=False)
class Decision:
    """What to do with the calibration that an estimate started from.

    Attributes:
        verdict: what to do.
        theta: (n,) the candidate: that of least loss of those that may replace the calibration; if none may, of all.
        keeps_depth: whether the candidate was chosen to read depth as the calibration does.
        worse: probability that the candidate is worse than the calibration, in rows or in depth.
        better: probability that its rows are better by what a matcher notices.
        loss: that is to be expected of the candidate: rows over what a matcher notices, and depth over a point.
        rows_px: (2, 3) row error over the view, of the calibration and of the candidate: median, 95 % interval.
        ranges_agree: whether ranges agree with the candidate, and not with the calibration.
        tolerances: by which it was decided.
        by_rows: whether its rows are better for sure, also those that most frames show.
        judged_at: the distances at which rows were judged, baselines; depth at the farthest.
        left_to_intrinsics: whether the rows that the candidate leaves are explained by intrinsics that stay.
    """

    verdict: Verdict
    theta: Float[np.ndarray, "n"]
    keeps_depth: bool
    worse: float
    better: float
    loss: float
    rows_px: Float[np.ndarray, "2 3"]
    ranges_agree: bool = False
    tolerances: Tolerances = DEFAULT
    by_rows: bool = False
    judged_at: tuple[float, ...] = DEFAULT.distances
    left_to_intrinsics: bool = False

    @property
    def refused(self) -> bool:
        """Whether the calibration stays."""
        return self.verdict is not Verdict.REPAIR

    @property
    def by_ranges(self) -> bool:
        """Whether ranges alone ask for the candidate: its rows are not better for sure."""
        return not self.refused and not self.by_rows and self.ranges_agree

    @property
    def by_motion(self) -> bool:
        """Whether it is the rig's own motion that asks for the candidate: its depth is better for sure. A repair that
        neither rows nor ranges ask for leaves only motion."""
        return not self.refused and not self.by_rows and not self.ranges_agree

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        before, after = ({"value": m, "low": low, "high": high} for m, low, high in self.rows_px.tolist())
        return json_data(
            {
                "verdict": self.verdict.name.lower(),
                "keeps_depth": self.keeps_depth,
                "probability_better": self.better,
                "probability_worse": self.worse,
                "rows_px": {"before": before, "candidate": after},
                "distances": self.judged_at,
            }
        )

    @property
    def explains(self) -> bool:
        """Whether the rig explains the rows: the candidate's are those of a good calibration, as likely as not."""
        return bool(self.rows_px[1, 0] <= self.tolerances.good_rows_px)

    @property
    def is_understood(self) -> bool:
        """Whether the candidate explains the rows, or intrinsics explain what it leaves."""
        return self.explains or self.left_to_intrinsics

    @property
    def corrects_most(self) -> bool:
        """Whether the candidate corrects more of the rows than it leaves, as likely as not."""
        before, after = self.rows_px[:, 0]
        return bool(after < before - after)


def decide(
    estimate: Estimate,
    free: Sequence[str],
    tolerances: Tolerances | None = None,
    *,
    proven: bool = False,
    depth_observable: bool = False,
    intrinsics_explain: bool = False,
) -> Decision:
    """Choose between a calibration, and changes of its free parameters.

    1. Candidates: the one with the least expected loss in rows and depth; the one with the least loss in rows of those
       that read depth as the calibration does; with ranges or a measured way, also the one that changes only the length
       of the baseline.
    2. A candidate may replace the calibration if one of these asks for it:

       - rows: they are better for sure, also on average those that most frames show, and the candidate explains them,
         or corrects more than it leaves, or intrinsics that stay explain what it leaves (`intrinsics_explain`);
       - ranges: they agree with it and not with the calibration;
       - the rig's own motion: it tells that depth is better;

       and if it is harmless: the probability is below 1 % that rows, of near or far things, or depth, over the view or
       ahead, are worse. Where the rows of the calibration blind the matcher, which leaves it no depth to lose, rows
       alone count. One that changes intrinsics must, with 95 %, cost no region of the view rows that a matcher notices,
       but one that gains them on average, unless frames that took no part prove it, or the calibration blinds the
       matcher.
    3. Of several, the one that keeps depth is taken, unless that costs rows that a matcher notices, ranges ask for
       another, or another's depth is surely the better one: of the rigs for which it matters, in 95 %.
    4. If none may replace it, the calibration is good if its rows are, with 95 %, and motion tells no better depth;
       else this cannot be told.

    Absolute depth is not judged: no rig's rows know it.

    Args:
        estimate: what is known; its θ = 0 is the calibration.
        free: names of the parameters that may change.
        tolerances: default those of `Tolerances()`.
        proven: whether frames that took no part show, all over the view, that the free parameters may change.
        depth_observable: whether more than epipolar errors tells depth, though the estimate has no windows of motion: a
            filter that follows the rig.
        intrinsics_explain: whether rows that a candidate leaves may be those of intrinsics that stay: nothing refutes
            the ones that the estimate finds.
    """
    (found,) = decide_together(
        [estimate],
        free,
        tolerances,
        proven=proven,
        depth_observable=depth_observable,
        intrinsics_explain=intrinsics_explain,
    )
    return found


def decide_together(
    several: Sequence[Estimate],
    free: Sequence[str],
    tolerances: Tolerances | None = None,
    *,
    proven: bool = False,
    depth_observable: bool = False,
    intrinsics_explain: bool = False,
) -> list[Decision]:
    """The same for each of several calibrations whose free parameters are the same but for a drift: all candidates keep
    depth, or none, or change the length of the baseline alone; so that fewest are refused.

    Args:
        several: what is known, with the same parameters.
        free, tolerances, proven, depth_observable, intrinsics_explain: as `decide` has them.
    """
    limits = DEFAULT if tolerances is None else tolerances
    candidates = _candidates(
        several,
        free,
        limits,
        proven=proven,
        depth_observable=depth_observable,
        intrinsics_explain=intrinsics_explain,
    )
    return _chosen(candidates, limits)


def decide_for_trial(
    estimate: Estimate, free: Sequence[str], tolerances: Tolerances | None = None, *, harm: float
) -> tuple[Decision, Float[np.ndarray, "n"] | None]:
    """The decision where more than epipolar errors tells depth, and the change to put on trial: the one that it asks
    for; else the candidate with the least expected loss, if that is by one unit of it, rows that a matcher notices or a
    point of depth, less than the calibration's; else None. That one is better on average, and not for sure: for those
    who let later images prove it, and can go back.

    Args:
        harm: the chance of harm that it may have, at most; where depth is hardly known, a change that keeps it has
            less.
    """
    limits = DEFAULT if tolerances is None else tolerances
    candidates = _candidates([estimate], free, limits, depth_observable=True)
    (decision,), (initial,) = _chosen(candidates, limits), candidates.initial
    if not decision.refused:
        return decision, decision.theta
    better = [
        one.decisions[0]
        for one in (*candidates.changing, candidates.keeping)
        if one.loss < initial.expected - 1.0 and _chances_of_harm(initial, one.after[0], limits)[1] <= harm
    ]
    return decision, min(better, key=lambda one: one.loss).theta if better else None


def with_nearest_distance(estimate: Estimate, tolerances: Tolerances) -> Estimate:
    """An estimate, to be judged at the distances that are asked for, and at the nearest that its images show, if that
    is nearer."""
    nearest, distances = estimate.nearest, tolerances.distances
    judged_at = (nearest, *distances) if nearest < distances[0] else distances
    return estimate if estimate.judged_at == judged_at else replace(estimate, judged_at=judged_at)


def chance_of_harm(estimate: Estimate, theta: Float[np.ndarray, "n"], tolerances: Tolerances | None = None) -> float:
    """Probability that a change makes rows or depth worse; of a calibration whose rows blind the matcher, rows."""
    limits = DEFAULT if tolerances is None else tolerances
    estimate = with_nearest_distance(estimate, limits)
    return _chances_of_harm(_losses(estimate, np.zeros_like(theta)), _losses(estimate, theta), limits)[1]


def fewer_parameters_suffice(held: Sequence[Decision], freed: Sequence[Decision]) -> bool:
    """Whether fewer free parameters do as well: they repair what more would, and lose no more than is noticed, of rows
    and of rows and depth together."""
    both = list(zip(held, freed, strict=True))
    repairs = all(more.refused or not less.refused for less, more in both)
    aligns = all(less.rows_px[1, 0] < more.rows_px[1, 0] + less.tolerances.gain_px for less, more in both)
    return repairs and aligns and all(less.loss < more.loss + 1.0 for less, more in both)


@dataclass(frozen=True, eq=False)
class _Losses:
    """What a rig loses, if each of some rigs drawn from the posterior is the truth.

    Attributes:
        rows: pixels, at each distance.
        depth: percent, at the farthest.
        frame_rows_px: |row difference| of the matches of each frame, on average.
    """

    rows: Float[np.ndarray, "d s"]
    depth: Float[np.ndarray, "s"]
    frame_rows_px: Float[np.ndarray, "f"]

    @property
    def expected(self) -> float:
        """On average: rows over what a matcher notices, and depth over a point; the same whatever is asked."""
        return float(np.mean(self.mean_rows / DEFAULT.gain_px + self.depth / DEFAULT.worse_depth_points))

    @property
    def mean_rows(self) -> Float[np.ndarray, "s"]:
        """Over the distances."""
        return np.mean(self.rows, axis=0)


@dataclass(frozen=True, eq=False)
class _Candidate:
    """What is decided on a candidate for each calibration, and what it loses."""

    decisions: list[Decision]
    after: list[_Losses]

    @property
    def refused(self) -> int:
        """How many calibrations it does not replace."""
        return sum(one.refused for one in self.decisions)

    @property
    def harms(self) -> int:
        """How many it may make worse."""
        return sum(one.worse >= one.tolerances.alpha for one in self.decisions)

    @property
    def loss(self) -> float:
        """To be expected, of all together."""
        return sum(one.loss for one in self.decisions)

    @property
    def rows(self) -> float:
        """Median row errors [px] over the view, on average."""
        return float(np.mean([one.rows_px[1, 0] for one in self.decisions]))

    @property
    def supported_by_ranges(self) -> int:
        """For how many calibrations ranges agree with it."""
        return sum(one.ranges_agree and not one.refused for one in self.decisions)

    def deferring_to(self, other: "_Candidate") -> list[Decision]:
        """Its decisions; those of the other one where that knows a better depth, and this one calls it good."""
        doubted = Verdict.GOOD, Verdict.CANNOT_TELL
        each = zip(self.decisions, other.decisions, strict=True)
        return [theirs if (mine.verdict, theirs.verdict) == doubted else mine for mine, theirs in each]

    def aligns_rows_better(self, other: "_Candidate", limits: Tolerances) -> bool:
        """Whether the other one costs rows that a matcher notices, and this one is hardly ever for the worse; or, of a
        rig that is blind, so that either may be, loses less."""
        harmless = not self.harms or (self.harms <= other.harms and self.loss < other.loss)
        return bool(harmless and self.rows < other.rows - limits.gain_px)

    def reads_depth_better(self, other: "_Candidate", limits: Tolerances) -> bool:
        """Whether it is worth it to change what depth reads: it loses less, and of the rigs for which the two differ by
        what counts, depth is the better one in 95 %."""
        gains = np.concatenate([one.depth for one in other.after]) - np.concatenate([one.depth for one in self.after])
        better_count = np.count_nonzero(gains > limits.worse_depth_points)
        worse_count = np.count_nonzero(-gains > limits.worse_depth_points)
        surely = 0 < better_count >= limits.good_surely * (better_count + worse_count)
        return bool(self.loss < other.loss and surely)


@dataclass(frozen=True, eq=False)
class _Candidates:
    """What calibrations lose, and what may replace them: by changing depth, and by keeping it."""

    initial: list[_Losses]
    changing: list[_Candidate]
    keeping: _Candidate


def _candidates(
    several: Sequence[Estimate],
    free: Sequence[str],
    limits: Tolerances,
    *,
    proven: bool = False,
    depth_observable: bool = False,
    intrinsics_explain: bool = False,
) -> _Candidates:
    several = [with_nearest_distance(estimate, limits) for estimate in several]
    initial = [_losses(estimate, np.zeros(len(estimate.names))) for estimate in several]

    def candidate(names: Sequence[str], *, keeps_depth: bool = False) -> _Candidate:
        thetas = with_free_together(several, names, keep_depth=keeps_depth)
        after = [_losses(estimate, theta) for estimate, theta in zip(several, thetas, strict=True)]
        each = zip(several, thetas, initial, after, strict=True)
        decisions = [
            _decided(
                estimate,
                theta,
                before=before,
                after=of_candidate,
                keeps_depth=keeps_depth,
                limits=limits,
                proven=proven,
                depth_observable=depth_observable or bool(estimate.windows),
                intrinsics_explain=intrinsics_explain,
            )
            for estimate, theta, before, of_candidate in each
        ]
        return _Candidate(decisions, after)

    changing = [candidate(free)]
    if BASELINE in free and any(estimate.matched_ranges or estimate.windows.measured for estimate in several):
        changing.append(candidate((BASELINE,)))  # where rows are good, they stay
    return _Candidates(initial, changing, candidate(free, keeps_depth=True))


def _chosen(candidates: _Candidates, limits: Tolerances) -> list[Decision]:
    """The decisions on the candidate that is taken: the one that refuses fewest, keeping depth where both do."""
    changing, keeping = min(candidates.changing, key=lambda one: (one.refused, one.harms, one.loss)), candidates.keeping
    if keeping.refused != changing.refused:
        return min(keeping, changing, key=lambda one: one.refused).decisions
    worth_it = (
        changing.supported_by_ranges > keeping.supported_by_ranges
        or changing.reads_depth_better(keeping, limits)
        or changing.aligns_rows_better(keeping, limits)
    )
    return changing.decisions if worth_it else keeping.deferring_to(changing)


def _losses(estimate: Estimate, theta: Float[np.ndarray, "n"]) -> _Losses:
    return _Losses(*estimate.losses(theta), estimate.rows_of_frames(theta))


def _decided(
    estimate: Estimate,
    theta: Float[np.ndarray, "n"],
    *,
    before: _Losses,
    after: _Losses,
    keeps_depth: bool,
    limits: Tolerances,
    proven: bool,
    depth_observable: bool,
    intrinsics_explain: bool,
) -> Decision:
    """The decision between θ = 0, with the losses `before`, and a candidate, with the losses `after`."""
    worse, counted_harm = _chances_of_harm(before, after, limits)
    rows_before, rows_after = before.mean_rows, after.mean_rows
    better = float(np.mean(rows_after < rows_before - limits.gain_px))
    harmless = counted_harm < limits.alpha and (
        proven or _is_beyond_matching(before, limits) or not _costs_a_region(estimate, theta, limits)
    )
    ranges_agree = bool(estimate.matched_ranges.fit_better(estimate.chart.rig, estimate.chart.rig_at(theta)))
    nearer = float(np.mean(after.depth < before.depth - limits.worse_depth_points)) > 1.0 - limits.alpha
    # What most frames show bears it out: no posterior knows all ways in which lenses err, and where they do, one frame
    # gains what others lose.
    median_frame_change_px = float(np.median(after.frame_rows_px - before.frame_rows_px))
    depth_improves = depth_observable and nearer
    good = float(np.mean(rows_before <= limits.good_rows_px)) >= limits.good_surely and not depth_improves
    depth_gain = (ranges_agree or depth_improves) and not median_frame_change_px > limits.worse_rows_px
    no_repair = Decision(
        verdict=Verdict.GOOD if good else Verdict.CANNOT_TELL,
        theta=theta,
        keeps_depth=keeps_depth,
        worse=worse,
        better=better,
        loss=after.expected,
        rows_px=np.percentile([rows_before, rows_after], [50.0, 2.5, 97.5], axis=1).T,
        ranges_agree=ranges_agree,
        tolerances=limits,
        judged_at=estimate.judged_at,
    )
    # An estimate without frames: others judge it by later ones.
    borne_out = estimate.shown is None or median_frame_change_px < 0.0
    by_rows = better > 1.0 - limits.alpha and borne_out
    left_to_intrinsics = by_rows and not no_repair.explains and intrinsics_explain and _is_explained(estimate, limits)
    by_rows = by_rows and (no_repair.explains or no_repair.corrects_most or left_to_intrinsics)
    if harmless and (depth_gain or by_rows):
        return replace(no_repair, verdict=Verdict.REPAIR, by_rows=by_rows, left_to_intrinsics=left_to_intrinsics)
    return no_repair


def _chances_of_harm(initial: _Losses, after: _Losses, limits: Tolerances) -> tuple[float, float]:
    """Probability that rows or depth become worse, and the harm that counts: a rig that is blind has no depth to
    lose."""
    # NaN is no proof of harmlessness.
    lost = ~np.all(after.rows <= initial.rows + limits.worse_rows_px, axis=0)
    farther = ~(after.depth <= initial.depth + limits.worse_depth_points)
    worse = float(np.mean(lost | farther))
    return worse, float(np.mean(lost)) if _is_beyond_matching(initial, limits) else worse


def _is_beyond_matching(initial: _Losses, limits: Tolerances) -> bool:
    return float(np.mean(initial.mean_rows > limits.blind_rows_px)) > 1.0 - limits.alpha


def _costs_a_region(estimate: Estimate, theta: Float[np.ndarray, "n"], limits: Tolerances) -> bool:
    """Whether other intrinsics, which can follow what one part of the view shows, may cost another part rows that a
    matcher notices, and on average gain it none."""
    if not any(value and "." in name for name, value in zip(estimate.names, theta.tolist(), strict=True)):
        return False
    before, after = estimate.rows_of_regions(np.zeros_like(theta)), estimate.rows_of_regions(theta)
    loses = np.mean(~(after <= before + limits.gain_px), axis=0) > 1.0 - limits.good_surely
    gains = np.mean(before - after, axis=0) > limits.gain_px
    return bool(np.any(loses & ~gains))


def _is_explained(estimate: Estimate, limits: Tolerances) -> bool:
    """Whether the rig at the mean, with all its parameters, leaves no more rows than good calibrations do: of what the
    frames show, and, as likely as not, over the view."""
    mean = _losses(estimate, estimate.theta)
    return bool(max(np.median(mean.frame_rows_px), np.median(mean.mean_rows)) <= limits.good_rows_px)
