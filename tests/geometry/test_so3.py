"""Rotations against cv2.Rodrigues, the group axioms and finite differences."""

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal.geometry import (
    angle_between,
    euler_from_rotation,
    rotation_from_euler,
    rotation_from_vector,
    vector_from_rotation,
)

JITTED = [
    jax.jit(function)
    for function in (rotation_from_vector, vector_from_rotation, rotation_from_euler, euler_from_rotation)
]


def rodrigues(vector: np.ndarray) -> np.ndarray:
    return cv2.Rodrigues(np.asarray(vector, float).reshape(3, 1))[0]


@st.composite
def vectors(draw: st.DrawFn, largest: float = 3.0) -> np.ndarray:
    """Rotation vectors of all sizes below `largest` radians, tiny and zero ones included."""
    direction = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 3)))
    angle = draw(st.one_of(st.just(0.0), st.floats(0, largest), st.floats(-12, -3).map(lambda e: 10.0**e)))
    length = np.linalg.norm(direction)
    return angle * direction / length if length > 1e-3 else np.array([angle, 0.0, 0.0])


def eulers(yaw: float = 1.5) -> st.SearchStrategy[np.ndarray]:
    return st.tuples(st.floats(-3.1, 3.1), st.floats(-yaw, yaw), st.floats(-3.1, 3.1)).map(np.array)


@given(vectors())
def test_exponential_is_that_of_opencv(vector: np.ndarray):
    np.testing.assert_allclose(rotation_from_vector(vector), rodrigues(vector), atol=1e-13)
    traced = JITTED[0](jnp.asarray(vector, jnp.float32))
    assert traced.dtype == jnp.float32
    np.testing.assert_allclose(traced, rodrigues(vector), atol=2e-6)


@given(vectors())
def test_logarithm_is_that_of_opencv(vector: np.ndarray):
    rotation = rodrigues(vector)
    if np.linalg.norm(vector) > 1e-4:  # OpenCV answers 0 below 1e-5
        np.testing.assert_allclose(vector_from_rotation(rotation), cv2.Rodrigues(rotation)[0].ravel(), atol=1e-9)
    np.testing.assert_allclose(vector_from_rotation(rotation), vector, rtol=1e-9, atol=1e-11)
    traced = JITTED[1](jnp.asarray(rotation, jnp.float32))
    # Near pi the logarithm divides by sin(angle): single precision loses a factor of 1 / sin(3) = 7.
    np.testing.assert_allclose(traced, vector, atol=1e-5)


@given(vectors(1.0), vectors(1.0))
def test_the_group_is_closed_and_the_angle_is_a_metric(a: np.ndarray, b: np.ndarray):
    first, second = rotation_from_vector(a), rotation_from_vector(b)
    np.testing.assert_allclose(rotation_from_vector(vector_from_rotation(first @ second)), first @ second, atol=1e-12)
    angle = angle_between(first, second)
    assert angle == pytest.approx(float(angle_between(second, first)), abs=1e-12)
    assert angle == pytest.approx(np.linalg.norm(cv2.Rodrigues(first.T @ second)[0]), abs=2e-5)
    assert angle_between(first, first @ rotation_from_vector(b)) == pytest.approx(np.linalg.norm(b), abs=1e-9)
    assert angle <= np.linalg.norm(a) + np.linalg.norm(b) + 1e-12


@given(eulers())
def test_euler_angles_are_rz_ry_rx(angles: np.ndarray):
    rx, ry, rz = (rodrigues(angle * axis) for angle, axis in zip(angles, np.eye(3), strict=True))
    rotation = rotation_from_euler(angles)
    np.testing.assert_allclose(rotation, rz @ ry @ rx, atol=1e-14)
    np.testing.assert_allclose(euler_from_rotation(rotation), angles, atol=1e-12)
    traced = JITTED[2](jnp.asarray(angles, jnp.float32))
    np.testing.assert_allclose(traced, rotation, atol=1e-6)
    if abs(angles[1]) < 1.2:
        np.testing.assert_allclose(JITTED[3](traced), angles, atol=5e-6)


# --- derivatives --------------------------------------------------------------------------------------------


def differences(function, x: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Central differences in float64 on the NumPy face, one column for each entry of x."""
    columns = [(function(x + step * e) - function(x - step * e)) / (2 * step) for e in np.eye(x.size)]
    return np.stack(columns, axis=-1)


POINTS = [np.zeros(3), np.array([1e-6, 0, 0]), np.array([0.3, -0.2, 0.5]), np.array([0.0, 1.4, 0.0])]


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("jacobian", [jax.jacfwd, jax.jacrev])
@pytest.mark.parametrize(
    "function",
    [
        rotation_from_vector,
        rotation_from_euler,
        lambda v: vector_from_rotation(rotation_from_vector(v)),
        lambda v: euler_from_rotation(rotation_from_euler(v)),
        lambda v: vector_from_rotation(rotation_from_euler(v)),
    ],
    ids=["exp", "euler", "log exp", "euler euler", "log euler"],
)
def test_jacobians(jacobian, function):
    jitted = jax.jit(jacobian(function))
    for point in POINTS:
        actual = jitted(jnp.asarray(point, jnp.float32))
        assert np.isfinite(actual).all()
        np.testing.assert_allclose(actual, differences(function, point), atol=1e-5, err_msg=str(point))


@pytest.mark.parametrize("short", [5e-5, 1e-3])
def test_logarithm_of_almost_half_a_turn(short: float):
    """There the sine is small as at the identity, and the angle is not."""
    vector = (np.pi - short) * np.array([2.0, -1.0, 2.0]) / 3.0
    np.testing.assert_allclose(vector_from_rotation(rotation_from_vector(vector)), vector, rtol=1e-9)
