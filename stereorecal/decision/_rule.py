"""The rule: replace a calibration by the candidate of least expected loss that gains, does not harm, and predicts what
it has not seen."""

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from stereorecal._arrays import json_data
from stereorecal.decision._tolerances import COSTS, DEFAULT, STEPS, Tolerances
from stereorecal.estimation import Estimate, HeldOut, Losses, median_and_interval, with_free_together


class Verdict(enum.Enum):
    """What to do with a calibration."""

    REPAIR = "another calibration is a significant improvement"
    GOOD = "the rows are aligned, and there is no significant improvement"
    CANNOT_TELL = "the rows may be misaligned, and there is no significant improvement"


class Criterion(enum.Enum):
    """What a candidate has to meet; the value says what it is to fail."""

    GAINS = "what a correction would gain is too little"
    HARMLESS = "a correction may make it worse"
    PREDICTS = "parts of the images that were left out do not confirm a correction"


@dataclass(frozen=True, eq=False)
class Decision:
    """What to do with the calibration that an estimate started from.

    Attributes:
        verdict: what to do.
        theta: (n,) the candidate.
        depth_corrected: where the candidate lies between the one that keeps depth, 0, and that of least loss, 1.
        worse: probability that the candidate is worse than the calibration, in rows or in depth.
        better: probability that it loses less.
        loss: (2,) that is to be expected of the calibration, and of the candidate.
        rows_px: (2, 3) epipolar error where images show something, of both: median, 95 % interval.
        view_px: (2, 3) the same over the whole view at all distances.
        failed: the first criterion that the candidate fails; None: it meets all.
        held_out: what parts that were left out say; empty if nobody asked.
        tolerances: by which it was decided.
    """

    verdict: Verdict
    theta: Float[np.ndarray, "n"]
    depth_corrected: float
    worse: float
    better: float
    loss: tuple[float, float]
    rows_px: Float[np.ndarray, "2 3"]
    view_px: Float[np.ndarray, "2 3"]
    failed: Criterion | None = None
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
                "depth_corrected": self.depth_corrected,
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

    1. The candidate is the one of least expected loss, rows and depth; where that may harm, as near to it as does no
       harm on the way to the one to which a change of depth costs its square, and on to where it costs more.
    2. It replaces the calibration if it meets three criteria:

       - it gains: the expected loss falls by a unit at least, and to seven tenths; with 90 % probability it falls;
       - it does not harm: with 98 % probability neither rows, where images show something or over the view, nor depth
         ahead at the farthest distance become worse by what is noticed;
       - it predicts what it has not seen: thirds of the view, and places, each left out in turn (`predicts`).
    3. If it fails one, the calibration is good if its rows are, where images show something, with 95 %; else this
       cannot be told.

    Args:
        estimate: what is known; its θ = 0 is the calibration. Without rows there is nothing to predict.
        free: names of the parameters that may change.
        tolerances: default those of `Tolerances()`.
    """
    return decide_together([estimate], free, tolerances)[0]


def decide_together(
    several: Sequence[Estimate], free: Sequence[str], tolerances: Tolerances | None = None
) -> list[Decision]:
    """The same for each of several calibrations with the same parameters, of which the free ones are the same but for a
    drift."""
    limits = DEFAULT if tolerances is None else tolerances
    several = [one.judged_by(limits.matters) for one in several]
    before = [one.losses(np.zeros(len(one.names))) for one in several]

    def harmless(thetas: list[Float[np.ndarray, "n"]]) -> bool:
        each = zip(several, before, thetas, strict=True)
        return all(_harm(losses, one.losses(theta), limits) <= limits.harm for one, losses, theta in each)

    thetas, share, kept = _candidate(several, free, harmless)
    return [_decision(one, free, theta, share, kept, limits) for one, theta in zip(several, thetas, strict=True)]


def _candidate(
    several: Sequence[Estimate], free: Sequence[str], harmless: Callable[[list[Float[np.ndarray, "n"]]], bool]
) -> tuple[list[Float[np.ndarray, "n"]], float, float]:
    """The first candidates that are harmless, one of each calibration, from losing least to keeping depth, and on to
    where a change of depth costs more; else those that keep depth. Also how far they lie from that to losing least, and
    the cost."""
    least = with_free_together(several, free)
    if harmless(least):
        return least, 1.0, 1.0
    kept = with_free_together(several, free, keep_depth=1.0)
    for share in (np.arange(STEPS)[::-1] / STEPS).tolist():
        thetas = [near + share * (far - near) for near, far in zip(kept, least, strict=True)]
        if harmless(thetas):
            return thetas, share, 1.0
    for cost in COSTS:
        stricter = with_free_together(several, free, keep_depth=cost)
        if harmless(stricter):
            return stricter, 0.0, cost
    return kept, 0.0, 1.0


def _decision(
    estimate: Estimate,
    free: Sequence[str],
    theta: Float[np.ndarray, "n"],
    share: float,
    kept: float,
    limits: Tolerances,
) -> Decision:
    """The decision between θ = 0 and a candidate."""
    zero = np.zeros_like(theta)
    before, after = estimate.losses(zero), estimate.losses(theta)
    expected = estimate.expected_loss(zero), estimate.expected_loss(theta)
    better, worse = float(np.mean(after.total < before.total)), _harm(before, after, limits)
    gains = expected[1] < min(expected[0] - limits.gains, limits.leaves * expected[0]) and better >= limits.better
    harmless = worse <= limits.harm  # NaN is no proof of harmlessness
    held_out = estimate.held_out(free, share, kept) if gains and harmless else []
    predicted = estimate.shown is None or predicts(held_out, limits, rows_alone=not estimate.depth_told)
    failed = next((one for one, met in zip(Criterion, (gains, harmless, predicted), strict=True) if not met), None)
    good = float(np.mean(before.seen <= limits.good_rows_px)) >= limits.good_surely
    return Decision(
        verdict=Verdict.REPAIR if failed is None else Verdict.GOOD if good else Verdict.CANNOT_TELL,
        theta=theta,
        depth_corrected=share,
        worse=worse,
        better=better,
        loss=expected,
        rows_px=median_and_interval(np.stack([before.seen, after.seen], axis=1)).T,
        view_px=median_and_interval(np.stack([before.even, after.even], axis=1)).T,
        failed=failed,
        held_out=tuple(held_out),
        tolerances=limits,
    )


def predicts(held_out: Sequence[HeldOut], limits: Tolerances, *, rows_alone: bool = True) -> bool:
    """Whether parts that were left out bear a candidate out. Under the candidate of the rest each is aligned, or not
    worse than under the calibration; all together are aligned, or show eight tenths of what the candidate of all gains.
    Where nothing but rows tells what it gains, at most eight tenths of their error may be left."""
    if not held_out or any(part.after > max(part.before, limits.good_rows_px) for part in held_out):
        return False
    each = np.array([(part.count, part.before, part.after, part.fitted) for part in held_out])
    before, after, fitted = each[:, 1:].T @ each[:, 0]
    aligned = after <= limits.good_rows_px * each[:, 0].sum()
    gained = before - after >= limits.predicts * (before - fitted)
    return bool(aligned or gained) and not (rows_alone and after > limits.predicts * before)


def _harm(before: Losses, after: Losses, limits: Tolerances) -> float:
    rows = (after.seen <= before.seen + limits.rows_px) & (after.even <= before.even + limits.rows_px)
    return float(np.mean(~(rows & (after.farthest <= before.farthest + limits.depth_points))))
