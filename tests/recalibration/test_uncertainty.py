"""Covariance of the unit box in the units in which people read it."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from parts_of_repairs import uncertainty

from stereorecal.objectives import EXTRINSICS, Reach, row_chart
from stereorecal.recalibration import Uncertainty
from stereorecal.synthetic import default_rig

RIG = default_rig()
PRIOR = 1 / 6  # standard deviation in half widths of a box of twice the reach


@given(st.floats(0.1, 20), st.floats(0.001, 0.5), st.floats(1e-3, 1e3))
def test_units(degrees, fraction, unit):
    """Degrees, and percent of the baseline, whatever the baseline is measured in."""
    rig = RIG.with_extrinsics(np.concatenate([RIG.extrinsics[:3], unit * RIG.extrinsics[3:]]))
    expected = [2 * degrees, 2 * degrees, 2 * degrees, 200 * fraction, 200 * fraction]
    np.testing.assert_allclose(row_chart(rig, Reach(degrees, fraction)).units, expected)


def known_of(posterior: np.ndarray, way=0.0, left=0.0) -> Uncertainty:
    return uncertainty(EXTRINSICS, posterior, np.full(5, way), np.full(5, PRIOR), left)


def test_the_way_to_the_mean_counts():
    """Mean squares of what the truth differs by from the candidate, which need not be the mean."""
    rng = np.random.default_rng(0)
    root = rng.normal(0, 0.01, (5, 5))
    known = known_of(root @ root.T, way=0.02)
    truth = 0.02 + rng.normal(0, 1, (100_000, 5)) @ root.T
    np.testing.assert_allclose(known.covariance, truth.T @ truth / len(truth), atol=2e-5)
    np.testing.assert_allclose(known.interval, 1.96 * np.sqrt(np.mean(truth**2, axis=0)), rtol=0.02)
    assert known.observed.all()
    assert known.unobserved == ()


def test_what_a_calibration_leaves_is_observed_too():
    """Ten times wider than a drift before, as wide as the drift after: the images say much."""
    wide = np.diag(np.full(5, PRIOR**2))
    assert not known_of(wide).observed.any()
    assert known_of(wide, left=(10 * PRIOR) ** 2).observed.all()


@pytest.mark.parametrize("axis", range(5))
def test_what_is_mostly_prior_is_not_observed(axis):
    for share, seen in ((0.49, True), (0.51, False), (1.0, False)):
        variance = np.full(5, 0.01**2)
        variance[axis] = (share * PRIOR) ** 2
        known = known_of(np.diag(variance))
        assert known.observed[axis] == seen
        assert known.unobserved == (() if seen else (EXTRINSICS[axis],))
        assert known.undetermined == (() if seen else (EXTRINSICS[axis],))


def test_a_direction_that_is_left_to_the_prior_is_named():
    """Pitch against y is not known, pitch with y is: neither axis alone says so."""
    covariance = np.diag(np.full(5, 0.01**2))
    against = np.zeros(5)
    against[[0, 3]] = 0.6, -0.8
    known = known_of(covariance + np.outer(against, against) * (0.8 * PRIOR) ** 2)
    assert known.undetermined == ("y with pitch",)


def test_as_many_directions_as_axes_leave_each_axis_open():
    """Two directions of y and z are no "y with z; z with y"."""
    covariance = np.diag(np.full(5, 0.01**2))
    for along, share in (((0.8, 0.6), 0.9), ((-0.6, 0.8), 0.7)):
        direction = np.zeros(5)
        direction[[3, 4]] = along
        covariance = covariance + np.outer(direction, direction) * (share * PRIOR) ** 2
    assert set(known_of(covariance).undetermined) == {"y", "z"}
