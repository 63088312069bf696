"""Rigs that may be written: the one that loses least, and the most probable one that reads depth as the given one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.estimation._consequences import DISTANCES, Consequences, consequences, points_of_view, readings
from stereorecal.objectives import RigChart

_KEPT_AT = (10, 30)  # baselines: an offset of disparity and a scale of depth
_STEPS = 4
_ROWS_MATTER = 0.1  # pixels: what a matcher notices
_DEPTH_MATTERS = 0.01  # of the disparity
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


@dataclass(frozen=True, eq=False)
class Loss:
    """What the rig at θ loses in rows and depth, over what matters: the square of maps θ - goal.

    Attributes:
        maps: (m, n).
        goal: (m,).
        near: (n,) of θ: what neither rows nor depth tell stays near its mean, each free parameter by so much a unit.
        mean: (n,) of θ.
        deviations: (n,) of θ.
    """

    maps: Float[np.ndarray, "m n"]
    goal: Float[np.ndarray, "m"]
    near: Float[np.ndarray, "n"]
    mean: Float[np.ndarray, "n"]
    deviations: Float[np.ndarray, "n"]

    def of(self, free: Bool[np.ndarray, "n"]) -> tuple[Float[np.ndarray, "k f"], Float[np.ndarray, "k"]]:
        """Maps and goal of parameters that may change, in their deviations; the others are as given (0)."""
        near = np.diag(self.near)[free]
        maps = np.concatenate([self.maps, near])[:, free] * self.deviations[free]
        return maps, np.concatenate([self.goal, near @ self.mean])


def loss(
    near: Consequences,
    mean: Float[np.ndarray, "n"],
    nearness: Float[np.ndarray, "d"],
    deviations: Float[np.ndarray, "n"],
) -> Loss:
    """The loss of rigs.

    Args:
        near: the linear maps at the mean.
        mean: of θ.
        nearness: relative disparity that the rig should read, less that of the rig at the mean, at each of DISTANCES.
        deviations: of θ.
    """
    rows, wanted = [], []
    for index, distance in enumerate(DISTANCES):
        if distance in _SEEN_AT:
            slopes = near.rows[index] / (_ROWS_MATTER * np.sqrt(len(near.rows[index]) * len(_SEEN_AT)))
            rows += [slopes, near.nearness[index : index + 1] / _DEPTH_MATTERS]
            wanted += [slopes @ mean, rows[-1] @ mean + nearness[index] / _DEPTH_MATTERS]
    by_deviation = _NEAR_MEAN / np.maximum(deviations, 1e-12)
    return Loss(np.concatenate(rows), np.concatenate(wanted), by_deviation, mean, deviations)


def least_loss(of: Loss, free: Bool[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """θ that loses least of those whose held parameters are as given (0)."""
    return least_loss_together([of], free, np.zeros_like(free))[0]


def least_loss_together(
    losses: Sequence[Loss], free: Bool[np.ndarray, "n"], shared: Bool[np.ndarray, "n"]
) -> list[Float[np.ndarray, "n"]]:
    """θ of each of several rigs that lose least together.

    Args:
        losses: of each rig.
        free: which parameters may change.
        shared: which are the same for all.
    """
    own, common = int((free & ~shared).sum()), int((free & shared).sum())
    where = np.concatenate([np.flatnonzero(free & ~shared), np.flatnonzero(free & shared)])
    rows, goals = [], []
    for index, one in enumerate(losses):
        # The shared ones in the deviations of the first.
        maps, goal = replace(one, deviations=np.where(shared, losses[0].deviations, one.deviations)).of(free)
        order = np.searchsorted(np.flatnonzero(free), where)
        line = np.zeros((len(goal), own * len(losses) + common))
        line[:, own * index : own * (index + 1)] = maps[:, order[:own]]
        line[:, own * len(losses) :] = maps[:, order[own:]]
        rows.append(line)
        goals.append(goal)
    solution = np.linalg.lstsq(np.concatenate(rows), np.concatenate(goals), rcond=None)[0]
    found = []
    for index, one in enumerate(losses):
        theta = np.zeros(len(free))
        theta[where] = np.concatenate([solution[own * index : own * (index + 1)], solution[own * len(losses) :]])
        found.append(theta * np.where(shared, losses[0].deviations, one.deviations))
    return found
