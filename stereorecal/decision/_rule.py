"""The rule: replace a calibration by the candidate of least expected loss that gains, does not harm, and predicts what
it has not seen."""

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._json_data import json_data
from stereorecal.decision._tolerances import DEFAULT, Tolerances
from stereorecal.estimation import Estimate, HeldOut, Losses, median_and_interval, with_free_together
from stereorecal.objectives import BASELINE


class Verdict(enum.Enum):
    """What to do with a calibration."""

    REPAIR = "another calibration is a significant improvement"
    GOOD = "the rows are aligned, and there is no significant improvement"
    CANNOT_TELL = "the rows may be misaligned, and there is no significant improvement"


class Test(enum.Enum):
    """What a candidate has to pass; the value says what it is to fail."""

    GAINS = "no change is a significant improvement"
    HARMLESS = "a change may make it worse"
    PREDICTS = "parts of the images contradict each other"


@dataclass(frozen=True, eq=False)
class Decision:
    """What to do with the calibration that an estimate started from.

    Attributes:
        verdict: what to do.
        theta: (n,) the candidate: that of least expected loss of those that pass all tests; if none does, of all.
        keeps_depth: whether the candidate is the one to which a change of depth costs its square.
        worse: probability that the candidate is worse than the calibration, in rows or in depth.
        better: probability that it loses less.
        loss: (2,) that is to be expected of the calibration, and of the candidate.
        rows_px: (2, 3) row error where images show something, of both: median, 95 % interval.
        view_px: (2, 3) the same over the whole view at all distances.
        failed: the first test that the candidate fails; None: it passes.
        held_out: what parts that were left out say; empty if nobody asked.
        tolerances: by which it was decided.
    """

    verdict: Verdict
    theta: Float[np.ndarray, "n"]
    keeps_depth: bool
    worse: float
    better: float
    loss: tuple[float, float]
    rows_px: Float[np.ndarray, "2 3"]
    view_px: Float[np.ndarray, "2 3"]
    failed: Test | None = None
    held_out: tuple[HeldOut, ...] = ()
    tolerances: Tolerances = DEFAULT

    @property
    def refused(self) -> bool:
        """Whether the calibration stays."""
        return self.verdict is not Verdict.REPAIR

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""

        def of_both(px: Float[np.ndarray, "2 3"]) -> dict[str, dict[str, float]]:
            before, after = ({"value": m, "low": low, "high": high} for m, low, high in px.tolist())
            return {"before": before, "candidate": after}

        return json_data(
            {
                "verdict": self.verdict.name.lower(),
                "failed": self.failed and self.failed.name.lower(),
                "keeps_depth": self.keeps_depth,
                "probability_better": self.better,
                "probability_worse": self.worse,
                "expected_loss": dict(zip(("before", "candidate"), self.loss, strict=True)),
                "rows_px": of_both(self.rows_px),
                "rows_of_view_px": of_both(self.view_px),
                "held_out": [vars(part) for part in self.held_out],
                "distances": self.tolerances.distances,
            }
        )


def decide(estimate: Estimate, free: Sequence[str], tolerances: Tolerances | None = None) -> Decision:
    """Choose between a calibration, and changes of its free parameters.

    1. Candidates: the one of least expected loss, rows and depth; the one of least loss to which a change of depth
       costs its square; with ranges or a measured way, also the one that changes only the length of the baseline.
    2. Of those that pass three tests the one of least expected loss replaces the calibration:

       - it gains: the expected loss falls by a unit at least, and to seven tenths; with 90 % probability it falls;
       - it does not harm: with 98 % probability neither rows, where images show something or over the view, nor depth
         at the farthest distance become worse by what is noticed;
       - it predicts what it has not seen: thirds of the view, and places, each left out in turn, have at most eight
         tenths of the row error under the candidate of the rest that they have under the calibration, and none of them
         becomes worse by what is noticed and what the rest leaves open.
    3. If none does, the calibration is good if its rows are, where images show something, with 95 %; else this cannot
       be told.

    Args:
        estimate: what is known; its θ = 0 is the calibration. Without rows there is nothing to predict.
        free: names of the parameters that may change.
        tolerances: default those of `Tolerances()`.
    """
    return decide_together([estimate], free, tolerances)[0]


def decide_together(
    several: Sequence[Estimate], free: Sequence[str], tolerances: Tolerances | None = None
) -> list[Decision]:
    """The same for each of several calibrations whose free parameters are the same but for a drift, by candidates of
    one kind: that which refuses fewest, and loses least.

    Args:
        several: what is known, with the same parameters.
        free, tolerances: as `decide` has them.
    """
    limits = DEFAULT if tolerances is None else tolerances
    several, kinds = _judged(several, limits), _kinds(several, free)
    decisions = [_decisions(several, *kind, limits) for kind in kinds]
    return min(decisions, key=lambda of_kind: (sum(one.refused for one in of_kind), _loss(of_kind), _passed(of_kind)))


