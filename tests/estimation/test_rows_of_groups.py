"""What a search fits between matches: mean row differences of groups, and how much each counts."""

from dataclasses import replace

import numpy as np
import pytest

from stereorecal.estimation import grouped, normal_of_pair, rig_parameters, rows_of_groups
from stereorecal.objectives import Reach, linear_residuals, row_chart


@pytest.fixture
def box(rig):
    return row_chart(rig, Reach())


def solved(found, box, at, times=3):
    groups = grouped(found, box, at)
    for _ in range(times):
        at = linear_residuals(at, *rows_of_groups(groups, box, at), 1e3).least
    return at


@pytest.mark.parametrize("degrees", [0.0, 0.1, 1.0])
def test_the_rig_that_saw_is_found_again(rig, box, seen, degrees):
    """Yaw and z, which rows hardly tell, less surely."""
    truth = degrees / 3.0 * np.array([0.4, -0.3, 0.5, 0.2, -0.2])
    found = seen(rig, box.rig_at(truth), noise=0.02)
    end = solved(found, box, np.zeros(5))
    np.testing.assert_allclose(end[[0, 2]], truth[[0, 2]], atol=2e-3)
    np.testing.assert_allclose(end, truth, atol=0.05)


def test_of_nothing_there_is_nothing(rig, box, seen):
    found = seen(rig, rig)
    nothing = replace(found, weight=0.0 * np.asarray(found.weight))
    assert len(grouped(nothing, box, np.zeros(5))) == 0
    chart = rig_parameters(rig)
    assert normal_of_pair(nothing, chart, *looked(chart)) is None


def looked(chart, mean=None):
    """Where a look is linear, and what is known before it: any drift, and lenses as given."""
    drift = np.arange(chart.dim) < 5
    return np.zeros(chart.dim), np.zeros(chart.dim) if mean is None else mean, np.diag(drift.astype(float))


@pytest.mark.parametrize("moved", [0.0, 3.0])
@pytest.mark.parametrize("degrees", [0.0, 0.1])
def test_what_a_pair_says_is_the_rig_that_saw(rig, seen, degrees, moved):
    """Also where a tenth of the view has moved by three pixels between the shutters: it has no say."""
    chart, truth = rig_parameters(rig), np.zeros(rig_parameters(rig).dim)
    truth[:5] = degrees * np.array([0.4, -0.3, 0.5, 2.0, -2.0])
    found = seen(rig, chart.rig_at(truth), noise=0.02)
    right = np.array(found.right)
    right[..., 1] += moved / float(found.focal) * (np.asarray(found.left)[..., :2] > [0.2, 0.1]).all(axis=-1)
    normal, solved = normal_of_pair(replace(found, right=right), chart, *looked(chart))
    np.testing.assert_allclose(solved[[0, 2]], truth[[0, 2]], atol=0.004)
    np.testing.assert_allclose(solved[5:], 0.0, atol=1e-12)
    of_drift, pull = normal.a[:5, :5] + np.eye(5), normal.b[:5]
    np.testing.assert_allclose(np.linalg.solve(of_drift, pull), solved[:5], atol=2e-3)


def test_a_pair_says_the_same_wherever_it_is_looked_at_from(rig, seen):
    """Rows are linear, and what is known counts from the given rig."""
    chart, (at, mean, covariance) = rig_parameters(rig), looked(rig_parameters(rig))
    found = seen(rig, rig, noise=0.02)
    elsewhere = at + 0.05 * (np.arange(chart.dim) < 3)
    (one, here), (other, there) = (normal_of_pair(found, chart, start, mean, covariance) for start in (at, elsewhere))
    np.testing.assert_allclose(here[:3], there[:3], atol=2e-3)
    np.testing.assert_allclose(np.diag(one.a)[:5], np.diag(other.a)[:5], rtol=0.05)
