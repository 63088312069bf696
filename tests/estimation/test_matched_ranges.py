"""Ranges in the estimate: they tell depth and the length of the baseline, and wrong ones tell nothing."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.estimation import (
    MatchedRanges,
    Mixture,
    as_prior,
    estimate,
    points_of_view,
    readings,
    with_scaled_boards,
)

METRES = np.array([0.5, 5.0])  # of a baseline of 0.12


@pytest.fixture(scope="module")
def scaled(chart, prior) -> Mixture:
    """The prior where something tells the length of the baseline."""
    return with_scaled_boards(as_prior(prior, chart), chart)


def ranges_of(true, seed=0, number=40, noise=0.1, relative=0.01) -> MatchedRanges:
    """Ranges of points that a rig sees, in pixels with an error."""
    rng = np.random.default_rng(seed)
    left = rng.uniform([40, 40], [600, 440], (number, 2))
    rays, metres = np.asarray(true.left.rays(left)), rng.uniform(*METRES, number)
    points = rays / np.linalg.norm(rays, axis=-1, keepdims=True) * metres[:, None]
    right = true.right.project(points @ true.rotation.T + true.translation) + noise * rng.normal(size=left.shape)
    told = metres * (1.0 + relative * rng.normal(size=number))
    return MatchedRanges(left, right, told, np.maximum(relative, 0.01) * told, np.full(number, 0.1))


def nearness(used, true) -> float:
    """Relative error of disparity at 30 baselines."""
    return float(readings(used, true, points_of_view(true, 30))[1].mean())


def longer(chart, percent) -> np.ndarray:
    return percent * np.eye(chart.dim)[chart.names.index("baseline")]


@settings(max_examples=10)
@given(seed=st.integers(0, 999), percent=st.floats(-2, 2))
def test_exact_ones_have_no_residual_and_pull_nowhere(chart, seed, percent):
    theta = longer(chart, percent)
    true = chart.rig_at(theta)
    seen = ranges_of(true, seed, noise=0.0, relative=0.0)
    seen.metres[:3] = np.inf  # the horizon, of pixels that see it
    far = np.asarray(true.left.rays(seen.left[:3])) @ true.rotation.T
    seen.right[:3] = true.right.project(far)
    np.testing.assert_allclose(seen.residuals(true), 0.0, atol=1e-6)
    normal = seen.normal(chart, theta)
    scale = np.sqrt(np.diag(normal.a))
    np.testing.assert_allclose((normal.a @ theta - normal.b) / scale, 0.0, atol=1e-4)
    assert np.linalg.eigvalsh(normal.a / scale / scale[:, None]).min() > -1e-9


def test_slopes_are_those_of_the_residuals(chart, steps):
    theta = np.random.default_rng(0).normal(size=chart.dim) * 10 * steps
    seen = ranges_of(chart.rig_at(theta), noise=0.0, relative=0.0)
    ends = [[seen.residuals(chart.rig_at(theta + sign * step)) for sign in (1, -1)] for step in np.diag(steps)]
    slopes = np.stack([(more - less) / (2 * step) for (more, less), step in zip(ends, steps, strict=True)], axis=-1)
    np.testing.assert_allclose(seen._jacobian(chart, theta) / steps, slopes / steps, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("percent", [0.0, 2.0])
def test_they_tell_depth(rig, chart, scaled, seen, percent):
    """Ranges tell the depth of a rig that has drifted, whose boards may have been of another size."""
    true = chart.rig_at(np.r_[0.3, 0.2, -0.4, 0.2, -0.3, np.zeros(chart.dim - 5)] + longer(chart, percent))
    found = seen(rig, true, cells=700)
    alone, told = estimate(found, rig, scaled), estimate(found, rig, scaled, ranges=ranges_of(true))
    zero = np.zeros(chart.dim)
    widths = [low - high for _, low, high in (one.depth_error_percent(zero)[30] for one in (alone, told))]
    assert widths[1] / widths[0] < 0.5
    assert abs(nearness(told.chart.rig_at(told.theta), true)) < 0.01


@pytest.mark.parametrize(("times", "number"), [(3.2808, 40), (0.001, 1)])
def test_ranges_in_other_units_tell_nothing(rig, chart, scaled, seen, times, number):
    true = chart.rig_at(np.r_[0.3, 0.2, -0.4, 0.2, -0.3, np.zeros(chart.dim - 5)])
    found, right = seen(rig, true, cells=700), ranges_of(true, number=number)
    wrong = MatchedRanges(right.left, right.right, times * right.metres, times * right.sigma, right.matching)
    alone, told = estimate(found, rig, scaled), estimate(found, rig, scaled, ranges=wrong)
    sigmas = np.sqrt(np.diag(alone.posterior.covariance))
    assert (np.abs(told.theta - alone.theta) < 0.3 * sigmas).all()


@pytest.mark.parametrize("percent", [2.0, 5.0])
@pytest.mark.parametrize("times", [2.5, 0.4])
def test_a_fifth_of_other_things_has_hardly_a_say(rig, chart, scaled, seen, percent, times):
    """Also where the rig that is given disagrees with all of them."""
    true = chart.rig_at(longer(chart, percent))
    mixed = ranges_of(true)
    mixed.metres[::5] *= times
    told = estimate(seen(rig, true, cells=700), rig, scaled, ranges=mixed)
    assert abs(nearness(told.chart.rig_at(told.theta), true)) < 0.012
    assert told.matched_ranges.contradict(told.chart.rig_at(told.theta))[::5].all()


def test_the_deviation_of_a_disparity_is_what_the_error_of_its_range_makes(chart):
    """Ahead, where the distance is the depth: the range a little farther, and the disparity that it then asks for."""
    rig = chart.rig
    seen = replace(ranges_of(rig, noise=0.0, relative=0.0), matching=np.full(40, 1e-9))
    seen = replace(seen, left=np.array(rig.left.matrix)[:2, 2] + 0.01 * (seen.left - seen.left.mean(axis=0)))
    ahead = replace(seen, sigma=1e-4 * seen.metres)
    farther = replace(ahead, metres=ahead.metres + ahead.sigma)
    before, after = (one.residuals(rig) * one.deviations(rig) for one in (ahead, farther))
    np.testing.assert_allclose(np.abs(after - before), ahead.deviations(rig), rtol=0.02)


@pytest.mark.parametrize("off", [0.0, 1.2])
def test_their_likelihood_is_that_of_normal_disparities_against_any(chart, off):
    """One that is far from the others has a wider normal distribution, not only a smaller residual."""
    theta = np.zeros(chart.dim)
    seen = ranges_of(chart.rig, noise=0.0, relative=0.0)
    seen.right[0, 0] += off * 10.0 * seen.deviations(chart.rig)[0]
    residuals, deviations = seen.residuals(chart.rig), seen.deviations(chart.rig)
    wide = deviations * (1.0 + (residuals / 3.0) ** 2)
    normal = -0.5 * (residuals * deviations / wide) ** 2 - np.log(np.sqrt(2.0 * np.pi) * wide)
    density = normal + np.log(0.1 * chart.rig.right.size[0])
    assert -0.5 * seen.normal(chart, theta).c == pytest.approx(density.sum(), rel=1e-6)


@pytest.mark.parametrize(("wrong", "times", "better"), [(0.4, 3.0, True), (0.6, 3.0, False), (0.1, 5.0, True)])
def test_a_rig_with_which_most_ranges_disagree_does_not_fit_them(chart, wrong, times, better):
    """However many fit another one even less, and however far off the others are."""
    true = chart.rig_at(5.0 * np.eye(chart.dim)[chart.names.index("baseline")])
    seen = ranges_of(true, relative=0.0)
    seen.metres[: round(wrong * len(seen.metres))] *= times
    assert seen.fit_better(chart.rig, true) is better
    assert not (better and seen.fit_better(true, chart.rig))
