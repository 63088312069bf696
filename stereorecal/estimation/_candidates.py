"""Rigs that may be written: the one that loses least, and the most probable one that reads depth as the given one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._consequences import Consequences, readings_at
from stereorecal.geometry import View
from stereorecal.objectives import RigChart

_STEPS = 4
_ROWS_MATTER = 0.1  # pixels: what a matcher notices
_DEPTH_MATTERS = 0.01  # of the disparity
_DEPTH_KEPT = 0.0005  # likewise, where depth is not to change
_NEAR_MEAN = 0.1  # of what a matcher notices, for each deviation of a parameter from its mean


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a rig, as far as candidates are chosen by it.

    Attributes:
        chart: from θ to rigs.
        maps: the linear maps at the mean.
        mean: of θ.
        deviations: of θ: what neither rows nor depth tell stays near the mean.
        nearness: (d, 2) relative disparity that a rig should read, less that of the rig at the mean, at each distance
            of the maps, on average over the view, and ahead.
        judged_at: those of the distances at which it counts, baselines.
        view: the view; None: the rig's own.
    """

    chart: RigChart
    maps: Consequences
    mean: Float[np.ndarray, "n"]
    deviations: Float[np.ndarray, "n"]
    nearness: Float[np.ndarray, "d 2"]
    judged_at: tuple[float, ...]
    view: View | None = None


def least_loss(
    several: Sequence[Known],
    free: Bool[np.ndarray, "n"],
    shared: Bool[np.ndarray, "n"],
    depth_matters: float = _DEPTH_MATTERS,
) -> list[Float[np.ndarray, "n"]]:
    """θ of each rig, which together lose least, in rows over the view and in depth, of those whose held parameters are
    as given (0).

    Args:
        several: rigs, with the same parameters.
        free: which parameters may change.
        shared: which are the same for all.
        depth_matters: share of the disparity that weighs as much as rows that a matcher notices.
    """
    if free.all() and len(several) == 1 and not several[0].nearness.any():
        return [several[0].mean]
    own, common, count = np.flatnonzero(free & ~shared), np.flatnonzero(free & shared), len(several)
    units = [np.where(shared, several[0].deviations, one.deviations) for one in several]
    maps, goals = [], []
    for index, (one, unit) in enumerate(zip(several, units, strict=True)):
        slopes, goal = _loss(one, free, depth_matters)
        slopes = slopes * unit
        empty = np.zeros((len(goal), len(own)))
        maps.append(
            np.column_stack([*[slopes[:, own] if at == index else empty for at in range(count)], slopes[:, common]])
        )
        goals.append(goal)
    found = np.linalg.lstsq(np.concatenate(maps), np.concatenate(goals), rcond=None)[0]
    thetas = [np.zeros(len(free)) for _ in several]
    for theta, unit, of_own in zip(thetas, units, found[: count * len(own)].reshape(count, -1), strict=True):
        theta[own], theta[common] = of_own * unit[own], found[count * len(own) :] * unit[common]
    return thetas


def _loss(
    one: Known, free: Bool[np.ndarray, "n"], depth_matters: float
) -> tuple[Float[np.ndarray, "k n"], Float[np.ndarray, "k"]]:
    """Maps and goal: what the rig at θ loses is the square of maps θ - goal. Disparities count over the whole view, as
    rows do: depth that is as it should be on average may be wrong everywhere. How they vary is the mean's, since that
    comes from lenses, of which rows tell."""
    maps, goal = [], []
    for index, distance in enumerate(one.maps.distances):
        if distance in one.judged_at:
            points = np.sqrt(len(one.maps.rows[index]))
            rows = one.maps.rows[index] / (_ROWS_MATTER * points * np.sqrt(len(one.judged_at)))
            counts = depth_matters * np.sqrt(len(one.maps.nearness[index]))
            nearness = one.maps.nearness[index] / counts
            variation = one.maps.variation[index] / (_DEPTH_MATTERS * points)
            maps += [rows, nearness, variation]
            goal += [
                rows @ one.mean,
                nearness @ one.mean + one.nearness[index] / counts,
                variation @ one.mean,
            ]
    near_mean = _NEAR_MEAN * np.diag(1.0 / np.maximum(one.deviations, 1e-12))[free]
    return np.concatenate([*maps, near_mean]), np.concatenate([*goal, near_mean @ one.mean])


def least_loss_of_depth_kept(
    several: Sequence[Known], free: Bool[np.ndarray, "n"], shared: Bool[np.ndarray, "n"]
) -> list[Float[np.ndarray, "n"]]:
    """The same of those that read depth as the rigs at θ = 0 do, on average over the view and ahead; Newton steps,
    since depth is not linear as far as a drift may reach."""
    means = [one.chart.rig_at(one.mean) for one in several]
    target_nearness = [
        readings_at(one.chart.rig, mean, one.maps.points, one.view)[1] for one, mean in zip(several, means, strict=True)
    ]
    best, least = [np.zeros_like(one.mean) for one in several], np.inf
    for _ in range(_STEPS):
        retargeted = [replace(one, nearness=nearness) for one, nearness in zip(several, target_nearness, strict=True)]
        thetas = least_loss(retargeted, free, shared, _DEPTH_KEPT)
        if not all(one.chart.stands_at(theta) for one, theta in zip(several, thetas, strict=True)):
            break
        off = [
            readings_at(one.chart.rig_at(theta), one.chart.rig, one.maps.points, one.view)[1]
            for one, theta in zip(several, thetas, strict=True)
        ]
        if not np.abs(off).max() < least:
            break
        best, least = thetas, float(np.abs(off).max())
        target_nearness = [nearness - error for nearness, error in zip(target_nearness, off, strict=True)]
    return best
