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

from stereorecal.estimation._calibration_prior import CalibrationPrior
from stereorecal.estimation._confounders import NEGLIGIBLE
from stereorecal.estimation._evidence import Normal
from stereorecal.estimation._explanations import Explanation, Hypothesis, best_of, explanations
from stereorecal.estimation._groups import Groups
from stereorecal.estimation._linear_groups import DEVIATIONS, LinearGroups
from stereorecal.estimation._motion import Window, Windows, root_and_mean, together, window
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
    """Of the right shutter.

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
    evidence, without = (np.concatenate([e.found.log_evidence for e in some]) for some in (late.several, alone))
    both = np.logaddexp.reduce(np.concatenate([evidence, without]))
    weights = np.exp(evidence - np.logaddexp.reduce(evidence))
    values = np.concatenate([one.found.nuisance[:, 0] for one in late.several])
    return Delay(float(np.exp(np.logaddexp.reduce(evidence) - both)), float(weights @ values))


def hypothesis_with_delay(
    rows: LinearGroups, chart: RigChart, prior: CalibrationPrior, alone: Sequence[Explanation]
) -> tuple[Hypothesis, LinearGroups] | None:
    """θ beside a delay in seconds, and the rows near the best of it, with that delay; None where it has no say.

    Args:
        rows: near the rig that was fitted alone, with windows.
        alone: the rig alone, for some misfits and all covariances of the calibration's prior.
    """
    windows, end = rows.measured.windows, best_of(alone)[0]
    if not windows.frames:
        return None
    size = _DELAY * float(np.median(windows.seconds))
    least = float(end.found.log_evidence.max()) - NEGLIGIBLE
    theta, delay = end.found.means[end.found.log_evidence.argmax()], 0.0
    misfits = list(dict.fromkeys(one.misfit for one in alone))
    ways, late, found = np.zeros((len(windows.tracks), chart.dim)), rows, list(alone)
    nuisance, log_prior = np.full((1, 1), size), float(np.log(_LATE_SHUTTER))
    for round_ in range(_ROUNDS):
        rig = chart.rig_at(theta)
        windows_at_theta = [
            window(one, chart, theta + delay * way, travelled)
            for one, way, travelled in zip(windows.tracks, ways, windows.all_ways, strict=True)
        ]
        if sum(one.motion is not None for one in windows_at_theta) < _FEWEST_MOVING:
            return None
        ways = np.stack(
            [
                np.zeros(chart.dim) if one.motion is None else of_motion(chart, rig, one.motion) / seconds
                for one, seconds in zip(windows_at_theta, windows.seconds, strict=True)
            ]
        )
        likelihoods = _delay_evidence(rows, chart, theta, windows_at_theta, ways, prior, size)
        by_frame = _of_frames(windows, windows_at_theta, ways, rows.groups)
        late = replace(_rows_and_delay(rows, chart, theta, delay, by_frame), likelihoods=likelihoods)
        if round_:
            late = replace(late, deviation=late.robust(sum(end.misfit), np.append(theta, delay)))
        found = explanations(late, prior, range(len(prior.roots)), misfits, nuisance, log_prior)
        end, kind = best_of(found)
        if end.found.log_evidence[kind] < least:
            return None
        last, theta, delay = delay, end.found.means[kind], float(end.found.nuisance[kind, 0])
        # The rig alone may have been far away, and much was misfit.
        at, commons = DEVIATIONS.index(end.misfit[0]), dict.fromkeys(common for _, common in misfits)
        misfits = [(deviation, common) for deviation in DEVIATIONS[max(at - 2, 0) : at + 2] for common in commons]
        if round_ and abs(delay - last) < _SETTLED * size:
            break
    moved = late.at_zero + delay * late.jacobian[:, -1]
    with_delay = replace(rows, jacobian=late.jacobian[:, :-1], at_zero=moved, deviation=late.deviation)
    return Hypothesis(late, found, end.misfit, nuisance, log_prior), with_delay


def _rows_and_delay(
    rows: LinearGroups, chart: RigChart, theta: Float[np.ndarray, "n"], delay: float, ways: Float[np.ndarray, "g n"]
) -> LinearGroups:
    """Linear near a θ and a delay, with a column for that."""
    jacobian, at_zero = np.empty_like(rows.jacobian), np.empty_like(rows.at_zero)
    for groups in rows.frames:
        theta_of_frame = theta + delay * ways[groups[0]]
        linear = rows.groups.of(groups).rows(chart, theta_of_frame)
        jacobian[groups] = linear.jacobian[:, 0].T
        at_zero[groups] = linear.differences[0] - jacobian[groups] @ theta_of_frame
    column = np.einsum("gn,gn->g", jacobian, ways)
    return replace(rows, jacobian=np.column_stack([jacobian, column]), at_zero=at_zero)


def _delay_evidence(
    rows: LinearGroups,
    chart: RigChart,
    theta: Float[np.ndarray, "n"],
    windows_at_theta: Sequence[Window],
    ways: Float[np.ndarray, "w n"],
    prior: CalibrationPrior,
    size: float,
) -> list[tuple[float, Normal]]:
    """What windows and ranges tell of θ and the delay."""
    root, mean = root_and_mean(prior)
    wider = np.zeros((len(mean) + 1,) * 2)
    wider[:-1, :-1], wider[-1, -1] = root, size
    # Of θ and of how often the way of a window is added to it.
    to = [(one, np.column_stack([np.eye(len(way)), way])) for one, way in zip(windows_at_theta, ways, strict=True)]
    several = [one.normal.of_parameters(both) for one, both in to]
    by_ways = [(one.with_distance - one.normal).of_parameters(both) for one, both in to]
    alone = together(several, wider, np.append(mean, 0.0))
    of_windows = rows.measured.windows.explained(alone, reduce(add, by_ways), chart)
    return [
        (log + other, of_ranges.with_nuisance(1) + normal)
        for log, of_ranges in rows.measured.ranges.likelihoods(chart, theta)
        for other, normal in of_windows
    ]


def _of_frames(
    windows: Windows, windows_at_theta: Sequence[Window], ways: Float[np.ndarray, "w n"], groups: Groups
) -> Float[np.ndarray, "g n"]:
    """Of the frame of each group: the mean of its windows; of one that is in none, that of the nearest."""
    known = [
        (groups.first[frame], way)
        for pair, one, way in zip(windows.frames, windows_at_theta, ways, strict=True)
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
