"""Covariance of the unit box in the units in which people read it."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.objectives import FREE_AXES, Reach, count_box, row_box
from stereorecal.recalibration._uncertainty import reading_units, uncertainty
from stereorecal.synthetic import default_rig

RIG = default_rig()
PRIOR = 1 / 6  # standard deviation in half widths of a box of twice the reach


@given(st.floats(0.1, 20), st.floats(0.001, 0.5), st.floats(1e-3, 1e3))
def test_units(degrees, fraction, unit):
    """Degrees, and percent of the baseline, whatever the baseline is measured in."""
    rig = RIG.with_extrinsics(np.concatenate([RIG.extrinsics[:3], unit * RIG.extrinsics[3:]]))
    expected = [degrees, degrees, degrees, 100 * fraction, 100 * fraction]
    np.testing.assert_allclose(reading_units(count_box(rig, Reach(degrees, fraction)).chart), expected)


def test_covariance_and_interval():
    box = row_box(RIG, Reach(3.0, 0.03))
    deviation = np.array([0.01, 0.02, 0.03, 0.04, 0.05])
    correlation = np.full((5, 5), 0.3) + 0.7 * np.eye(5)
    known = uncertainty(deviation[:, None] * correlation * deviation, box)
    np.testing.assert_allclose(np.sqrt(np.diag(known.covariance)), 6.0 * deviation)
    np.testing.assert_allclose(known.interval, 1.96 * 6.0 * deviation)
    scale = np.sqrt(np.diag(known.covariance))
    np.testing.assert_allclose(known.covariance / scale / scale[:, None], correlation)
    assert known.observed.all()
    assert known.unobserved == ()


@pytest.mark.parametrize("axis", range(5))
def test_what_is_mostly_prior_is_not_observed(axis):
    box = row_box(RIG, Reach(3.0, 0.03))
    for share, seen in ((0.49, True), (0.51, False), (1.0, False)):
        variance = np.full(5, 0.01**2)
        variance[axis] = (share * PRIOR) ** 2
        known = uncertainty(np.diag(variance), box)
        assert known.observed[axis] == seen
        assert known.unobserved == (() if seen else (FREE_AXES[axis],))
