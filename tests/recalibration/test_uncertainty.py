"""Covariance of the unit box in the units in which people read it."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.objectives import EXTRINSICS, Reach, row_chart
from stereorecal.recalibration._uncertainty import uncertainty
from stereorecal.synthetic import default_rig

RIG = default_rig()
PRIOR = 1 / 6  # standard deviation in half widths of a box of twice the reach


@given(st.floats(0.1, 20), st.floats(0.001, 0.5), st.floats(1e-3, 1e3))
def test_units(degrees, fraction, unit):
    """Degrees, and percent of the baseline, whatever the baseline is measured in."""
    rig = RIG.with_extrinsics(np.concatenate([RIG.extrinsics[:3], unit * RIG.extrinsics[3:]]))
    expected = [2 * degrees, 2 * degrees, 2 * degrees, 200 * fraction, 200 * fraction]
    np.testing.assert_allclose(row_chart(rig, Reach(degrees, fraction)).units, expected)


def test_covariance_and_interval():
    chart = row_chart(RIG, Reach(3.0, 0.03))
    deviation = np.array([0.01, 0.02, 0.03, 0.04, 0.05])
    correlation = np.full((5, 5), 0.3) + 0.7 * np.eye(5)
    known = uncertainty(deviation[:, None] * correlation * deviation, np.zeros((5, 5)), chart)
    np.testing.assert_allclose(np.sqrt(np.diag(known.covariance)), 6.0 * deviation)
    np.testing.assert_allclose(known.interval, 1.96 * 6.0 * deviation)
    scale = np.sqrt(np.diag(known.covariance))
    np.testing.assert_allclose(known.covariance / scale / scale[:, None], correlation)
    assert known.observed.all()
    assert known.unobserved == ()


@pytest.mark.parametrize("axis", range(5))
def test_what_is_mostly_prior_is_not_observed(axis):
    chart = row_chart(RIG, Reach(3.0, 0.03))
    for share, seen in ((0.49, True), (0.51, False), (1.0, False)):
        variance = np.full(5, 0.01**2)
        variance[axis] = (share * PRIOR) ** 2
        known = uncertainty(np.diag(variance), np.zeros((5, 5)), chart)
        assert known.observed[axis] == seen
        assert known.unobserved == (() if seen else (EXTRINSICS[axis],))
        assert known.undetermined == (() if seen else (EXTRINSICS[axis],))


def test_a_direction_that_is_left_to_the_prior_is_named():
    """Pitch against y is not known, pitch with y is: neither axis alone says so."""
    chart = row_chart(RIG, Reach(3.0, 0.03))
    covariance = np.diag(np.full(5, 0.01**2))
    against = np.zeros(5)
    against[[0, 3]] = 0.6, -0.8
    known = uncertainty(covariance + np.outer(against, against) * (0.8 * PRIOR) ** 2, np.zeros((5, 5)), chart)
    assert known.undetermined == ("y with pitch",)


def test_as_many_directions_as_axes_leave_each_axis_open():
    """Two directions of y and z are no "y with z; z with y"."""
    chart = row_chart(RIG, Reach(3.0, 0.03))
    covariance = np.diag(np.full(5, 0.01**2))
    for along, share in (((0.8, 0.6), 0.9), ((-0.6, 0.8), 0.7)):
        direction = np.zeros(5)
        direction[[3, 4]] = along
        covariance = covariance + np.outer(direction, direction) * (share * PRIOR) ** 2
    assert set(uncertainty(covariance, np.zeros((5, 5)), chart).undetermined) == {"y", "z"}


def test_misfit_widens():
    chart, chance = row_chart(RIG, Reach(3.0, 0.03)), np.diag(np.full(5, 0.01**2))
    known = uncertainty(chance, 3 * chance, chart)
    np.testing.assert_allclose(known.interval, 2 * known.interval_by_chance)
    assert known.observed.all()
