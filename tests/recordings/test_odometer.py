"""Distances travelled: from speeds and positions, between two times, and what makes no sense."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import stereorecal as sr


@given(st.lists(st.floats(0.0, 30.0), min_size=3, max_size=20), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_ways_add_up(speeds, first, second):
    odometer = sr.Odometer.from_speeds(np.arange(len(speeds)), speeds)
    last = len(speeds) - 1.0
    a, b = sorted([first * last, second * last])
    whole = odometer.between(0.0, last)
    assert whole == pytest.approx(np.trapezoid(speeds))
    assert odometer.between(0.0, a) + odometer.between(a, b) + odometer.between(b, last) == pytest.approx(whole)


def test_positions_are_as_far_apart_as_the_way_between_them():
    odometer = sr.Odometer.from_positions([0.0, 1.0, 2.0], np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 4.0]]))
    assert odometer.between(0.5, 1.5) == pytest.approx(2.5)


def test_the_noise_of_positions_is_no_way():
    """20 a second, off by 5 cm each: the sum of all steps is twice as long."""
    rng, times = np.random.default_rng(0), np.arange(0.0, 20.0, 0.05)
    true = 1.5 * times[:, None] * [0.6, 0.8, 0.0]
    odometer = sr.Odometer.from_positions(times, true + rng.normal(0.0, 0.05, true.shape), noise=0.05)
    off = np.array([odometer.between(first, first + 2.0) - 3.0 for first in np.arange(0.0, 17.0)])
    said = odometer.deviation(3.0)
    assert said == pytest.approx(np.hypot(0.03, 0.05 * 2**0.5))
    assert abs(off.mean()) < 0.03
    assert 0.5 * said < off.std() < 1.2 * said
    assert odometer.deviation(3.0, together=4) == pytest.approx(np.hypot(0.06, 0.05 * 2**0.5))


def test_gaps_have_no_way():
    times = [0.0, 1.0, 2.0, 7.0, 8.0]
    for odometer in (
        sr.Odometer(np.array(times), np.arange(5.0)),
        sr.Odometer.from_positions(times, np.arange(10.0).reshape(5, 2)),
    ):
        assert odometer.between(0.5, 2.0) is not None
        assert odometer.between(7.0, 7.5) is not None
        for first, second in ((1.5, 2.1), (3.0, 4.0), (6.5, 7.0), (0.0, 8.0)):
            assert odometer.between(first, second) is None


@pytest.mark.parametrize("noise", [-0.1, np.nan])
def test_a_noise_that_makes_no_sense(noise):
    with pytest.raises(sr.InputError, match="noise"):
        sr.Odometer.from_positions([0.0, 1.0], np.zeros((2, 2)), noise=noise)


@pytest.mark.parametrize(
    ("positions", "said"), [(np.zeros((3, 2)), "give one each"), (np.array([[0.0, np.nan], [1.0, 0.0]]), "not finite")]
)
def test_positions_that_make_no_sense(positions, said):
    with pytest.raises(sr.InputError, match=f"positions .*{said}"):
        sr.Odometer(np.arange(2.0), np.arange(2.0), positions=positions)
    with pytest.raises(sr.InputError, match=f"positions .*{said}"):
        sr.Odometer.from_positions(np.arange(2.0), positions)


@pytest.mark.parametrize("times", [(-0.1, 1.0), (0.0, 3.1), (2.0, 1.0)])
def test_outside_of_its_times_it_knows_nothing(times):
    assert sr.Odometer(np.arange(4.0), np.arange(4.0)).between(*times) is None


@pytest.mark.parametrize(
    ("times", "metres", "said"),
    [
        ([0.0, 1.0], [0.0, 1.0, 2.0], "as many"),
        ([0.0], [0.0], "two at least"),
        ([0.0, np.nan], [0.0, 1.0], "not finite"),
        ([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], "do not rise, at number 2"),
        ([0.0, 1.0, 2.0], [0.0, 2.0, 1.0], "goes back at number 2"),
    ],
)
def test_what_makes_no_sense_is_named(times, metres, said):
    with pytest.raises(sr.InputError, match=said):
        sr.Odometer(np.array(times), np.array(metres))


@pytest.mark.parametrize(
    ("content", "way"),
    [
        ("time_s,metres\n0,0\n1,2\n", 2.0),
        ("time_s,speed_mps\n0,1\n1,3\n", 2.0),
        ("time_s, x, y\n0,0,0\n\n1,0,-2\n", 2.0),
        ("time_s,x,y,z\n0,0,0,0\n1,0,0,2\n", 2.0),
    ],
)
def test_tables(content, way, tmp_path):
    (tmp_path / "way.csv").write_text(content)
    assert sr.io.load_odometer(tmp_path / "way.csv").between(0.0, 1.0) == pytest.approx(way)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "empty"),
        ("time,metres\n0,0\n", "first line"),
        ("time_s,metres\n0,0\n1\n", "line 3: '' is no number"),
        ("time_s,metres\n0,x\n1,2\n", "line 2: 'x' is no number"),
        ("time_s,metres\n0,1_0\n1,2\n", "line 2: '1_0' is no number"),
        ("time_s,metres\n0,0,0\n1,2\n", "line 2: there are 3 cells under 2 headings"),
        ("time_s,metres\n1,0\n0,1\n", "do not rise"),
        ("time_s,metres\n", "two at least"),
    ],
)
def test_tables_that_make_no_sense(content, said, tmp_path):
    (tmp_path / "way.csv").write_text(content)
    with pytest.raises(sr.InputError, match=said):
        sr.io.load_odometer(tmp_path / "way.csv")
