"""What errors of a rig do to rows and depth, and the rigs that may be written."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from stereorecal.estimation import (
    DISTANCES,
    Estimate,
    Posterior,
    consequences,
    points_of_view,
    readings,
    regions,
    rig_parameters,
)
from stereorecal.geometry import Camera, StereoRig, rectifying_rotations, view

SIZES = {"deg": 0.2, "%": 0.3, "px": 2.0, "": 1e-3}


def off(chart, seed: int, size: float = 1.0) -> np.ndarray:
    draw = np.random.default_rng([seed, 3]).uniform(-size, size, chart.dim)
    return draw * [SIZES[parameter.unit] for parameter in chart.parameters]


def drifted(chart, seed: int) -> np.ndarray:
    return off(chart, seed) * (np.arange(chart.dim) < 5)


@pytest.fixture(scope="module")
def theta(chart):
    return off(chart, 7)


@pytest.fixture(scope="module")
def near(chart, theta):
    return consequences(chart, theta)


def by_opencv(used, true, points) -> tuple[np.ndarray, np.ndarray]:
    """Row differences at focal length 1, and depth along the left axis, of rectified pixels of points."""
    criteria = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, 100, 1e-14)
    lenses = [(np.array(camera.matrix), np.array(camera.distortion)) for camera in (used.left, used.right)]
    turns = cv2.stereoRectify(*lenses[0], *lenses[1], used.left.size, used.R, used.T[:, None])[:2]
    pixels = (true.left.project(points), true.right.project(points @ true.rotation.T + true.translation))
    left, right = (
        cv2.undistortPoints(seen[:, None], *lens, R=turn, criteria=criteria)[:, 0]
        for seen, lens, turn in zip(pixels, lenses, turns, strict=True)
    )
    along = np.column_stack([left, np.ones(len(left))]) @ turns[0][:, 2]
    return left[:, 1] - right[:, 1], used.baseline * along / (left - right)[:, 0]


@pytest.mark.parametrize("distance", DISTANCES)
def test_points_lie_where_both_cameras_see_them(rig, distance):
    points = points_of_view(rig, distance)
    np.testing.assert_allclose(points[:, 2], distance * rig.baseline)
    for camera, seen in ((rig.left, points), (rig.right, points @ rig.rotation.T + rig.translation)):
        pixels = camera.project(seen)
        assert pixels.min() >= 0
        assert (pixels <= np.array([639, 479])).all()
    assert np.ptp(rig.left.project(points), axis=0) == pytest.approx([575, 431], abs=100)


@settings(max_examples=15)
@given(seed=st.integers(0, 999))
def test_a_rig_reads_itself_without_an_error(chart, seed):
    rig = chart.rig_at(off(chart, seed))
    for reading in readings(rig, rig, points_of_view(rig, 10)):
        np.testing.assert_allclose(reading, 0.0, atol=1e-9)


@settings(max_examples=15)
@given(seed=st.integers(0, 999), distance=st.sampled_from(DISTANCES))
def test_opencv_reads_the_same(chart, rig, seed, distance):
    true, used = chart.rig_at(off(chart, seed)), chart.rig_at(off(chart, seed + 1, 0.3))
    points = points_of_view(true, distance)
    rows, nearness = readings(used, true, points)
    expected, depth = by_opencv(used, true, points)
    focal = np.mean([used.left.matrix[0, 0], used.left.matrix[1, 1], used.right.matrix[0, 0], used.right.matrix[1, 1]])
    np.testing.assert_allclose(rows, focal * expected, atol=1e-5)
    np.testing.assert_allclose(1 + nearness, points[:, 2] / depth, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("name", "by"), [("baseline", 1.0), ("left.cy", 1.0), ("roll", 0.3)])
def test_signs_and_sizes(chart, rig, name, by):
    used = chart.rig_at(by * np.eye(chart.dim)[chart.names.index(name)])
    rows, nearness = readings(used, rig, points_of_view(rig, 10))
    if name == "baseline":  # one percent longer: all is read as one percent farther
        np.testing.assert_allclose(rows, 0.0, atol=1e-9)
        np.testing.assert_allclose(nearness, 1 / 1.01 - 1, rtol=1e-9)
    elif name == "left.cy":  # the centre lies lower, so what is seen lies higher
        assert rows.mean() == pytest.approx(-1.0, abs=0.1)
    else:
        assert np.ptp(rows) > np.radians(by) * 500


@settings(max_examples=15)
@given(seed=st.integers(0, 999), size=st.floats(0.01, 0.05))
def test_linear_maps_against_readings_of_other_rigs(chart, theta, near, seed, size):
    """Whether the used rig errs or the truth lies elsewhere."""
    change = off(chart, seed, size)
    used = chart.rig_at(theta)
    for index, distance in enumerate(DISTANCES):
        points = points_of_view(used, distance)
        expected = near.rows[index] @ change
        for pair in ((used, chart.rig_at(theta - change)), (chart.rig_at(theta + change), used)):
            rows, nearness = readings(*pair, points)
            np.testing.assert_allclose(rows, expected, atol=0.02 * np.abs(expected).max() + 1e-3)
            over = nearness.mean(), nearness[in_the_middle(pair[1], points)].mean()
            np.testing.assert_allclose(over, near.nearness[index] @ change, rtol=0.03, atol=1e-3)


def shares(rig, points) -> np.ndarray:
    """Where points lie in the left image, of its width and height."""
    return np.asarray(rig.left.project(points / points[:, 2:])) / np.array(rig.left.size)


def in_the_middle(rig, points) -> np.ndarray:
    return np.abs(shares(rig, points) - 0.5).max(axis=1) < 0.25


def test_means_over_the_view_and_ahead(rig, chart):
    """Of all points alike, and of those of the middle; nine regions by rows."""
    here = consequences(chart, np.zeros(chart.dim))
    for points, variation, (whole, ahead) in zip(here.points, here.variation, here.nearness, strict=True):
        inside = in_the_middle(rig, points)
        assert 0 < inside.sum() < len(inside)
        largest = np.abs(variation).max(axis=0)
        np.testing.assert_allclose(variation.mean(axis=0), 0.0, atol=1e-12)
        np.testing.assert_allclose(variation[inside].mean(axis=0), ahead - whole, rtol=1e-9, atol=1e-12)
        assert (np.abs(ahead - whole) > 0.01 * largest).sum() > 10
        column, row = (3 * shares(rig, points)).astype(int).T
        np.testing.assert_array_equal(regions(rig, points), 3 * row + column)


def test_where_nothing_lies_ahead_of_both_cameras_the_whole_view_counts(rig):
    """The right camera looks 55 degrees aside."""
    aside = rig_parameters(rig.with_extrinsics(rig.extrinsics + np.array([0.0, np.radians(-55.0), 0.0, 0.0, 0.0, 0.0])))
    here = consequences(aside, np.zeros(aside.dim))
    for points, (whole, ahead) in zip(here.points, here.nearness, strict=True):
        assert len(points) > 5
        assert not in_the_middle(aside.rig, points).any()
        np.testing.assert_allclose(ahead, whole, rtol=1e-12)
        assert whole.any()


def deviations(chart) -> np.ndarray:
    return np.array([SIZES[parameter.unit] for parameter in chart.parameters])


def known(chart, mean, sigma, astray=0.0) -> Estimate:
    """An estimate by what it knows of θ, which goes astray one time of four, so that the median of depth is not that of
    the mean."""
    means, covariance = np.stack([mean - 0.25 * astray, mean + 0.75 * astray]), np.diag(sigma**2)
    posterior = Posterior(np.array([0.75, 0.25]), means, np.stack([covariance, covariance]))
    return Estimate(chart, posterior, (0.0, 0.0), 0, float("nan"), np.zeros(chart.dim))


def loss(near, found: Estimate, theta) -> float:
    """In squares: a tenth of a pixel of rows counts like one percent of disparity, on average, ahead and at single
    points, at each of three distances, and ten deviations of a free parameter from its mean."""
    mean, nearness, sigma = found.theta, found.known.nearness, np.sqrt(np.diag(found.posterior.covariance))
    total = np.sum((0.1 * (theta - mean) / sigma)[theta != 0.0] ** 2)
    for distance in (5, 10, 30):
        index = DISTANCES.index(distance)
        rows = near.rows[index] @ (theta - mean)
        total += np.mean((rows / 0.1) ** 2) / 3
        total += np.mean(((near.nearness[index] @ (theta - mean) - nearness[index]) / 0.01) ** 2)
        total += np.mean((near.variation[index] @ (theta - mean) / 0.01) ** 2)
    return float(total)


def test_with_all_free_and_nothing_to_correct_it_is_the_mean(chart, theta):
    np.testing.assert_array_equal(known(chart, theta, np.zeros(chart.dim)).with_free(chart.names), theta)


@settings(max_examples=15)
@given(seed=st.integers(0, 999), size=st.floats(0.0, 3.0))
def test_held_parameters_stay_and_more_freedom_loses_no_more(chart, theta, near, seed, size):
    found = known(chart, theta, deviations(chart), off(chart, seed, size))
    names, losses = np.array(chart.names), []
    lenses = np.array([name.startswith("right.") for name in names])
    extrinsics = np.arange(chart.dim) < 5
    for free in (extrinsics & (names != "y"), extrinsics, extrinsics | lenses, np.ones(chart.dim, bool)):
        chosen = found.with_free(names[free].tolist())
        assert not chosen[~free].any()
        losses.append(loss(near, found, chosen))
    assert losses[0] <= loss(near, found, np.zeros(chart.dim))
    # What is held is not near the mean, and does not count: a hundredth at most of each that is freed.
    assert (np.diff(losses) <= 0.01 * chart.dim).all()


def test_free_lenses_do_not_vary_depth_over_the_view_for_a_little_of_rows(rig, chart, theta):
    """Too far here and too near there is right on average, and wrong everywhere."""
    free = [name for name in chart.names if "." in name or name in ("pitch", "yaw", "roll", "y", "z")]
    mean, kept = chart.rig_at(theta), known(chart, theta, deviations(chart)).with_free(free, keep_depth=True)
    given_nearness, moved = (readings(one, mean, points_of_view(mean, 30))[1] for one in (rig, chart.rig_at(kept)))
    assert moved.mean() == pytest.approx(given_nearness.mean(), rel=0.01)
    assert moved.std() < 0.6 * given_nearness.std()


@settings(max_examples=15)
@given(seed=st.integers(0, 999))
def test_no_step_loses_less(chart, theta, near, seed):
    """Of the extrinsics, or of one lens, too, which stays near its mean where rows and depth do not tell."""
    known_of, names = known(chart, theta, deviations(chart), off(chart, 5)), np.array(chart.names)
    extrinsics = np.arange(chart.dim) < 5
    for free in (extrinsics, extrinsics | [name.startswith("right.") for name in names]):
        found = known_of.with_free(names[free].tolist())
        here = loss(near, known_of, found)
        for size in (1e-4, -1e-4, 1e-2, 0.1):
            assert loss(near, known_of, found + off(chart, seed) * free * size) >= here * (1 - 1e-11)


def test_what_is_exact_stays_as_it_is(chart):
    """No deviation, and a mean of zero: free, but there is no reason to move it."""
    exact = np.arange(chart.dim) >= 5
    found = known(chart, drifted(chart, 1), np.where(exact, 0.0, deviations(chart)), drifted(chart, 5)).with_free(
        chart.names
    )
    assert np.isfinite(found).all()
    assert found[:5].any()
    assert not found[exact].any()


def test_sides_that_a_wide_view_stretches_count_for_less():
    """Rows are those of the view less its stretch; depth is a mean weighed by the squares of disparities. A pinhole's
    points count alike."""
    terms = np.array([-0.02, -0.007, 0.002, -0.001])
    lens = Camera((640, 480), np.array([[195.0, 0, 322.4], [0, 196.0, 236.1], [0, 0, 1]]), terms, model="equidistant")
    true = StereoRig(lens, lens, np.array([0.004, -0.006, 0.003, -0.36, 0.002, -0.001]))
    used = true.with_extrinsics(true.extrinsics + np.array([2e-3, 3e-3, -1e-3, 0.0, 0.0, 0.0]))
    chart = rig_parameters(true)
    at, surely = (
        chart.coordinates_of(used),
        Posterior(np.ones(1), np.zeros((1, chart.dim)), np.zeros((1, *[chart.dim] * 2))),
    )
    for shown in (view(true), view(true, projection="pinhole")):
        points = points_of_view(true, 10, shown)
        rows, nearness = readings(used, true, points, shown)
        found = Estimate(chart, surely, (0.0, 0.0), 0, 0.0, np.zeros(chart.dim), judged_at=(10,), view=shown)
        turns = rectifying_rotations(used.rotation, used.translation)
        seen = (points @ turns[0].T, (points @ true.rotation.T + true.translation) @ turns[1].T)
        (column, row), (other, beside) = (shown.pixels(ray, side) for side, ray in enumerate(seen))
        stretch = shown.formulas.stretch(*seen[0].T[1:], np.linalg.norm(seen[0], axis=1)) * np.ones(len(points))
        np.testing.assert_allclose(rows * shown.focal / used.left.focal.mean(), (row - beside) / stretch, rtol=1e-6)
        x, y, z = (points @ rectifying_rotations(true.rotation, true.translation)[0].T).T
        weights = (shown.formulas.stretch(y, z, np.sqrt(x**2 + y**2 + z**2)) * np.ones(len(points))) ** -2
        near = shown.nearness(column, column - other) * shown.formulas.length(*seen[0].T) / float(used.baseline)
        np.testing.assert_allclose(1.0 + nearness, near, rtol=1e-9)
        middle = in_the_middle(true, points)
        mean, ahead = (100.0 / np.average(near, weights=some) - 100.0 for some in (weights, weights * middle))
        np.testing.assert_allclose(found.depth_error_percent(at)[10], mean, rtol=1e-6)
        np.testing.assert_allclose(found.losses(at)[1], max(abs(mean), abs(ahead)), rtol=1e-6)
        assert (np.ptp(stretch) > 1.0) == (shown.projection == "equirectangular")


def test_the_corners_of_a_lens_that_sees_farther_than_its_view_do_not_count():
    """A rational model of 162 degrees: where it ends, rows of its own posterior would be hundreds of pixels apart."""
    terms = np.array([0.66, 0.086, 0.0, 0.0, 0.0014, 1.03, 0.238, 0.0117])
    camera = Camera((1280, 640), np.array([[523.0, 0.0, 640.7], [0.0, 465.2, 296.5], [0.0, 0.0, 1.0]]), terms)
    rig = StereoRig(camera, camera, np.array([0.0, 0.0, 0.0, -0.08, 0.0, 0.0]))
    points, seen = points_of_view(rig, 10), view(rig)
    aside = np.hypot(*(points[:, :2] / points[:, 2:]).T)
    assert np.hypot(*camera.rays(np.zeros((1, 2)))[0, :2]) > 6.0
    assert len(points) > 40
    assert aside.max() < np.hypot(*seen.size) / 2.0 / seen.focal
