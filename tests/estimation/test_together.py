"""Several recordings of the same cameras: they agree about intrinsics, and each keeps a drift of its own."""

from dataclasses import replace
from functools import reduce
from operator import add

import numpy as np
import pytest

from stereorecal.estimation import (
    Estimate,
    Recording,
    agreement,
    beside_others,
    estimate,
    fitted,
    fitted_together,
    most_probable,
)

DRIFTS = np.array([[0.3, 0.2, -0.4, 0.2, -0.3], [-0.2, 0.1, 0.3, 0.0, 0.2], [0.0, 0.0, 0.0, 0.0, 0.0]])


@pytest.fixture(scope="module")
def truths(chart, prior) -> np.ndarray:
    """The same calibration's error, and drifts."""
    left = prior.roots[1] @ np.random.default_rng(3).normal(size=chart.dim)
    return left + np.pad(DRIFTS, ((0, 0), (0, chart.dim - 5)))


@pytest.fixture(scope="module")
def recordings(rig, chart, seen, truths, prior) -> list[Recording]:
    return [
        Recording(seen(rig, chart.rig_at(theta), index, cells=700), rig, prior, np.zeros(chart.dim))
        for index, theta in enumerate(truths)
    ]


def estimates(recordings: list[Recording]) -> list[Estimate]:
    """As repairs have them: fitted to say where to match, and, matched again, weighed."""
    fits = fitted_together([fitted(one) for one in recordings])
    return [fit.weighed() for fit in fitted_together([most_probable(one) for one in beside_others(recordings, fits)])]


@pytest.fixture(scope="module")
def together(recordings):
    return estimates(recordings)


def sigmas(one) -> np.ndarray:
    return np.sqrt(np.diag(one.posterior.covariance))


def test_each_has_its_own_drift_and_what_is_common_is_better_known(recordings, together, prior, truths):
    alone = [estimate(one.found, one.rig, prior) for one in recordings]
    for one, truth, single in zip(together, truths, alone, strict=True):
        assert (np.abs(one.theta - truth) < 3.5 * sigmas(one)).all()
        np.testing.assert_allclose(one.theta[2], truth[2], atol=0.03)  # roll, which rows tell
        assert np.median(sigmas(one)[6:] / sigmas(single)[6:]) < 0.97


def test_their_order_does_not_matter(recordings, together):
    again = estimates(recordings[::-1])[::-1]
    for one, other in zip(together, again, strict=True):
        assert (np.abs(one.theta - other.theta) < 0.02 * sigmas(one)).all()  # where all agree


def test_they_have_settled(recordings, together):
    """What the others show moves none of them any more: a step to another θ changes what each shows."""
    fits = fitted_together([most_probable(one) for one in recordings])
    for index, (fit, one) in enumerate(zip(fits, together, strict=True)):
        others = reduce(add, [other.told for other in fits[:index] + fits[index + 1 :]])
        assert (np.abs(fit.beside(others).best.theta - fit.best.theta) < 0.05 * sigmas(one)).all()
    alone = [fitted(one) for one in recordings]
    assert any(
        (np.abs(fit.best.theta - one.best.theta) > sigmas(two)).any()
        for fit, one, two in zip(fits, alone, together, strict=True)
    )


def test_what_moved_in_one_recording_tells_others_nothing(recordings):
    """A third of its view, by a pixel: it knows that, and says as much of the calibration as if nothing had moved."""
    found = recordings[0].found
    moved = np.array(found.right)
    moved[..., 1] += np.where(np.asarray(found.left)[..., 0] < -0.25, 1.0 / 500.0, 0.0)
    with_region = replace(recordings[0], found=replace(found, right=moved))
    before, after = (estimates([first, *recordings[1:]])[1] for first in (recordings[0], with_region))
    assert (np.abs(after.theta - before.theta) < 0.7 * sigmas(before)).all()
    assert np.median(sigmas(after)[6:] / sigmas(before)[6:]) < 1.15


def test_one_in_which_nothing_matches_says_nothing(recordings):
    """It knows what the others tell of the calibration, and they know no more by it."""
    empty = replace(recordings[0], found=replace(recordings[0].found, weight=np.zeros_like(recordings[0].found.weight)))
    others, (*same, blind) = estimates(recordings[1:]), estimates([*recordings[1:], empty])
    for one, other in zip(others, same, strict=True):
        assert (np.abs(one.theta - other.theta) < 0.05 * sigmas(one)).all()
        np.testing.assert_allclose(sigmas(one), sigmas(other), rtol=0.02)
    alone = fitted(empty).weighed()
    assert np.median(sigmas(blind)[6:] / sigmas(alone)[6:]) < 0.9
    assert (sigmas(blind)[6:] ** 2 < 1.01 * blind.prior_variance[6:]).all()


def test_whether_they_are_of_one_calibration(recordings, rig, chart, seen, prior):
    """One error of the intrinsics is more probable than several; with that of another rig, far less."""

    def together(several: list[Recording]) -> np.ndarray:
        alone = [fitted(one) for one in several]
        return agreement(alone, fitted_together(alone))

    assert together(recordings).min() > 2.0
    off = {"left.f": 0.5, "left.k1": 0.02, "right.cy": 2.0, "right.k1": -0.02}  # percent, pixels
    other = np.array([off.get(name, 0.0) for name in chart.names])
    stranger = Recording(seen(rig, chart.rig_at(other), 7, cells=700), rig, prior, np.zeros(chart.dim))
    likelier = together([*recordings, stranger])
    assert likelier.argmin() == len(recordings)
    assert likelier[-1] < -12.0
