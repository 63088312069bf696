"""What is known before the first look, and what looks tell of the calibration that they began with."""

import numpy as np
import pytest
from parts_of_estimates import Measurement
from parts_of_repairs import _calibration_kinds

import stereorecal as sr
from stereorecal.estimation import Normal, calibration_prior, rig_parameters
from stereorecal.online import Config, State, init

RIG = sr.synthetic.default_rig()


def spread(state: State, name: str) -> float:
    return float(np.sqrt(state.posterior.covariance.diagonal()[state.chart.names.index(name)]))


def test_boards_leave_lenses_in_doubt_and_hardly_the_yaw():
    """A rig was calibrated: something will show a yaw that it has turned by since."""
    state, exact = init(RIG), init(RIG, Config(prior="exact"))
    assert float(np.sqrt(state.of_offset[1, 1])) < 0.1 < 0.9 < float(np.sqrt(exact.of_offset[1, 1]))
    assert spread(exact, "right.cx") == 0.0 < 0.1 < spread(state, "right.cx")
    assert spread(state, "pitch") > 0.9


def test_it_does_not_depend_on_where_the_rig_has_turned():
    chart = rig_parameters(RIG)
    turned = init(chart.rig_at(np.r_[0.3, -0.4, 0.2, 0.0, 0.0, np.zeros(chart.dim - 5)]))
    np.testing.assert_allclose(turned.of_offset[1, 1] ** 0.5, init(RIG).of_offset[1, 1] ** 0.5, rtol=0.2)


def test_before_the_first_look_all_kinds_are_as_likely_as_they_were():
    """But for the widest, of which a filter would know less than it begins with."""
    state, prior = init(RIG), calibration_prior(init(RIG).chart)
    variances = np.einsum("k,kij,kij->i", prior.weights, prior.roots, prior.roots)
    found = np.diag(state.posterior.covariance)
    np.testing.assert_allclose(state.posterior.mean, 0.0, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(found[5:] / variances[5:]), 1.0, atol=0.15)


def test_a_kind_knows_never_less_than_all_together():
    """Or what is left of a covariance would be none."""
    _, informations, _ = _calibration_kinds._kinds(RIG, None)
    for one in informations:
        scale = np.sqrt(np.maximum(np.diag(one), 1e-30))
        assert np.linalg.eigvalsh(one / np.outer(scale, scale)).min() > -1e-6


def mixed(state: State, at: list[int], seen: np.ndarray, sigma: float, asked: int) -> tuple[float, float]:
    """Mean and variance of a parameter after others were seen: a filter of each kind of calibration, by evidence."""
    prior, logs, found = calibration_prior(state.chart), [], []
    for root, weight in zip(prior.roots, prior.weights, strict=True):
        covariance = root @ root.T
        of_seen = covariance[np.ix_(at, at)] + sigma**2 * np.eye(len(at))
        gain = np.linalg.solve(of_seen, covariance[at])
        logs.append(np.log(weight) - 0.5 * (seen @ np.linalg.solve(of_seen, seen) + np.linalg.slogdet(of_seen)[1]))
        found.append((seen @ gain[:, asked], (covariance - covariance[:, at] @ gain)[asked, asked]))
    weights, (means, variances) = np.exp(np.array(logs) - np.logaddexp.reduce(logs)), np.array(found).T
    mean = float(weights @ means)
    return mean, float(weights @ (variances + means**2)) - mean**2


def test_lenses_that_are_right_tell_a_good_calibration():
    """Principal points that are seen to be right, or to be wrong: focal lengths, of which nothing was seen, are known
    well, or worse."""
    state, spreads = init(RIG), []
    at, focal = [state.chart.names.index(name) for name in ("left.cy", "right.cy")], state.chart.names.index("left.f")
    for wrong in (0.0, 12.0):
        known, seen = np.zeros((state.chart.dim,) * 2), wrong * np.array([1.0, -1.0])
        known[at, at] = 0.01**-2.0
        told = Measurement(Normal(known, known[:, at] @ seen, 0.0), np.zeros(3))
        after = state.standing_at(state.estimate.updated(told))
        mean, variance = mixed(state, at, seen, 0.01, focal)
        assert after.posterior.mean[focal] == pytest.approx(mean, abs=0.02)
        assert after.posterior.covariance[focal, focal] == pytest.approx(variance, rel=0.05)
        spreads.append(spread(after, "left.f"))
    assert spreads[0] < 0.9 * spread(state, "left.f")
    assert spreads[1] > 1.2 * spreads[0]
