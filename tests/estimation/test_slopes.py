"""Derivatives in closed form against central differences of whole rigs: what the prior and the consequences rest on."""

import numpy as np
import pytest
from lenses import LENSES, WIDE_LENSES

import stereorecal as sr
from stereorecal.estimation import (
    DISTANCES,
    _calibration_prior as of_boards,
    consequences,
    points_of_view,
    readings,
    rig_parameters,
)
from stereorecal.geometry import rectifying_rotations

SIZES = {"deg": 0.3, "%": 0.3, "px": 3.0, "": 1e-3}


def chart_of(rig, coefficients: int | str):
    if coefficients == "equidistant":
        matrix = rig.left.matrix * [[0.5], [0.5], [1.0]] + [[0, 0, 160], [0, 0, 120], [0, 0, 0]]
        camera = sr.Camera((640, 480), matrix, np.array(WIDE_LENSES[coefficients]), model=coefficients)
        return rig_parameters(sr.StereoRig(camera, camera, rig.extrinsics))
    camera = sr.Camera((640, 480), rig.left.matrix, np.array(LENSES[coefficients]))
    return rig_parameters(sr.StereoRig(camera, rig.right, rig.extrinsics))


def somewhere(chart, seed: int) -> np.ndarray:
    sizes = np.array([SIZES[parameter.unit] for parameter in chart.parameters])
    return sizes * np.random.default_rng([seed, 5]).uniform(-1, 1, chart.dim)


def differences(chart, steps, theta, read):
    """Central differences of read(rig)."""
    ends = [[read(chart.rig_at(theta + sign * step)) for sign in (1, -1)] for step in np.diag(steps)]
    return np.stack([(more - less) / (2 * step) for (more, less), step in zip(ends, steps, strict=True)])


def assert_near(found, expected) -> None:
    """To a millionth of the largest slope by each parameter."""
    largest = np.abs(expected).reshape(len(expected), -1).max(axis=1).reshape(-1, *[1] * (expected.ndim - 1))
    np.testing.assert_allclose(found / np.maximum(largest, 1e-9), expected / np.maximum(largest, 1e-9), atol=2e-6)


def pixels_of(rig: sr.StereoRig, points: np.ndarray) -> np.ndarray:
    """In the left image and in the right one (..., 4)."""
    sides = rig.left.project(points), rig.right.project(points @ rig.rotation.T + rig.translation)
    return np.concatenate([np.asarray(side) for side in sides], axis=-1)


def weights(used: sr.StereoRig, points: np.ndarray, shown: sr.View) -> np.ndarray:
    """Of points in a mean over the view, and over the middle of the left image, by the squares of their disparities:
    less, where the view stretches rows."""
    x, y, z = (points @ rectifying_rotations(used.rotation, used.translation)[0].T).T
    squares = (shown.formulas.stretch(y, z, np.sqrt(x**2 + y**2 + z**2)) * np.ones(len(points))) ** -2
    share = np.asarray(used.left.project(points / points[:, 2:])) / np.array(used.left.size)
    both = squares * [np.ones(len(points)), np.abs(share - 0.5).max(axis=1) < 0.25]
    return both / both.sum(axis=1, keepdims=True)


@pytest.mark.slow(after=3)
@pytest.mark.parametrize(
    ("coefficients", "projection"),
    [(5, "equirectangular"), ("equidistant", "equirectangular"), *((count, "pinhole") for count in sorted(LENSES))],
)
def test_consequences_by_theta_whatever_the_lens_and_the_view(rig, coefficients, projection):
    chart = chart_of(rig, coefficients)
    steps = np.array([{"%": 1e-2, "px": 1e-2, "deg": 1e-3, "": 1e-5}[p.unit] for p in chart.parameters])
    theta = somewhere(chart, 1)
    used, shown = chart.rig_at(theta), sr.view(chart.rig, projection=projection)
    found = consequences(chart, theta, view=shown)
    for index, distance in enumerate(DISTANCES):
        points = points_of_view(used, distance, shown)
        assert len(points) > 20

        def read(true, points=points):
            return np.array(readings(used, true, points, shown))

        both = -differences(chart, steps, theta, read)
        assert_near(found.rows[index].T, both[:, 0])
        assert_near(found.nearness[index].T, both[:, 1] @ weights(used, points, shown).T)


def test_what_boards_tell_of_the_rig_where_their_poses_are_not_known(chart, steps):
    """One board: the rig and its pose, by differences, solved together."""
    boards = of_boards._boards(chart.rig, of_boards._KINDS[0])[:3]
    inside = pixels_of(chart.rig, boards)
    inside = ((inside >= 0) & (inside <= np.array([639, 479, 639, 479]))).all(axis=-1)
    inside &= inside.sum(axis=1, keepdims=True) >= 20
    by_rig = differences(chart, steps, np.zeros(chart.dim), lambda other: pixels_of(other, boards))
    ends = [[pixels_of(chart.rig, boards + sign * 1e-5 * axis) for sign in (1, -1)] for axis in np.eye(3)]
    by_point = np.stack([(more - less) / 2e-5 for more, less in ends], axis=-1)
    middle = boards.mean(axis=1, keepdims=True)
    turns = [by_point @ np.cross(axis, boards - middle)[..., None] for axis in np.eye(3)]
    shifts = [by_point @ np.broadcast_to(axis, boards.shape)[..., None] for axis in np.eye(3)]
    by_pose = np.stack([*turns, *shifts])[..., 0]
    for board, found in enumerate(of_boards._information(chart, boards)):
        rig, pose = (part[:, board][:, inside[board]].reshape(len(part), -1).T for part in (by_rig, by_pose))
        left = rig - pose @ np.linalg.lstsq(pose, rig, rcond=None)[0] if inside[board].any() else rig
        expected, scale = left.T @ left, np.sqrt(np.maximum(np.diag(rig.T @ rig), 1e-9))
        np.testing.assert_allclose(found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-5)
