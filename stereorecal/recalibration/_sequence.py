"""One pair after the other, each repair starting where the one before it ended (paper, section 4.5)."""

from stereorecal.estimation import EXACT
from stereorecal.geometry import AnyView, StereoRig, as_view
from stereorecal.matching import AbstractMatcher
from stereorecal.objectives import Reach
from stereorecal.recalibration._recalibrate import recalibrate
from stereorecal.recalibration._schedule import Schedule, as_schedule
from stereorecal.recalibration._solution import Solution
from stereorecal.recordings import Pairs, check_pairs
from stereorecal.strategies import Budget


def recalibrate_sequence(
    rig: StereoRig,
    pairs: Pairs,
    *,
    matcher: AbstractMatcher | str | None = None,
    schedule: Schedule | str | None = None,
    reach: Reach | tuple[float, float] | None = None,
    budget: Budget | float | None = None,
    view: AnyView = None,
    seed: int = 0,
) -> tuple[Solution, ...]:
    """Repair a rig while it works: one solution for each pair, each from the rig that the one before it left.

    The intrinsics are taken as exact, as the paper takes them. A pair that shows too little leaves the rig as it is.
    Order and several passes are the order of `pairs`; where all pairs are there from the start, `recalibrate` with all
    of them is more accurate.

    Args:
        rig, matcher, schedule, reach, seed: as `recalibrate` has them; the reach counts from where a repair starts.
        budget: of each pair.
        view: of all solutions; default the view of `rig`.

    Raises:
        InputError, StrategyError: as `recalibrate`.
    """
    view = as_view(view, rig)
    schedule = as_schedule(schedule)
    found: list[Solution] = []
    for pair in check_pairs(rig, pairs):
        start = found[-1].rig if found else rig
        repair = recalibrate(
            start,
            [pair],
            matcher=matcher,
            schedule=schedule,
            reach=reach,
            budget=budget,
            view=view,
            seed=seed,
            prior=EXACT,  # a rig that was repaired is no chessboard's, and single pairs would say so again and again
        )
        found.append(repair)
    return tuple(found)
