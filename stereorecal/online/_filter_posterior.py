"""What the filter knows of the rig, as the decision takes it: an estimate around the calibration in use; and what
it knows before the first look."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal.estimation import (
    CalibrationCovariance,
    Estimate,
    Posterior,
    Prior,
    as_prior,
    consequences,
    is_exact,
    rig_parameters,
)
from stereorecal.geometry import StereoRig, View
from stereorecal.objectives import EXTRINSICS, RigChart
from stereorecal.online._filter import KEYSTONE, SIZE, FilterEstimate, at_start
from stereorecal.online._state import State, rig_with

_SHIFTS = np.array([index for index, name in enumerate(EXTRINSICS) if name != "yaw"])
_YAW, _PRINCIPAL_POINT = EXTRINSICS.index("yaw"), "right.cx"
_ROWS_AT, _DEPTH_AT = 10, 30  # baselines, as a keystone is measured


def known(initial: StereoRig, using: tuple[float, ...], filtered: FilterEstimate, view: View) -> Estimate:
    """The posterior of the rig, as changes of the calibration in use.

    Args:
        initial: the rig that was given first.
        using: offset of the calibration in use.
        filtered: the filter's estimate.
        view: in which rows and depth are judged.
    """
    chart, keystone = chart_and_keystone(initial, using, view)
    numbers = [*range(SIZE), KEYSTONE]
    ways = np.column_stack([np.eye(chart.dim)[:, :SIZE], keystone])
    true = rig_with(initial, filtered.offset)
    mean = chart.coordinates(np.asarray(true.extrinsics, float)) + filtered.keystone * keystone
    covariance = ways @ filtered.covariance[np.ix_(numbers, numbers)] @ ways.T
    posterior = Posterior(np.ones(1), mean[None], covariance[None])
    return Estimate(chart, posterior, (0.0, 0.0), 0, float("nan"), np.diag(covariance), view=view)


def prior_now(state: State) -> Prior:
    """What is known of the calibration in use, for an estimate by other pairs: of exact intrinsics only that they are;
    else its errors, with the keystone, which rows show and no change of the extrinsics should take up."""
    if is_exact(state.config.prior) or not state.estimate.is_finite:
        return state.config.prior
    posterior = known(state.initial, tuple(state.using.tolist()), state.estimate, state.view).posterior
    names = rig_parameters(state.rig).names
    some = [index for index, variance in enumerate(np.diag(posterior.covariance)) if variance > 0.0]
    covariance = posterior.covariance[np.ix_(some, some)]
    return CalibrationCovariance([names[index] for index in some], covariance, posterior.mean[some])


def filtered_by(state: State, estimate: Estimate, trusted: float) -> FilterEstimate:
    """The filter's estimate that knows of offset and keystone what an estimate by some pairs does: the inverse of
    `known`.

    Args:
        estimate: with `prior_now` as its prior, of changes of the calibration in use.
        trusted: standard deviation of what these pairs may have in common, degrees and percent of the baseline.
    """
    chart, keystone = chart_and_keystone(state.initial, tuple(state.using.tolist()), state.view)
    principal_point = chart.names.index(_PRINCIPAL_POINT)
    numbers = np.eye(SIZE + 1, chart.dim)
    numbers[SIZE] = np.eye(chart.dim)[principal_point] / keystone[principal_point]
    numbers[:SIZE] -= np.outer(keystone[:SIZE], numbers[SIZE])
    offset = np.pad(numbers[:SIZE] @ estimate.theta, (0, chart.dim - SIZE))
    covariance = numbers @ estimate.posterior.covariance @ numbers.T
    covariance[:SIZE, :SIZE] += trusted**2 * np.eye(SIZE)
    mean = np.append(state.offset_of(chart.rig_at(offset)), numbers[SIZE] @ estimate.theta)
    return state.estimate.told(mean, covariance)


@lru_cache(maxsize=2)  # the same until another calibration is in use
def chart_and_keystone(
    initial: StereoRig, using: tuple[float, ...], view: View
) -> tuple[RigChart, Float[np.ndarray, "n"]]:
    """Changes of the calibration in use; and a degree of keystone in their units, the rows of a yaw that is none of
    depth: a yaw, and the principal point that undoes it in depth, as much of both as bends rows like a degree of yaw
    (of a lens with distortion, principal points bend them, too)."""
    chart = rig_parameters(rig_with(initial, np.array(using)))
    consequences_at_rig = consequences(chart, np.zeros(chart.dim), (_ROWS_AT, _DEPTH_AT), view)
    rows, depth = consequences_at_rig.rows[0], consequences_at_rig.mean_nearness[1]
    principal_point, way = chart.names.index(_PRINCIPAL_POINT), np.zeros(chart.dim)
    way[_YAW], way[principal_point] = 1.0, -depth[_YAW] / depth[principal_point]
    like_yaw = (rows @ way) @ rows[:, _YAW] / (rows[:, _YAW] @ rows[:, _YAW])
    return chart, way / like_yaw


def before_looks(state: State) -> FilterEstimate:
    """What the filter knows before the first look: the rig was calibrated, so that something will show a yaw that it
    has turned by; and intrinsics that are wrong bend rows like a keystone, as a yaw does, which is none.

    The yaw with which depth is right, and that with which rows lie straight less that, are as wide as the calibrations
    that are thought possible leave them on average; if the intrinsics are right, no keystone is left, and the yaw as
    any other angle.
    """
    config, deviations = state.config, state.prior
    if is_exact(config.prior):
        return at_start(deviations, config)
    chart = rig_parameters(state.initial)
    consequences_at_rig = consequences(chart, np.zeros(chart.dim), (_ROWS_AT, _DEPTH_AT), state.view)
    rows, depth, own = consequences_at_rig.rows[0], consequences_at_rig.mean_nearness[1], len(EXTRINSICS)
    by_rows = np.linalg.lstsq(rows[:, :own], rows, rcond=None)[0]  # (5, n)
    by_depth = (depth - depth[_SHIFTS] @ by_rows[_SHIFTS]) / depth[_YAW]
    prior = as_prior(config.prior, chart)
    both = np.stack([by_depth, by_rows[_YAW] - by_depth])
    deviations[_YAW], keystone = prior.weights @ np.linalg.norm(both @ prior.roots, axis=-1)
    return at_start(deviations, config, float(keystone))
