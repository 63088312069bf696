"""The rigs that may be written lose least by the very loss by which they are judged; one of them keeps depth."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.estimation import Estimate, estimate, points_of_view, readings, with_free_together
from stereorecal.objectives import EXTRINSICS

DRIFT = (0.2, 0.15, -0.3, 0.2, -0.3)


def free_of(chart, kind: str) -> list[str]:
    """Some of the extrinsics, all, with one lens, or everything."""
    names = {"some": EXTRINSICS[:3], "extrinsics": EXTRINSICS, "everything": chart.names}
    return list(names.get(kind, (*EXTRINSICS, *(name for name in chart.names if name.startswith("right.")))))


KINDS = ("some", "extrinsics", "lens", "everything")


@pytest.fixture(scope="module")
def several(rig, chart, prior, seen) -> list[Estimate]:
    """Estimates of rigs that a calibration left, with a drift."""

    def make(seed: int) -> Estimate:
        left = prior.roots[1] @ np.random.default_rng(seed).normal(size=chart.dim)
        true = chart.rig_at(left + np.r_[np.array(DRIFT) * (1 - 0.4 * seed), np.zeros(chart.dim - 5)])
        return estimate(seen(rig, true, seed, cells=800), rig)

    return [make(seed) for seed in range(3)]


@settings(max_examples=15)
@given(at=st.integers(0, 2), kind=st.sampled_from(KINDS), seed=st.integers(0, 999), size=st.floats(-3, 0))
def test_no_step_loses_less(several, chart, at, kind, seed, size):
    """Each squared standard deviation from the mean costs a hundredth, so that what costs no loss stays likely."""
    found, names = several[at], free_of(chart, kind)
    mean, covariance = found.posterior.mean, found.posterior.covariance
    least, free = found.with_free(names), np.isin(chart.names, names)

    def cost(theta: np.ndarray) -> float:
        away = theta - mean
        return found.expected_loss(theta) + 0.01 * float(away @ np.linalg.solve(covariance, away))

    assert cost(least) <= min(map(cost, (np.where(free, mean, 0.0), np.zeros(chart.dim)))) + 0.01
    step = 10.0**size * np.sqrt(np.diag(covariance)) * free * np.random.default_rng(seed).normal(size=chart.dim)
    assert cost(least + step) > cost(least) - 0.01


@pytest.mark.parametrize("kind", KINDS[:3])
def test_it_loses_less_than_the_mean_whose_other_parameters_are_held(several, chart, kind):
    """What is held is made up for, as far as that goes; and more freedom loses no more."""
    names = free_of(chart, kind)
    for found in several:
        least, mean = found.with_free(names), np.where(np.isin(chart.names, names), found.theta, 0.0)
        assert not least[~np.isin(chart.names, names)].any()
        assert found.expected_loss(least) < 0.95 * found.expected_loss(mean)
        more = found.with_free(free_of(chart, KINDS[KINDS.index(kind) + 1]))
        assert found.expected_loss(more) < found.expected_loss(least) + 0.01


@pytest.mark.parametrize("kind", KINDS)
def test_the_one_that_keeps_depth_changes_it_less_and_aligns_rows_all_the_same(several, rig, chart, kind):
    changed = []
    for found in several:
        both = [found.with_free(free_of(chart, kind), keep_depth=keep) for keep in (True, False)]
        rigs = [chart.rig_at(theta) for theta in both]
        kept, least = ([np.abs(readings(one, rig, points_of_view(rig, d))[1]).mean() for d in (5, 30)] for one in rigs)
        assert (np.array(kept) < np.array(least)).all()
        changed.append(kept[1] / least[1])
        rows = [np.mean(found.losses(theta).even) for theta in (*both, np.zeros(chart.dim))]
        assert rows[0] < 0.5 * rows[2]
        assert found.expected_loss(both[0]) >= found.expected_loss(both[1]) - 0.01
    assert np.median(changed) < 0.7


def test_several_lose_least_together(several, chart):
    """What is shared is the same for all, and no other value of it loses less in total."""
    names = (*EXTRINSICS[:3], "left.f", "right.cx")
    thetas = with_free_together(several, names)
    for theta in thetas:
        np.testing.assert_allclose(theta[6:], thetas[0][6:], rtol=1e-9)
        assert not theta[~np.isin(chart.names, names)].any()

    def total(step: np.ndarray) -> float:
        return sum(one.expected_loss(theta + step) for one, theta in zip(several, thetas, strict=True))

    for name in ("left.f", "right.cx"):
        for step in (0.3, -0.3):
            assert total(step * np.eye(chart.dim)[chart.names.index(name)]) > total(np.zeros(chart.dim)) - 0.02
    (alone,) = with_free_together(several[:1], names)
    np.testing.assert_allclose(alone, replace(several[0]).with_free(names), atol=1e-9)
