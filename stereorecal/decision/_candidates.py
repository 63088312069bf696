"""The candidates that may replace a calibration, the decision on each, and which of them is taken."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from stereorecal.decision._decision import Decision, Verdict
from stereorecal.decision._losses import Losses, chances_of_harm, losses_of, rows_count_alone, with_nearest_distance
from stereorecal.decision._tolerances import Tolerances
from stereorecal.estimation import Estimate, with_free_together
from stereorecal.objectives import BASELINE


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is decided on a candidate for each calibration, and what it loses."""

    decisions: list[Decision]
    after: list[Losses]

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

    def deferring_to(self, other: "Candidate") -> list[Decision]:
        """Its decisions; those of the other one where that knows a better depth, and this one calls it good."""
        doubted = Verdict.GOOD, Verdict.CANNOT_TELL
        each = zip(self.decisions, other.decisions, strict=True)
        return [theirs if (mine.verdict, theirs.verdict) == doubted else mine for mine, theirs in each]

    def aligns_rows_better(self, other: "Candidate", limits: Tolerances) -> bool:
        """Whether the other one costs rows that a matcher notices, and this one is hardly ever for the worse; or, of a
        rig that is blind, so that either may be, loses less."""
        harmless = not self.harms or (self.harms <= other.harms and self.loss < other.loss)
        return bool(harmless and self.rows < other.rows - limits.gain_px)

    def reads_depth_better(self, other: "Candidate", limits: Tolerances) -> bool:
        """Whether it is worth it to change what depth reads: it loses less, and of the rigs for which the two differ by
        what counts, depth is the better one in 95 %."""
        gains = np.concatenate([one.depth for one in other.after]) - np.concatenate([one.depth for one in self.after])
        better_count = np.count_nonzero(gains > limits.worse_depth_points)
        worse_count = np.count_nonzero(-gains > limits.worse_depth_points)
        surely = 0 < better_count >= limits.good_surely * (better_count + worse_count)
        return bool(self.loss < other.loss and surely)


@dataclass(frozen=True, eq=False)
class Candidates:
    """What calibrations lose, and what may replace them: by changing depth, and by keeping it."""

    initial: list[Losses]
    changing: list[Candidate]
    keeping: Candidate


def candidates_of(
    several: Sequence[Estimate],
    free: Sequence[str],
    limits: Tolerances,
    *,
    proven: bool = False,
    depth_observable: bool = False,
    intrinsics_explain: bool = False,
) -> Candidates:
    """What may replace calibrations whose free parameters are the same but for a drift.

    Args:
        several, free, limits, proven, depth_observable, intrinsics_explain: as `decide_together` has them.
    """
    several = [with_nearest_distance(estimate, limits) for estimate in several]
    initial = [losses_of(estimate, np.zeros(len(estimate.names))) for estimate in several]

    def candidate(names: Sequence[str], *, keeps_depth: bool = False) -> Candidate:
        thetas = with_free_together(several, names, keep_depth=keeps_depth)
        after = [losses_of(estimate, theta) for estimate, theta in zip(several, thetas, strict=True)]
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
        return Candidate(decisions, after)

    changing = [candidate(free)]
    if BASELINE in free and any(estimate.matched_ranges or estimate.windows.measured for estimate in several):
        changing.append(candidate((BASELINE,)))  # where rows are good, they stay
    return Candidates(initial, changing, candidate(free, keeps_depth=True))


def chosen(candidates: Candidates, limits: Tolerances) -> list[Decision]:
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


def _decided(
    estimate: Estimate,
    theta: Float[np.ndarray, "n"],
    *,
    before: Losses,
    after: Losses,
    keeps_depth: bool,
    limits: Tolerances,
    proven: bool,
    depth_observable: bool,
    intrinsics_explain: bool,
) -> Decision:
    """The decision between θ = 0, with the losses `before`, and a candidate, with the losses `after`."""
    worse, rows_worse = chances_of_harm(before, after, limits)
    rows_before, rows_after = before.mean_rows, after.mean_rows
    better = float(np.mean(rows_after < rows_before - limits.gain_px))
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
    rows_alone = rows_count_alone(before, after, limits, left_to_intrinsics=left_to_intrinsics)
    harm = rows_worse if rows_alone else worse
    harmless = harm < limits.alpha and (proven or rows_alone or not _costs_a_region(estimate, theta, limits))
    if harmless and (depth_gain or by_rows):
        return replace(no_repair, verdict=Verdict.REPAIR, by_rows=by_rows, left_to_intrinsics=left_to_intrinsics)
    return no_repair


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
    mean = losses_of(estimate, estimate.theta)
    return bool(max(np.median(mean.frame_rows_px), np.median(mean.mean_rows)) <= limits.good_rows_px)
