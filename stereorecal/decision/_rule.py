"""The rule: replace a calibration by one that is better with 99 %, and worse with less than 1 % probability."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from stereorecal.decision._candidates import candidates_of, chosen
from stereorecal.decision._decision import Decision
from stereorecal.decision._losses import counted_harm
from stereorecal.decision._tolerances import DEFAULT, Tolerances
from stereorecal.estimation import Estimate


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
       alone count, if the candidate explains them or leaves them to intrinsics that stay. One that changes intrinsics
       must, with 95 %, cost no region of the view rows that a matcher notices, but one that gains them on average,
       unless frames that took no part prove it, or rows alone count.
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
    candidates = candidates_of(
        several,
        free,
        limits,
        proven=proven,
        depth_observable=depth_observable,
        intrinsics_explain=intrinsics_explain,
    )
    return chosen(candidates, limits)


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
    candidates = candidates_of([estimate], free, limits, depth_observable=True)
    (decision,), (initial,) = chosen(candidates, limits), candidates.initial
    if not decision.refused:
        return decision, decision.theta
    better = [
        one.decisions[0]
        for one in (*candidates.changing, candidates.keeping)
        if one.loss < initial.expected - 1.0 and counted_harm(initial, one.after[0], limits) <= harm
    ]
    return decision, min(better, key=lambda one: one.loss).theta if better else None


def fewer_parameters_suffice(held: Sequence[Decision], freed: Sequence[Decision]) -> bool:
    """Whether fewer free parameters do as well: they repair what more would, and lose no more than is noticed, of rows
    and of rows and depth together."""
    both = list(zip(held, freed, strict=True))
    repairs = all(more.refused or not less.refused for less, more in both)
    aligns = all(less.rows_px[1, 0] < more.rows_px[1, 0] + less.tolerances.gain_px for less, more in both)
    return repairs and aligns and all(less.loss < more.loss + 1.0 for less, more in both)
