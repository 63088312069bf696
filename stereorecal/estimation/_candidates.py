"""Rigs that may be written: the one that loses least, and the most probable one that reads depth as the given one."""

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._consequences import DISTANCES, Consequences, consequences, points_of_view, readings
from stereorecal.objectives import RigChart

_KEPT_AT = (10, 30)  # baselines: an offset of disparity and a scale of depth
_STEPS = 4
_ROWS_MATTER = 0.1  # pixels: what a matcher notices
_DEPTH_MATTERS = 0.01  # of the disparity
_DEPTH_KEPT = 0.0005  # likewise, where depth is not to change
_NEAR_MEAN = 0.1  # of what a matcher notices, for each deviation of a parameter from its mean
_SEEN_AT = (5, 10, 30)  # baselines


def depth_kept(
    chart: RigChart, mean: Float[np.ndarray, "n"], covariance: Float[np.ndarray, "n n"]
) -> Float[np.ndarray, "n"]:
    """The most probable θ whose disparities are those of the rig at θ = 0, on average over the view; Newton steps along
    the covariance."""
    sets = [points_of_view(chart.rig, distance) for distance in _KEPT_AT]
    slopes = consequences(chart, mean).nearness[[DISTANCES.index(distance) for distance in _KEPT_AT]]
    pull = covariance @ slopes.T
    theta = mean
    for _ in range(_STEPS):
        here = np.array([readings(chart.rig_at(theta), chart.rig, points)[1].mean() for points in sets])
        wanted = slopes @ (mean - theta) + here
        theta = mean - pull @ np.linalg.lstsq(slopes @ pull, wanted, rcond=None)[0]
    return theta


def least_loss(
    near: Consequences,
    mean: Float[np.ndarray, "n"],
    nearness: Float[np.ndarray, "d"],
    free: Bool[np.ndarray, "n"],
    deviations: Float[np.ndarray, "n"],
    depth_matters: float = _DEPTH_MATTERS,
) -> Float[np.ndarray, "n"]:
    """θ that loses least, in rows over the view and in depth, of those whose held parameters are as given (0).

    Args:
        near: the linear maps at the mean.
        mean: of θ.
        nearness: relative disparity that the rig should read, less that of the rig at the mean, at each of DISTANCES.
        free: which parameters may change.
        deviations: of θ: what neither rows nor depth tell stays near the mean.
        depth_matters: share of the disparity that weighs as much as rows that a matcher notices.
    """
    if free.all() and not nearness.any():
        return mean
    rows, wanted = [], []
    for index, distance in enumerate(DISTANCES):
        if distance in _SEEN_AT:
            slopes = near.rows[index] / (_ROWS_MATTER * np.sqrt(len(near.rows[index]) * len(_SEEN_AT)))
            rows += [slopes, near.nearness[index : index + 1] / depth_matters]
            wanted += [slopes @ mean, rows[-1] @ mean + nearness[index] / depth_matters]
    near_mean = _NEAR_MEAN * np.diag(1.0 / np.maximum(deviations, 1e-12))[free]
    maps = np.concatenate([*rows, near_mean])[:, free] * deviations[free]
    goal = np.concatenate([*wanted, near_mean @ mean])
    found = np.zeros(len(mean))
    found[free] = np.linalg.lstsq(maps, goal, rcond=None)[0] * deviations[free]
    return found


def least_loss_of_depth_kept(
    chart: RigChart,
    near: Consequences,
    mean: Float[np.ndarray, "n"],
    free: Bool[np.ndarray, "n"],
    deviations: Float[np.ndarray, "n"],
) -> Float[np.ndarray, "n"]:
    """The same of those that read depth as the rig at θ = 0 does, on average over the view; Newton steps, since depth
    is not linear as far as a drift may reach."""
    sets, at_mean = [points_of_view(chart.rig, distance) for distance in DISTANCES], chart.rig_at(mean)
    nearness = np.array([readings(chart.rig, at_mean, points)[1].mean() for points in sets])
    best, least = np.zeros_like(mean), np.inf
    for _ in range(_STEPS):
        theta = least_loss(near, mean, nearness, free, deviations, _DEPTH_KEPT)
        if not chart.stands_at(theta):
            break
        off = np.array([readings(chart.rig_at(theta), chart.rig, points)[1].mean() for points in sets])
        if not np.abs(off).max() < least:
            break
        best, least, nearness = theta, float(np.abs(off).max()), nearness - off
    return best
