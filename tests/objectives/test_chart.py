"""The chart: unit box to extrinsics and back; x stays."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import InputError
from stereorecal.geometry import AXES
from stereorecal.objectives import Parameters, Reach, count_chart
from stereorecal.synthetic import default_rig

RIG = default_rig()
points = st.lists(st.floats(-1, 1), min_size=5, max_size=5).map(np.array)
reaches = st.builds(Reach, degrees=st.floats(0.01, 20), baseline_fraction=st.floats(1e-4, 0.5))


@given(z=points, reach=reaches)
def test_round_trip(z, reach):
    chart = count_chart(RIG, reach)
    extrinsics = chart.extrinsics(z)
    assert extrinsics.dtype == np.float64
    np.testing.assert_allclose(chart.coordinates(extrinsics), z, atol=1e-9)


def test_centre_and_corner():
    chart = count_chart(RIG, Reach(2.0, 0.01))
    assert np.array_equal(chart.extrinsics(np.zeros(5)), RIG.extrinsics)
    change, shift = chart.extrinsics(np.ones(5)) - RIG.extrinsics, 0.01 * RIG.baseline
    np.testing.assert_allclose(change, [*[np.radians(2.0)] * 3, 0.0, shift, shift], rtol=1e-9)


def test_many_points():
    chart = count_chart(RIG, Reach())
    z = np.random.default_rng(0).uniform(-1, 1, (7, 5))
    np.testing.assert_allclose(chart.extrinsics(z), np.stack([chart.extrinsics(p) for p in z]), rtol=1e-12, atol=1e-15)


def test_other_free_axes():
    chart = count_chart(RIG, Reach(), Parameters(("roll", "y")))
    assert chart.dim == 2
    moved = chart.extrinsics(np.ones(2)) - RIG.extrinsics
    assert [axis for axis, change in zip(AXES, moved, strict=True) if change] == ["roll", "y"]


def test_a_prior_is_a_third_of_its_axis():
    chart = count_chart(RIG, Reach(3.0, 0.03), Parameters(priors={"yaw": 0.5}))
    moved = chart.extrinsics(np.ones(5)) - RIG.extrinsics
    np.testing.assert_allclose(np.degrees(moved[:3]), [3.0, 1.5, 3.0])


@pytest.mark.parametrize("values", [(0, 0.03), (3, -0.1), (21, 0.03), (3, 0.6), (np.nan, 0.1), (3, np.nan)])
def test_reaches_that_make_no_sense(values):
    with pytest.raises(InputError, match=r"a reach of .* makes no sense"):
        Reach(*values)
