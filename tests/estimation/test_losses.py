"""The expected loss in closed form against rigs drawn from the posterior, and the bound by which it is minimised."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import PointwiseLoss, _normal, errors_near, points_shown
from scipy.special import erf
from scipy.stats import norm

from stereorecal.estimation import Estimate, Matters, Mixture, estimate, points_of_view, readings

SIZES = {"deg": 0.05, "%": 0.3, "px": 2.0, "": 1e-3}


def posterior_of(chart, seed: int, number: int = 3, spread: float = 1.0) -> Mixture:
    """Explanations that differ by their deviations times a spread."""
    rng = np.random.default_rng(seed)
    sizes = np.array([SIZES[parameter.unit] for parameter in chart.parameters])
    roots = rng.normal(0, 0.3, (number, chart.dim, chart.dim)) * sizes[:, None]
    means = spread * rng.normal(0, 1, (number, chart.dim)) * sizes
    return Mixture(rng.dirichlet(np.ones(number)), means, roots @ np.swapaxes(roots, 1, 2))


@given(z=st.floats(-12, 12))
def test_the_normal_integral_is_that_of_libraries(z):
    density, twice = _normal(np.array([z, -z, 0.0]))
    np.testing.assert_allclose(density, norm.pdf([z, -z, 0.0]), rtol=1e-12)
    np.testing.assert_allclose(twice, [erf(z / 2**0.5), -erf(z / 2**0.5), 0.0], rtol=1e-9, atol=1e-11)


@settings(max_examples=10)
@given(seed=st.integers(0, 999), spread=st.floats(0.0, 3.0))
def test_it_is_the_mean_of_absolute_errors_of_many_rigs(chart, seed, spread):
    """Whether it is told of a rig at the mean or of another; in units of what is noticed."""
    known = posterior_of(chart, seed, spread=spread)
    errors = errors_near(chart, known.mean, Matters(0.1, 2.0, (7, 40)), None, None)
    loss = PointwiseLoss(errors, known)
    drawn = (known.samples(8000, seed) - known.mean) @ errors.slopes.T
    for found in (np.zeros(drawn.shape[1]), drawn[0]):
        each = np.abs(found - drawn) @ errors.weights
        assert loss.expected(found) == pytest.approx(each.mean(), abs=5.0 * each.std() / np.sqrt(len(each)))


@settings(max_examples=20)
@given(seed=st.integers(0, 999), step=st.floats(-3, 2), exact=st.booleans())
def test_a_quadratic_bound_touches_it_and_lies_above(chart, near, seed, step, exact):
    """Also at the centre of a distribution, and of one that is nearly a point."""
    known, rng = posterior_of(chart, seed), np.random.default_rng(seed)
    known = Mixture(known.weights, known.means, known.covariances * (1e-12 if exact else 1.0))
    loss = PointwiseLoss(near, known)
    here = np.where(rng.random(loss.centres.shape[1]) < 0.2, loss.centres[0], 3.0 * rng.normal(size=len(near.weights)))
    curvature, slope = loss.quadratic(here)
    assert (curvature >= 0.0).all()
    away = 10.0**step * rng.normal(size=len(here))
    bound = loss.expected(here) + slope @ away + 0.5 * curvature @ away**2
    assert loss.expected(here + away) <= bound * (1 + 1e-9)
    small = 1e-6 * away / np.abs(away).max() * (not exact)
    assert loss.expected(here + small) == pytest.approx(loss.expected(here) + slope @ small, abs=1e-9)


@pytest.fixture(scope="module")
def near(chart):
    return errors_near(chart, np.zeros(chart.dim), Matters(), None, None)


@pytest.fixture(scope="module")
def found(rig, chart, seen) -> Estimate:
    return estimate(seen(rig, chart.rig_at(np.r_[0.2, 0.1, -0.2, 0.1, -0.2, np.zeros(chart.dim - 5)])), rig)


def test_an_estimate_says_one_loss_on_average_and_of_each_rig(chart, found):
    for used in (np.zeros(chart.dim), found.theta, found.with_free(chart.names[:5])):
        each = found.losses(used)
        assert found.expected_loss(used) == pytest.approx(each.total.mean(), rel=0.03)
        parts = each.seen / 1.5 + each.even / 3.0  # two thirds of rows are where images show something
        assert (each.total >= parts / found.matters.rows_px * (1 - 1e-9)).all()  # the rest is depth


def test_losses_are_those_of_points_of_the_view(rig, chart, found):
    """The losses are rows and depth as `readings` has them, where one rig is surely the true one."""
    true = found.chart.rig_at(found.theta)
    surely = Mixture(np.ones(1), found.theta[None], np.zeros((1, chart.dim, chart.dim)))
    alone = Estimate(chart, surely, (0.0, 0.0), 0, 0.0, np.zeros(chart.dim), shown=found.shown)
    losses = alone.losses(np.zeros(chart.dim))
    read = [readings(rig, true, points_of_view(true, distance)) for distance in alone.matters.distances]
    rows = np.mean([np.abs(rows).mean() for rows, _ in read])
    depth = [100.0 * np.abs(nearness).mean() for _, nearness in read]
    farthest = points_of_view(true, alone.matters.distances[-1])
    middle = np.abs(true.left.project(farthest / farthest[:, 2:]) / np.array(true.left.size) - 0.5).max(axis=1) <= 0.25
    ahead = 100.0 * np.abs(read[-1][1][middle]).mean()
    assert abs(ahead - depth[-1]) > 0.1, "else the test cannot tell them apart"
    points, weights = points_shown(found.shown, found.chart, found.theta)
    seen = weights @ np.abs(readings(rig, true, points)[0])
    each = [losses.even[0], losses.farthest[0], losses.seen[0]]
    np.testing.assert_allclose(each, [rows, ahead, seen], rtol=1e-6)  # errors of samples are float32
    total = (seen / 1.5 + rows / 3.0) / alone.matters.rows_px + np.mean(depth) / alone.matters.depth_points
    np.testing.assert_allclose(losses.total, total, rtol=1e-6)
    small = 1e-3 * np.eye(chart.dim)[chart.names.index("yaw")]
    assert alone.effect(small) == pytest.approx(alone.expected_loss(alone.theta + small), rel=0.01)
    twice = Matters(2.0 * alone.matters.rows_px, 2.0 * alone.matters.depth_points)
    np.testing.assert_allclose(alone.judged_by(twice).losses(np.zeros(chart.dim)).total, 0.5 * total, rtol=1e-6)


@settings(max_examples=20)
@given(seed=st.integers(0, 999))
def test_what_is_shown_lies_where_the_pixels_are(chart, found, seed):
    """Whatever the intrinsics: a yaw and a principal point make up for each other, and depth stays."""
    theta = posterior_of(chart, seed, number=1, spread=2.0).mean
    rig = chart.rig_at(theta)
    points, _ = points_shown(found.shown, chart, theta)
    pixels = np.round(rig.left.project(points / points[:, 2:]), 6)
    given = np.asarray(chart.rig.left.project(found.shown.left))
    which = [int(np.abs(given - pixel).max(axis=1).argmin()) for pixel in pixels]
    np.testing.assert_allclose(pixels, given[which], atol=1e-4)
    right = points @ rig.rotation.T + rig.translation
    columns = rig.right.project(right / right[:, 2:])[:, 0]
    seen = np.asarray(chart.rig.right.project(found.shown.right))[which, 0]
    assert np.median(np.abs(columns - seen)) < 1.0  # the rays do not meet exactly
