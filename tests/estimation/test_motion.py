"""The rig's own motion in the estimate: it tells depth, and where it tells nothing, nothing is made of it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from parts_of_estimates import Motion, by_theta, residuals, track_readings
from simulated_tracks import AHEAD, REST, SIDEWAYS, rolling_tracks, tracks_of

import stereorecal as sr
from stereorecal.estimation import (
    Windows,
    as_prior,
    estimate,
    points_of_view,
    readings,
    rig_parameters,
    window,
    with_scaled_boards,
)
from stereorecal.geometry import rotation_from_vector
from stereorecal.scoring import Tracks

DRIFT = (0.2, 0.5, -0.3, 0.2, -0.3)


def drifted(chart, drift=DRIFT) -> sr.StereoRig:
    return chart.rig_at(np.r_[drift, np.zeros(chart.dim - 5)])


def windows(true, number=3, seed=0, **options) -> Windows:
    return Windows(tuple(tracks_of(true, seed=100 * seed + index, **options) for index in range(number)))


def offset(used, true) -> float:
    """Percent of disparity at 30 baselines."""
    return 100.0 * float(readings(used, true, points_of_view(true, 30))[1].mean())


def stated(seen) -> tuple[float, float]:
    """The interval of that."""
    _, *ends = seen.depth_error_percent(seen.theta)[30]
    low, high = (100.0 * (1.0 / (1.0 + end / 100.0) - 1.0) for end in reversed(ends))
    return low, high


def held(seen, true) -> bool:
    low, high = stated(seen)
    return low <= offset(seen.chart.rig_at(seen.theta), true) <= high


def slanted(rays) -> np.ndarray:
    """Inverse depths in 1 / baselines."""
    return 0.1 + 0.05 * rays[:, 0] - 0.08 * rays[:, 1]


@pytest.mark.parametrize("readout", [0.0, 0.4], ids=["all at once", "rolling"])
def test_slopes_are_those_of_the_residuals(chart, steps, readout):
    theta = np.random.default_rng(0).normal(size=chart.dim) * 10 * steps
    true = chart.rig_at(theta)
    turn, move = np.array([0.01, -0.02, 0.005]), np.zeros(3) if readout else np.array([0.1, 0.2, -1.0])
    tracks = tracks_of(true, move, turn, number=60, noise=0.0, nearness=slanted)
    tracks = rolling_tracks(true, readout, move, turn, number=60, noise=0.0) if readout else tracks
    near = slanted(np.asarray(true.left.rays(tracks.left[0]))) / float(true.baseline) * (not readout)
    motion = Motion(np.asarray(rotation_from_vector(turn), float), move * float(true.baseline))

    def at(theta, motion=motion, near=near):
        rig = chart.rig_at(theta)
        return residuals(track_readings(tracks, rig), rig, motion, near)

    def check(exact, ends, step):
        found = (ends[0].value - ends[1].value) / (2.0 * step)
        np.testing.assert_allclose(exact, found, atol=1e-4 * np.abs(found).max() + 1e-5)

    for _ in range(3 * bool(readout)):  # how near things are, which turn alone
        start = at(theta, near=near)
        near = near - start.value[:, 0] / start.by_nearness[:, 0]
    here = at(theta, near=near)
    np.testing.assert_allclose(here.value, 0.0, atol=1e-4 if readout else 1e-6)
    _, exact = by_theta(track_readings(tracks, true), chart, theta, motion, near)
    for index, step in enumerate(np.diag(steps)):
        check(exact[..., index], [at(theta + sign * step, near=near) for sign in (1, -1)], steps[index])
    for index, step in enumerate(1e-6 * np.eye(6) if not readout else ()):
        turned = [np.asarray(rotation_from_vector(sign * step[:3]), float) @ motion.rotation for sign in (1, -1)]
        ends = [Motion(t, motion.translation + s * step[3:]) for t, s in zip(turned, (1, -1), strict=True)]
        check(here.by_motion[..., index], [at(theta, end, near) for end in ends], 1e-6)
    check(here.by_nearness, [at(theta, near=near + sign * 1e-6) for sign in (1, -1)], 1e-6)


@settings(max_examples=max(4, settings.default.max_examples // 12))
@given(seed=st.integers(0, 999), yaw=st.floats(-1, 1))
def test_exact_tracks_pull_nowhere(chart, seed, yaw):
    theta = np.eye(chart.dim)[1] * yaw
    seen = window(tracks_of(chart.rig_at(theta), seed=seed, noise=0.0), chart, theta)
    scale = np.sqrt(np.diag(seen.normal.a)) + 1e-9
    np.testing.assert_allclose((seen.normal.a @ theta - seen.normal.b) / scale, 0.0, atol=0.02)
    assert np.linalg.eigvalsh(seen.normal.a / scale / scale[:, None]).min() > -1e-6


@pytest.mark.slow(after=3)
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"with_rig": 0.5},
        {"move": REST, "turn": (0.0, 0.03, 0.0)},
        {"move": SIDEWAYS},
        {"move": REST},
        {"nearness": lambda rays: np.full(len(rays), 0.1)},
    ],
    ids=["ahead", "half of what is near moves along", "turning", "sideways", "at rest", "a wall"],
)
def test_intervals_hold_the_truth(rig, chart, prior, seen, options):
    true = drifted(chart)
    holds = [
        held(
            estimate(seen(rig, true, seed, frames=2, cells=250), rig, prior, windows=windows(true, 2, seed, **options)),
            true,
        )
        for seed in range(3)
    ]
    assert sum(holds) >= 2


@pytest.mark.parametrize("move", [AHEAD, SIDEWAYS, (0.0, 0.0, -0.3)], ids=["ahead", "sideways", "slowly"])
def test_a_way_tells_depth_beside_a_turn(chart, move):
    told = window(tracks_of(drifted(chart), move=move, turn=(0.0, 0.03, 0.0)), chart, np.zeros(chart.dim))
    both = [chart.names.index("yaw"), chart.names.index("right.cx")]
    assert np.linalg.eigvalsh(told.normal.a[np.ix_(both, both)])[0] > 0.0


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.03, 0.0)], ids=["rest", "turning"])
def test_windows_without_parallax_change_nothing(rig, chart, prior, seen, turn):
    """And are counted; how points turn tells of lenses, which err by as much as a depth that is wrong."""
    true = drifted(chart)
    found = seen(rig, true, frames=2, cells=250)
    turning = windows(true, 2, move=REST, turn=turn)
    alone, beside = (estimate(found, rig, prior, windows=some) for some in (Windows(), turning))
    np.testing.assert_allclose(beside.theta, alone.theta, atol=1e-6)
    np.testing.assert_allclose(beside.posterior.covariance, alone.posterior.covariance, atol=1e-9)
    assert [one.informative for one in beside.motions] == [False, False]
    assert max(one.metres[0] for one in beside.motions) < 0.1 * float(rig.baseline)


@settings(max_examples=max(4, settings.default.max_examples // 15))
@given(times=st.floats(0.1, 30.0), seed=st.integers(0, 99))
def test_a_larger_scene_and_rig_are_the_same(rig, times, seed):
    """The unit of length does not matter."""
    other = sr.StereoRig(rig.left, rig.right, np.asarray(rig.extrinsics) * np.r_[np.ones(3), np.full(3, times)])
    tracks = tracks_of(rig, seed=seed)
    charts = [rig_parameters(one) for one in (rig, other)]
    one, two = (window(tracks, chart, np.zeros(chart.dim)) for chart in charts)
    scale = np.sqrt(np.diag(one.normal.a)) + 1e-9
    np.testing.assert_allclose(one.normal.b / scale, two.normal.b / scale, atol=1e-2)
    assert two.metres[0] == pytest.approx(times * one.metres[0], rel=1e-5)


def fisheye_chart(field: float):
    size = (320, 240)
    focal = 0.5 * size[0] / np.radians(0.5 * field)
    camera = sr.Camera(size, np.array([[focal, 0, 160], [0, focal, 120], [0, 0, 1]]), np.zeros(4), model="equidistant")
    return rig_parameters(sr.StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.3, 0.0, 0.0])))


def test_tracks_beyond_the_rays_of_a_wide_lens_are_left_out():
    """90 degrees off the axis a ray (x/z, y/z, 1) is NaN, and one of them made the window NaN."""
    chart = fisheye_chart(200.0)
    rig = chart.rig_at(np.zeros(chart.dim))
    seen = tracks_of(rig, number=900, noise=0.05)
    aside = np.array([[1.0, 120.0]])
    assert np.isnan(rig.left.rays(aside)).any()
    both = Tracks(
        *(np.concatenate([part, np.broadcast_to(aside, (2, 1, 2))], axis=1) for part in (seen.left, seen.right))
    )
    alone, told = (window(tracks, chart, np.zeros(chart.dim)) for tracks in (seen, both))
    assert told.motion is not None
    assert told.tracks == alone.tracks
    np.testing.assert_array_equal(told.normal.a, alone.normal.a)


def ways(true, share=1.0, sigma=0.01, number=8) -> tuple[tuple[float, float], ...]:
    metres = share * float(true.baseline) * float(np.linalg.norm(AHEAD))
    return ((metres, sigma * number**0.5 * metres),) * number


@pytest.mark.parametrize(("share", "heard"), [(1.0, True), (3.6, False)])
def test_a_known_way_tells_the_length_of_the_baseline(chart, share, heard):
    """As ranges do; in kilometres an hour for metres a second it is of something else."""
    true = chart.rig_at(np.zeros(chart.dim))
    longer = true.extrinsics.copy()
    longer[3:] *= 1.05
    given = rig_parameters(true.with_extrinsics(longer))
    tracks = windows(true, 8).tracks
    prior = with_scaled_boards(as_prior(None, given), given)
    told = Windows(tracks, ((0, 1),) * 8, (1.0,) * 8, ways(true, share)).likelihoods(given, np.zeros(given.dim), prior)
    alone = Windows(tracks, ((0, 1),) * 8, (1.0,) * 8).likelihoods(given, np.zeros(given.dim), prior)
    (log, best), (other, without) = told[0], told[1]
    at = given.names.index("baseline")
    drift = np.diag(np.r_[np.ones(5), np.zeros(given.dim - 5)])
    widest = prior.roots[np.linalg.norm(prior.roots[:, at], axis=1).argmax()]
    before = np.linalg.inv(widest @ widest.T + drift + 1e-12 * np.eye(given.dim))

    def evidence(normal, log):
        inner = normal.a + before
        mean = np.linalg.solve(inner, normal.b)
        return log - 0.5 * (normal.c - normal.b @ mean + np.linalg.slogdet(inner)[1]), mean[at]

    (with_ways, length), (ignored, _) = evidence(best, log), evidence(without, other)
    assert bool(with_ways > ignored) is heard
    if heard:
        assert length == pytest.approx(-100.0 * (1.0 - 1.0 / 1.05), abs=1.0)
    np.testing.assert_array_equal(without.a, alone[0][1].a)


def test_ways_of_a_vehicle_that_stands_are_left_out(chart):
    """Beside one that tells, and where none does."""
    theta, frames, seconds = np.zeros(chart.dim), ((0, 1),) * 2, (1.0,) * 2
    true = chart.rig_at(theta)
    tracks, prior = (
        (tracks_of(true), tracks_of(true, move=REST, seed=1)),
        with_scaled_boards(as_prior(None, chart), chart),
    )
    (moving, *_), baseline = ways(true), float(true.baseline)
    alone = Windows(tracks, frames, seconds).likelihoods(chart, theta, prior)
    for still in ((0.0, 0.001), (0.09 * baseline, 0.001)):
        none = Windows(tracks, frames, seconds, (still, still)).likelihoods(chart, theta, prior)
        assert [log for log, _ in none] == [log for log, _ in alone]
        told, expected = (
            Windows(tracks, frames, seconds, (moving, way)).likelihoods(chart, theta, prior) for way in (still, None)
        )
        assert [log for log, _ in told] == [log for log, _ in expected]
        np.testing.assert_array_equal(told[0][1].a, expected[0][1].a)


def test_rolling_shutters_whose_readout_is_known(rig, chart):
    """While a third of the time between two pairs passes from the first row to the last: as if all came at once."""
    tracks = rolling_tracks(rig, 0.3, noise=0.0)
    known, unknown = (window(one, chart, np.zeros(chart.dim)) for one in (tracks, replace(tracks, readout=0.0)))
    metres, yaw = float(np.linalg.norm(AHEAD)) * float(rig.baseline), chart.names.index("yaw")
    errors = [abs(seen.metres[0] / metres - 1.0) for seen in (known, unknown)]
    assert errors[0] < 2e-3
    assert errors[1] > 5e-3
    assert abs(known.normal.b[yaw] / known.normal.a[yaw, yaw]) < 2e-3


@pytest.mark.parametrize("own", [(1.5, 0.0, 0.0), (-1.5, 0.0, 0.0), (2.0, 0.0, 0.5)])
@pytest.mark.parametrize("seed", range(2))
def test_a_boat_that_fills_a_third_of_the_view_does_not_draw_the_motion_to_its_own(rig, chart, own, seed):
    """From rest, while the rig turns by more than it moves, one ends between the boat and all that stands still."""
    move, turn, rng = np.array([0.0, 0.0, -0.6]), (0.0, 0.06, 0.01), np.random.default_rng(seed)
    still = tracks_of(rig, move, turn, seed, 200, nearness=lambda rays: rng.uniform(1 / 120, 1 / 20, len(rays)))
    boat = tracks_of(rig, move + own, turn, seed + 10, 400, nearness=lambda rays: np.full(len(rays), 1 / 50))
    boat = boat.of(boat.left[0, :, 0] < 140).of(slice(None, len(still) * 6 // 10))
    both = Tracks(*(np.concatenate([getattr(one, s) for one in (still, boat)], axis=1) for s in ("left", "right")))
    seen = window(both, chart, np.zeros(chart.dim))
    assert seen.motion is not None
    np.testing.assert_allclose(seen.motion.translation / float(rig.baseline), move, atol=0.05)


@pytest.mark.parametrize("seed", [18, 24, 26, 27])
def test_points_that_would_pass_a_camera_tell_nothing(seed):
    """What moves along, nearer than the rig moves: at that depth it could not be ahead later, its pixels anywhere."""
    rig = sr.synthetic.default_rig().resized((320, 240))
    chart = rig_parameters(rig)
    far, rng = tracks_of(rig, np.array([0.0, 0.0, -2.0]), seed=seed, number=200), np.random.default_rng(seed)
    near = {"number": 100, "noise": 0.0, "nearness": lambda rays: rng.uniform(0.4, 0.6, len(rays))}
    along = tracks_of(rig, np.array(REST), seed=seed + 50, **near)
    both = Tracks(*(np.concatenate([getattr(one, s) for one in (far, along)], axis=1) for s in ("left", "right")))
    alone, seen = (window(one, chart, np.zeros(chart.dim)).normal.a for one in (far, both))
    np.testing.assert_array_less(np.diag(seen)[:5], 2.0 * np.diag(alone)[:5])
    assert np.linalg.eigvalsh(seen).min() > -1.0
