"""A late right shutter, where windows of motion are known: the right camera sees each pair from where the rig is a
little later.

The θ of a pair is then θ + τ e, e being what the rig's own motion in a second makes of the extrinsics: rows and windows
tell τ as they tell θ. Where all pairs move alike, only the sum is told, and the posterior says that, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np
from jaxtyping import Float

from stereorecal.estimation._evidence import Explanation, Normal, Nuisances
from stereorecal.estimation._explanations import NEGLIGIBLE, Hypothesis, best_of, evidence_of, explanations
from stereorecal.estimation._groups import Groups
from stereorecal.estimation._linear_groups import DEVIATIONS, LinearGroups
from stereorecal.estimation._motion import Window, Windows, root_and_mean, together
from stereorecal.estimation._motion_residuals import Motion
from stereorecal.geometry import StereoRig, euler_from_rotation, rotation_from_vector, vector_from_rotation
from stereorecal.objectives import RigChart

_LATE_SHUTTER = 0.005  # probability: as of an image that is late among single pairs
_DELAY = 0.3  # of the time between two pairs: standard deviation
_MOTION_STEP = 0.01  # of a motion, for derivatives
_ROUNDS, _SETTLED = 6, 0.01  # standard deviations of the delay
_FEWEST_MOVING = 2  # windows that move: one says nothing that the rig does not


@dataclass(frozen=True)
class Delay:
    """The delay of the right shutter.

    Attributes:
        probability: that there is one.
        seconds: how late it is, then; of the time from one pair to the next, where times are not known.
    """

    probability: float
    seconds: float

    @property
    def likely(self) -> bool:
        """Whether there is one, rather than none."""
        return self.probability > 0.5


def delay_of(late: Hypothesis, alone: Sequence[Explanation]) -> Delay:
    """What a hypothesis whose nuisance parameter is the delay in seconds says of it, beside explanations without."""
    evidence = np.concatenate([one.log_evidence for one in late.several])
    own, without = np.logaddexp.reduce(evidence), evidence_of(alone)
    values = np.concatenate([one.nuisance_means[:, 0] for one in late.several])
    return Delay(float(np.exp(own - np.logaddexp(own, without))), float(np.exp(evidence - own) @ values))


def hypothesis_with_delay(rows: LinearGroups, alone: Sequence[Explanation]) -> tuple[Hypothesis, LinearGroups] | None:
    """θ beside a delay in seconds, and the rows near the best of it, with that delay; None where it has no say.

    Args:
        rows: near the rig that was fitted alone, with windows.
        alone: the rig alone, for some misfits and all covariances of the calibration's prior.
    """
    windows, chart, end = rows.model.windows, rows.model.chart, best_of(alone)
    if not windows.frames:
        return None
    size, least = _DELAY * float(np.median(windows.seconds)), end.most - NEGLIGIBLE
    late, nuisances = rows, Nuisances(np.array([size]), float(np.log(_LATE_SHUTTER)))
    misfits, found = list(dict.fromkeys(one.misfit for one in alone)), list(alone)
    theta, delay, ways = end.theta, 0.0, np.zeros((len(windows.tracks), chart.dim))
    for round_ in range(_ROUNDS):
        told = windows.linear_at(chart, theta + delay * ways)
        if sum(one.motion is not None for one in told) < _FEWEST_MOVING:
            return None
        rig, ways = chart.rig_at(theta), np.zeros_like(ways)
        for way, one, seconds in zip(ways, told, windows.seconds, strict=True):
            if one.motion is not None:
                way[:] = of_motion(chart, rig, one.motion) / seconds
        late = _beside_delay(rows, theta, delay, _of_frames(windows, told, ways, rows.groups), nuisances)
        late = replace(late, likelihoods=_likelihoods(rows, theta, told, ways, size))
        if round_:
            late = late.robust(sum(end.misfit), np.append(theta, delay))
        found = explanations(late, range(len(rows.model.prior.roots)), misfits)
        end = best_of(found)
        if end.most < least:
            return None
        last, theta, delay = delay, end.theta, float(end.nuisance_means[end.best, 0])
        # The rig alone may have been far away, and much was misfit.
        at, commons = DEVIATIONS.index(end.misfit[0]), dict.fromkeys(common for _, common in misfits)
        misfits = [(deviation, common) for deviation in DEVIATIONS[max(at - 2, 0) : at + 2] for common in commons]
        if round_ and abs(delay - last) < _SETTLED * size:
            break
    moved = late.at_zero + delay * late.jacobian[:, -1]
    with_delay = replace(rows, jacobian=late.jacobian[:, :-1], at_zero=moved, deviation=late.deviation)
    return Hypothesis.of(late, found), with_delay


def _beside_delay(
    rows: LinearGroups,
    theta: Float[np.ndarray, "n"],
    delay: float,
    ways: Float[np.ndarray, "g n"],
    nuisances: Nuisances,
) -> LinearGroups:
    """Rows linear near a θ and a delay, which is a nuisance parameter."""
    jacobian, at_zero = np.empty_like(rows.jacobian), np.empty_like(rows.at_zero)
    for groups in rows.frames:
        of_frame = rows.model.linear(rows.groups.of(groups), theta + delay * ways[groups[0]], rows.likelihoods)
        jacobian[groups], at_zero[groups] = of_frame.jacobian, of_frame.at_zero
    column = np.einsum("gn,gn->g", jacobian, ways)
    return replace(rows, jacobian=jacobian, at_zero=at_zero).beside(nuisances, column[:, None])


def _likelihoods(
    rows: LinearGroups,
    theta: Float[np.ndarray, "n"],
    windows: Sequence[Window],
    ways: Float[np.ndarray, "w n"],
    size: float,
) -> list[tuple[float, Normal]]:
    """What windows and ranges tell of θ and the delay, whose standard deviation is `size`."""
    root, mean = root_and_mean(rows.model.prior)
    n, chart = len(mean), rows.model.chart
    wider = np.zeros((n + 1, n + 1))
    wider[:n, :n], wider[n, n] = root, size
    # Of θ and of how often the way of a window is added to it.
    both = [(one, np.column_stack([np.eye(n), way])) for one, way in zip(windows, ways, strict=True)]
    by_ways = reduce(add, ((one.with_distance - one.normal).of_parameters(to) for one, to in both))
    alone = together([one.normal.of_parameters(to) for one, to in both], wider, np.append(mean, 0.0))
    of_windows = rows.model.windows.explained(alone, by_ways, chart)
    return [
        (log + other, of_ranges.with_nuisance(1) + normal)
        for log, of_ranges in rows.model.ranges.likelihoods(chart, theta)
        for other, normal in of_windows
    ]


def _of_frames(
    windows: Windows, told: Sequence[Window], ways: Float[np.ndarray, "w n"], groups: Groups
) -> Float[np.ndarray, "g n"]:
    """What a delay does to the frame of each group: the mean of its windows; in none, that of the nearest."""
    known = [
        (groups.first[frame], way)
        for pair, one, way in zip(windows.frames, told, ways, strict=True)
        for frame in pair
        if one.motion is not None
    ]
    numbers, of_each = np.array([frame for frame, _ in known]), np.stack([way for _, way in known])
    frame_distance = np.abs(groups.frame[:, None] - numbers)
    nearest = frame_distance == frame_distance.min(axis=1, keepdims=True)
    return (nearest / nearest.sum(axis=1, keepdims=True)) @ of_each


def of_motion(chart: RigChart, rig: StereoRig, motion: Motion) -> Float[np.ndarray, "n"]:
    """How θ of a rig seems to change, to first order, if the right camera sees what the rig comes to see by a
    motion."""
    turn = vector_from_rotation(motion.rotation)
    rotation = rig.rotation @ np.asarray(rotation_from_vector(_MOTION_STEP * turn), float)
    translation = np.asarray(rig.translation) + _MOTION_STEP * rig.rotation @ motion.translation
    moved = np.concatenate([euler_from_rotation(rotation), translation])
    return (chart.coordinates(moved) - chart.coordinates(np.asarray(rig.extrinsics))) / _MOTION_STEP
