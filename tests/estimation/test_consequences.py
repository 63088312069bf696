"""What errors of a rig do to rows and depth."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from lenses import LENSES, WIDE_LENSES

import stereorecal as sr
from stereorecal.estimation import (
    DISTANCES,
    consequences,
    points_of_view,
    readings,
    rig_parameters,
)
from stereorecal.geometry import Camera, StereoRig, rectifying_rotations, view

SIZES = {"deg": 0.2, "%": 0.3, "px": 2.0, "": 1e-3}


def off(chart, seed: int, size: float = 1.0) -> np.ndarray:
    draw = np.random.default_rng([seed, 3]).uniform(-size, size, chart.dim)
    return draw * [SIZES[parameter.unit] for parameter in chart.parameters]


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


@settings(max_examples=15)
@given(seed=st.integers(0, 999), distance=st.sampled_from(DISTANCES))
def test_opencv_reads_the_same(chart, seed, distance):
    true, used = chart.rig_at(off(chart, seed)), chart.rig_at(off(chart, seed + 1, 0.3))
    points = points_of_view(true, distance)
    rows, nearness = readings(used, true, points)
    expected, depth = by_opencv(used, true, points)
    focal = np.mean([used.left.matrix[0, 0], used.left.matrix[1, 1], used.right.matrix[0, 0], used.right.matrix[1, 1]])
    np.testing.assert_allclose(rows, focal * expected, atol=1e-5)
    np.testing.assert_allclose(1 + nearness, points[:, 2] / depth, rtol=1e-5, atol=1e-6)


def in_the_middle(rig, points) -> np.ndarray:
    """Whether points lie in the middle of the left image."""
    share = np.asarray(rig.left.project(points / points[:, 2:])) / np.array(rig.left.size)
    return np.abs(share - 0.5).max(axis=1) < 0.25


def chart_of(rig, coefficients: int | str):
    if coefficients == "equidistant":
        matrix = rig.left.matrix * [[0.5], [0.5], [1.0]] + [[0, 0, 160], [0, 0, 120], [0, 0, 0]]
        camera = sr.Camera((640, 480), matrix, np.array(WIDE_LENSES[coefficients]), model=coefficients)
        return rig_parameters(sr.StereoRig(camera, camera, rig.extrinsics))
    camera = sr.Camera((640, 480), rig.left.matrix, np.array(LENSES[coefficients]))
    return rig_parameters(sr.StereoRig(camera, rig.right, rig.extrinsics))


def differences(chart, steps, theta, read):
    """Central differences of read(rig), of steps and twice as long ones: their errors of the second order cancel."""
    ends = [[read(chart.rig_at(theta + sign * step)) for sign in (1, -1, 2, -2)] for step in np.diag(steps)]
    each = zip(ends, steps, strict=True)
    return np.stack([(8 * (more - less) - (most - least)) / (12 * step) for (more, less, most, least), step in each])


def assert_near(found, expected) -> None:
    """To a millionth of the largest slope by each parameter."""
    largest = np.abs(expected).reshape(len(expected), -1).max(axis=1).reshape(-1, *[1] * (expected.ndim - 1))
    np.testing.assert_allclose(found / np.maximum(largest, 1e-9), expected / np.maximum(largest, 1e-9), atol=2e-6)


def weights(used: sr.StereoRig, points: np.ndarray, shown: sr.View) -> np.ndarray:
    """The weights of points in a mean over the view, and over the middle of the left image, by the squares of their
    disparities: less, where the view stretches rows."""
    x, y, z = (points @ rectifying_rotations(used.rotation, used.translation)[0].T).T
    squares = (shown.formulas.stretch(y, z, np.sqrt(x**2 + y**2 + z**2)) * np.ones(len(points))) ** -2
    both = squares * [np.ones(len(points)), in_the_middle(used, points)]
    return both / both.sum(axis=1, keepdims=True)


@pytest.mark.slow(after=3)
@pytest.mark.parametrize(
    ("coefficients", "projection"),
    [(5, "equirectangular"), ("equidistant", "equirectangular"), *((count, "pinhole") for count in sorted(LENSES))],
)
def test_consequences_by_theta_whatever_the_lens_and_the_view(rig, coefficients, projection):
    chart = chart_of(rig, coefficients)
    steps = np.array([{"%": 1e-2, "px": 1e-2, "deg": 1e-3, "": 1e-5}[p.unit] for p in chart.parameters])
    theta = off(chart, 1)
    used, shown = chart.rig_at(theta), sr.view(chart.rig, projection=projection)
    found = consequences(chart, theta, view=shown)
    for index, (distance, there) in enumerate(found.at_distances):
        points = points_of_view(used, distance, shown)
        assert len(points) > 20

        def read(true, points=points):
            return np.array(readings(used, true, points, shown))

        both = -differences(chart, steps, theta, read)
        assert_near(found.rows[there].T, both[:, 0])
        assert_near(found.nearness[there].T, both[:, 1])
        np.testing.assert_allclose(found.weights[:, there], weights(used, points, shown), rtol=1e-9)
        assert_near(found.mean_nearness[index], both[:, 1] @ found.weights[0, there])


def test_where_nothing_lies_ahead_of_both_cameras_the_whole_view_counts(rig):
    """The right camera looks 55 degrees aside."""
    aside = rig_parameters(rig.with_extrinsics(rig.extrinsics + np.array([0.0, np.radians(-55.0), 0.0, 0.0, 0.0, 0.0])))
    here = consequences(aside, np.zeros(aside.dim))
    for _, there in here.at_distances:
        whole, ahead = here.weights[:, there]
        assert there.sum() > 5
        assert not in_the_middle(aside.rig, here.points[there]).any()
        np.testing.assert_array_equal(ahead, whole)
        assert whole.any()


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