def decide_for_trial(
    estimate: Estimate, free: Sequence[str], tolerances: Tolerances | None = None, *, harm: float
) -> tuple[Decision, Float[np.ndarray, "n"] | None]:
    """The decision, and the change to put on trial: the one that it asks for; else the candidate of least expected loss
    that gains a unit; else None. That one is better on average, and not for sure: for those who let later images prove
    it, and can go back.

    Args:
        harm: the chance of harm that it may have, at most.
    """
    limits = DEFAULT if tolerances is None else tolerances
    several, kinds = _judged([estimate], limits), _kinds([estimate], free)
    decisions = [one for kind in kinds for one in _decisions(several, *kind, limits)]
    best = min(decisions, key=lambda one: (one.refused, one.loss[0 if one.refused else 1], _passed([one])))
    if not best.refused:
        return best, best.theta
    better = [one for one in decisions if one.loss[1] < one.loss[0] - 1.0 and one.worse <= harm]
    return best, min(better, key=lambda one: one.loss[1]).theta if better else None


def chance_of_harm(estimate: Estimate, theta: Float[np.ndarray, "n"], tolerances: Tolerances | None = None) -> float:
    """Probability that a change makes rows or depth worse."""
    limits = DEFAULT if tolerances is None else tolerances
    (estimate,) = _judged([estimate], limits)
    return _harm(estimate.losses(np.zeros_like(theta)), estimate.losses(theta), limits)


def _judged(several: Sequence[Estimate], limits: Tolerances) -> list[Estimate]:
    matters = limits.matters
    return [one if one.matters == matters else replace(one, matters=matters) for one in several]


def _kinds(several: Sequence[Estimate], free: Sequence[str]) -> list[tuple[Sequence[str], bool]]:
    """Of candidates: names of the parameters that change, and whether a change of depth costs its square."""
    length = BASELINE in free and any(one.matched_ranges or one.windows.measured for one in several)
    return [(free, False), (free, True), *([((BASELINE,), False)] if length else [])]


def _decisions(
    several: Sequence[Estimate], free: Sequence[str], keeps_depth: bool, limits: Tolerances
) -> list[Decision]:
    thetas = with_free_together(several, free, keep_depth=keeps_depth)
    return [_decision(one, free, keeps_depth, theta, limits) for one, theta in zip(several, thetas, strict=True)]


def _loss(decisions: Sequence[Decision]) -> float:
    """That is to be expected of what is used in the end."""
    return sum(one.loss[0 if one.refused else 1] for one in decisions)


def _passed(decisions: Sequence[Decision]) -> tuple[int, float]:
    """Order of candidates that are refused: those that fail the last test first, then the one of least loss."""
    tests = list(Test)
    return -sum(tests.index(one.failed) for one in decisions if one.failed), sum(one.loss[1] for one in decisions)


def _decision(
    estimate: Estimate, free: Sequence[str], keeps_depth: bool, theta: Float[np.ndarray, "n"], limits: Tolerances
) -> Decision:
    """The decision between θ = 0 and a candidate."""
    zero = np.zeros_like(theta)
    before, after = estimate.losses(zero), estimate.losses(theta)
    expected = estimate.expected_loss(zero), estimate.expected_loss(theta)
    better, worse = float(np.mean(after.total < before.total)), _harm(before, after, limits)
    gains = expected[1] < min(expected[0] - 1.0, limits.leaves * expected[0]) and better >= limits.better
    failed, held_out = None if gains else Test.GAINS, []
    if failed is None and not worse <= limits.harm:  # NaN is no proof of harmlessness
        failed = Test.HARMLESS
    if failed is None:
        held_out = estimate.held_out(free, keep_depth=keeps_depth)
        if not predicts(held_out, limits):
            failed = Test.PREDICTS
    good = float(np.mean(before.seen <= limits.good_rows_px)) >= limits.good_surely
    return Decision(
        verdict=Verdict.REPAIR if failed is None else Verdict.GOOD if good else Verdict.CANNOT_TELL,
        theta=theta,
        keeps_depth=keeps_depth,
        worse=worse,
        better=better,
        loss=expected,
        rows_px=median_and_interval(np.stack([before.seen, after.seen], axis=1)).T,
        view_px=median_and_interval(np.stack([before.even, after.even], axis=1)).T,
        failed=failed,
        held_out=tuple(held_out),
        tolerances=limits,
    )


def predicts(held_out: Sequence[HeldOut], limits: Tolerances) -> bool:
    """Whether parts that were left out bear a candidate out: all together, and none that the rest can predict becomes
    worse by what is noticed, and by half of what the rest leaves open."""
    before, after = (sum(part.count * getattr(part, when) for part in held_out) for when in ("before", "after"))
    known = [part for part in held_out if part.deviation < part.before]
    worse = [part.after - part.before > max(limits.rows_px, limits.contradicts * part.deviation) for part in known]
    return after <= limits.predicts * before and not any(worse)


def _harm(before: Losses, after: Losses, limits: Tolerances) -> float:
    rows = (after.seen <= before.seen + limits.rows_px) & (after.even <= before.even + limits.rows_px)
    return float(np.mean(~(rows & (after.farthest <= before.farthest + limits.depth_points))))
