"""Estimates of rigs that are known: right within their intervals, whatever the order, the unit and the view."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.estimation import estimate

DRIFT = np.array([0.3, 0.2, -0.4, 0.2, -0.3])
COVERED = 3.5  # standard deviations
angles = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)


def at(chart, drift=DRIFT) -> np.ndarray:
    return np.r_[drift, np.zeros(chart.dim - len(drift))]


def sigmas(found) -> np.ndarray:
    """Standard deviations of all parameters; those that are held have none and are not compared."""
    return np.maximum(np.sqrt(np.diag(found.posterior.covariance)), 1e-9)


def width(found) -> float:
    """The width of the interval of depth at 30 baselines."""
    _, low, high = found.depth_error_percent(np.zeros(len(found.theta)))[30]
    return high - low


def frames_of(found, order):
    return replace(found, **{name: getattr(found, name)[order] for name in ("left", "right", "weight", "tile")})


@settings(max_examples=max(4, settings.default.max_examples // 12))
@given(drift=angles, seed=st.integers(0, 99))
def test_exact_intrinsics_give_the_rotation_back(rig, chart, seen, drift, seed):
    truth = at(chart, np.r_[drift, 0, 0])
    found = estimate(seen(rig, chart.rig_at(truth), seed), rig, "exact")
    off = np.abs(found.theta - truth)
    assert (off[:3] < COVERED * sigmas(found)[:3] + 1e-3).all()
    assert (sigmas(found)[[0, 2]] < 0.005).all()
    assert sigmas(found)[1] < 0.05
    assert not found.theta[5:].any()


def test_its_intervals_hold_the_truth_nearly_always(rig, chart, seen):
    inside = []
    for seed in range(10):
        truth = at(chart, np.random.default_rng(seed).uniform(-0.5, 0.5, 3))
        low, high = estimate(seen(rig, chart.rig_at(truth), seed, cells=800), rig, "exact").intervals[:3].T
        inside.append((low <= truth[:3]) & (truth[:3] <= high))
    assert 0.85 <= np.mean(inside) <= 1.0


def test_rows_say_nothing_of_the_length_of_the_baseline(rig, chart, prior, seen):
    found = estimate(seen(rig, chart.rig_at(at(chart))), rig, prior)
    here = chart.names.index("baseline")
    assert abs(found.theta[here]) < 0.3 * sigmas(found)[here]
    assert sigmas(found)[here] >= 0.14


# --- what must not matter -------------------------------------------------------------------------------------


def test_nor_does_the_order_of_frames_or_correspondences_matter(rig, chart, prior, seen):
    found = seen(rig, chart.rig_at(at(chart)), frames=2, cells=800)
    mixed = np.random.default_rng(0).permutation(800)
    cells = replace(found, **{name: getattr(found, name)[:, mixed] for name in ("left", "right", "weight", "tile")})
    expected = estimate(found, rig, prior)
    for other in (cells, frames_of(found, [1, 0])):
        again = estimate(other, rig, prior)
        np.testing.assert_allclose((again.theta - expected.theta) / sigmas(expected), 0.0, atol=1e-6)
        np.testing.assert_allclose(sigmas(again), sigmas(expected), rtol=1e-6)


@pytest.mark.parametrize("said", ["default", "exact"])
def test_nor_does_the_unit_of_the_baseline(rig, chart, seen, said):
    long = rig.with_extrinsics(rig.extrinsics * [1, 1, 1, 1e3, 1e3, 1e3])
    found = seen(rig, chart.rig_at(at(chart)))
    metres, millimetres = estimate(found, rig, said), estimate(found, long, said)
    np.testing.assert_allclose((millimetres.theta - metres.theta) / sigmas(metres), 0.0, atol=1e-5)
    np.testing.assert_allclose(sigmas(millimetres), sigmas(metres), rtol=1e-5)
    for used in (metres, millimetres):
        assert width(used) == pytest.approx(width(metres), rel=1e-4)


def test_the_scene_upside_down(rig, chart, seen):
    """What turns about x and z changes its sign."""
    flip = np.array([1.0, -1.0, 1.0])

    def mirrored(camera):
        centre = np.array([[0, 0, 0], [0, 0, 480 - 2 * camera.matrix[1, 2]], [0, 0, 0]])
        return sr.Camera(camera.size, camera.matrix + centre, camera.distortion * [1, 1, -1, 1])

    there = sr.StereoRig(mirrored(rig.left), mirrored(rig.right), rig.extrinsics * [-1, 1, -1, 1, -1, 1])
    np.testing.assert_allclose(there.rotation, np.diag(flip) @ rig.rotation @ np.diag(flip), atol=1e-12)
    found = seen(rig, chart.rig_at(at(chart)))
    turned = replace(found, left=found.left * flip.astype(np.float32), right=found.right * flip.astype(np.float32))
    one, other = estimate(found, rig, "exact"), estimate(turned, there, "exact")
    expected = one.theta[:5] * [-1, 1, -1, -1, 1]
    np.testing.assert_allclose((other.theta[:5] - expected) / sigmas(one)[:5], 0.0, atol=1e-3)


@pytest.mark.parametrize(("said", "times"), [("default", 2), ("exact", 2), ("exact", 4)])
def test_the_same_images_again_are_no_news(rig, chart, seen, said, times):
    found = seen(rig, chart.rig_at(at(chart)))
    once, again = (estimate(frames_of(found, [0] * number), rig, said) for number in (1, times))
    assert width(again) == pytest.approx(width(once), rel=0.01)
    assert (np.abs(again.theta - once.theta) < 0.1 * sigmas(once)).all()


# --- what is no parameter of the rig --------------------------------------------------------------------------


@pytest.mark.parametrize("said", ["default", "exact"])
def test_a_region_that_moved_turns_no_rig(rig, chart, seen, said):
    """A third of the image, by half a row."""
    found = seen(rig, chart.rig_at(at(chart)), cells=2500)
    right = np.array(found.right)
    right[..., 1] += np.float32(0.5 / 500) * (found.left[..., 0] < -0.2)
    clean, spoiled = (estimate(each, rig, said) for each in (found, replace(found, right=right)))
    assert clean.misfit[0] <= 0.02
    assert (sigmas(spoiled)[:3] > 0.95 * sigmas(clean)[:3]).all()
    assert (np.abs(spoiled.theta - at(chart))[:3] < COVERED * sigmas(spoiled)[:3]).all()


def test_waves_of_rows_are_a_misfit_and_make_it_less_sure(rig, chart, seen):
    """No region and no parameter of a rig."""
    found = seen(rig, chart.rig_at(at(chart)), cells=2500)
    right, left = np.array(found.right), found.left
    right[..., 1] += (0.3 / 500 * np.sin(9 * left[..., 0]) * np.cos(8 * left[..., 1])).astype(np.float32)
    clean, spoiled = (estimate(each, rig, "exact") for each in (found, replace(found, right=right)))
    assert spoiled.misfit[0] >= 0.07
    assert (sigmas(spoiled)[:3] > 1.5 * sigmas(clean)[:3]).all()
    assert (np.abs(spoiled.theta - at(chart))[:3] < COVERED * sigmas(spoiled)[:3]).all()


# --- what it says of rigs -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found(rig, chart, prior, seen):
    return estimate(seen(rig, chart.rig_at(at(chart))), rig, prior)


@pytest.mark.parametrize("cells", [0, 20])
def test_too_few_correspondences_leave_what_was_known(rig, seen, cells):
    """None, and none that make a group."""
    found = seen(rig, rig)
    nearly = estimate(replace(found, weight=found.weight * (np.arange(1200) < cells)), rig, "exact")
    assert nearly.groups == 0
    assert np.abs(nearly.theta).max() < 1e-9


def test_a_rig_that_reads_beyond_infinity_says_so(rig, chart, seen):
    """Three pixels of disparity are all there is at 160 baselines; a yaw of two degrees takes seventeen."""
    inward = {sign: estimate(seen(rig, chart.rig_at(at(chart, [0, sign * 2.0, 0]))), rig, "exact") for sign in (1, -1)}
    errors = {sign: found.depth_error_percent(np.zeros(chart.dim))[100] for sign, found in inward.items()}
    assert sorted(np.isinf(np.array([errors[1][0], errors[-1][0]]))) == [False, True]
    (infinite,) = (error for error in errors.values() if np.isinf(error[0]))
    assert infinite[2] == np.inf


def test_it_travels_lightly_and_says_the_same_there(chart, found):
    """With its prior and its rows, for parts that are left out there."""
    expected = (found.intervals, found.with_free(chart.names[:5]), found.depth_error_percent(found.theta))
    sent = pickle.dumps(found)
    assert len(sent) < 700_000
    there = pickle.loads(sent)
    np.testing.assert_array_equal(there.intervals, expected[0])
    np.testing.assert_allclose(there.with_free(chart.names[:5]), expected[1])
    np.testing.assert_allclose(list(there.depth_error_percent(there.theta).values()), list(expected[2].values()))


@pytest.mark.parametrize("drift", [(1.5, 0.0, 0.0, 0.5, -1.0), (-2.5, 1.0, 2.0, 1.0, 2.0)])
def test_it_has_settled_where_it_ends(rig, chart, prior, seen, drift):
    """Begun again where it ended it stays: within what other groups do, also where rows bend along a drift."""
    found = seen(rig, chart.rig_at(at(chart, np.array(drift))), 3)
    once = estimate(found, rig, prior)
    again = estimate(found, rig, prior, once.theta)
    assert (np.abs(again.theta - once.theta) < 0.3 * sigmas(once)).all()
    np.testing.assert_allclose(sigmas(again), sigmas(once), rtol=0.1)
