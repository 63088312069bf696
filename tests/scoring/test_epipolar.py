"""Row differences of exact rays against OpenCV's rectification, and the weights that they get."""

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.geometry import rotation_from_euler
from stereorecal.scoring import Correspondences, median_row_error, row_differences

FOCAL = 500.0
angle = st.floats(-0.15, 0.15)
extrinsics = st.builds(
    lambda pitch, yaw, roll, y, z, baseline: np.array([pitch, yaw, roll, -baseline, y * baseline, z * baseline]),
    *[angle] * 3,
    *[st.floats(-0.3, 0.3)] * 2,
    st.floats(0.01, 2.0),
)
traced = jax.jit(row_differences)


def points(seed: int, frames: int = 2, cells: int = 30) -> np.ndarray:
    """In front of both cameras."""
    return np.random.default_rng(seed).uniform([-1, -1, 4], [1, 1, 12], (frames, cells, 3))


def correspondences_of(seen: np.ndarray, values: np.ndarray, seed=0, dtype=np.float64, **changes) -> Correspondences:
    """The rays of points (in baselines, left camera) in a rig, of any length."""
    baseline = np.linalg.norm(values[3:])
    left = seen * baseline
    right = left @ rotation_from_euler(values[:3]).T + values[3:]
    lengths = np.random.default_rng(seed).uniform(0.1, 3.0, (2, *seen.shape[:2], 1))
    fields = {
        "left": (left * lengths[0] / baseline).astype(dtype),
        "right": (right * lengths[1] / baseline).astype(dtype),
        "weight": np.ones(seen.shape[:2], np.float32),
        "tile": np.zeros(seen.shape[:2], np.int32),
        "focal": np.float32(FOCAL),
        "scale": np.float32(1.0),
        "independent": np.float32(0.25),
    }
    return Correspondences(**{name: np.asarray(value) for name, value in (fields | changes).items()})


def rows_by_opencv(found: Correspondences, values: np.ndarray) -> np.ndarray:
    matrix, none = np.diag([FOCAL, FOCAL, 1.0]), np.zeros(5)
    rotation = rotation_from_euler(values[:3])
    turns = cv2.stereoRectify(matrix, none, matrix, none, (640, 480), rotation, values[3:].reshape(3, 1))[:2]
    rows = []
    for rays, turn in zip((found.left, found.right), turns, strict=True):
        seen, _ = cv2.projectPoints(rays.reshape(-1, 1, 3), cv2.Rodrigues(turn)[0], np.zeros(3), matrix, none)
        rows.append(seen[:, 0, 1].reshape(rays.shape[:2]))
    return rows[0] - rows[1]


@given(true=extrinsics, asked=extrinsics, seed=st.integers(0, 99))
def test_rows_are_those_of_opencv(true, asked, seed):
    found = correspondences_of(points(seed), true)
    actual = row_differences(found, asked)
    assert actual.shape == (2, 30)
    assert actual.dtype == np.float64
    # OpenCV takes rotations below 1e-5 for none.
    negligible = 1e-2 if np.linalg.norm(asked[:3]) < 2e-5 else 0.0
    np.testing.assert_allclose(actual, rows_by_opencv(found, asked), atol=1e-6 + negligible)
    in_float32 = traced(
        jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), found), jnp.asarray(asked, jnp.float32)
    )
    np.testing.assert_allclose(in_float32, actual, atol=2e-3)


@given(true=extrinsics, asked=extrinsics, unit=st.floats(1e-3, 1e4))
def test_the_unit_of_the_baseline_does_not_matter(true, asked, unit):
    found = correspondences_of(points(0), true)
    scaled = np.concatenate([asked[:3], unit * asked[3:]])
    np.testing.assert_allclose(row_differences(found, scaled), row_differences(found, asked), atol=1e-8)


def test_jacobian():
    """Forward mode in float32 against central differences in float64."""
    true, asked = np.array([0.02, -0.03, 0.01, -0.9, 0.02, 0.03]), np.array([0.01, 0.02, -0.01, -1.0, 0.01, -0.02])
    found = correspondences_of(points(1), true)
    in_float32 = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), found)
    for values in (asked, true, np.array([0, 0, 0, -1.0, 0, 0])):
        step = 1e-6
        expected = [(row_differences(found, values + s) - row_differences(found, values - s)) for s in step * np.eye(6)]
        expected = np.stack(expected, axis=-1) / (2 * step)
        actual = np.asarray(jax.jacfwd(row_differences, argnums=1)(in_float32, jnp.asarray(values, jnp.float32)))
        assert np.abs(actual - expected).max() < 2e-3 * np.abs(expected).max()
        assert (np.abs(expected).max((0, 1))[[0, 1, 2, 4, 5]] > 5).all()  # each free axis moves some row


def test_median_at_full_size():
    """Half a pixel at half scale is a pixel; cells without a correspondence do not count; without any, NaN."""
    ideal = np.array([0, 0, 0, -1.0, 0, 0])
    found = correspondences_of(points(0, 1, 5), ideal)
    lower = found.right + found.right[..., 2:] * np.array([0.0, 0.5 / FOCAL, 0.0])
    lower[0, 4, 1] += 3.0
    weight = np.array([[1, 1, 1, 1, 0]], np.float32)
    down = correspondences_of(points(0, 1, 5), ideal, right=lower, weight=weight, scale=np.float32(0.5))
    assert median_row_error(down, ideal) == pytest.approx(1.0)
    assert np.isnan(median_row_error(correspondences_of(points(0, 1, 5), ideal, weight=0 * weight), ideal))
