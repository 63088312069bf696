"""The rig: exact extrinsics, rotations from files, what is refused."""

import pickle

import cv2
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from stereorecal import InputError
from stereorecal.geometry import AXES, Camera, StereoRig, rotation_from_euler

MATRIX = np.array([[80.0, 0, 46.2], [0, 82.0, 33.1], [0, 0, 1]])
LENS = Camera((96, 64), MATRIX, np.array([-0.1, 0.02, 1e-3, 0.0]))
IDEAL = np.array([0, 0, 0, -0.1, 0, 0])


def rig(extrinsics=IDEAL) -> StereoRig:
    return StereoRig(LENS, LENS, np.asarray(extrinsics))


@given(st.tuples(*[st.floats(-0.5, 0.5)] * 3), st.floats(-3.0, -0.05), st.tuples(*[st.floats(-0.04, 0.04)] * 2))
def test_float64_is_kept_exactly(angles, x, yz):
    extrinsics = np.array([*angles, x, *yz])
    for copy in (
        rig(extrinsics),
        rig().with_extrinsics(extrinsics),
        pickle.loads(pickle.dumps(rig(extrinsics))),
    ):
        assert copy.extrinsics.dtype == np.float64
        assert copy.extrinsics.tobytes() == extrinsics.tobytes()
    np.testing.assert_array_equal(rig(extrinsics).translation, extrinsics[3:])
    assert rig(extrinsics).baseline == pytest.approx(np.linalg.norm(extrinsics[3:]), rel=1e-15)
    again = StereoRig.from_rotation(LENS, LENS, rig(extrinsics).rotation, rig(extrinsics).translation)
    np.testing.assert_allclose(again.extrinsics, extrinsics, rtol=0, atol=1e-14)


def test_the_order_of_the_axes():
    assert AXES == ("pitch", "yaw", "roll", "x", "y", "z")
    for axis in range(3):
        extrinsics = IDEAL.copy()
        extrinsics[axis] = 0.2
        expected = cv2.Rodrigues(0.2 * np.eye(3)[axis])[0]
        np.testing.assert_allclose(rig(extrinsics).rotation, expected, atol=1e-15)


@pytest.mark.parametrize(
    ("extrinsics", "words"),
    [
        ([0, 0, 0, np.nan, 0, 0], "finite"),
        ([np.inf, 0, 0, -0.1, 0, 0], "finite"),
        ([0, 0, 0, 0, 0, 0], "baseline is zero"),
        ([0, 0, 0, 0.1, 0, 0], "exchanged"),
        ([0, 0, 0, 0.1, 0.05, 0.1], "exchanged"),
        ([0, 0, 0, -0.1, 0.1, 0], "neither side by side"),
        ([0, 0, 0, -0.1, 0, -0.1], "neither side by side"),
        ([0, 0, 0, 0.05, 0.1, 0.2], "neither side by side"),
        ([0, 0, np.pi, 0.05, 0.1, 0.2], "neither side by side"),
    ],
)
def test_extrinsics_that_are_none(extrinsics: list[float], words: str):
    for make in (rig, rig().with_extrinsics):
        with pytest.raises(InputError, match=words):
            make(np.array(extrinsics, float))


@pytest.mark.parametrize(
    "rotation",
    [
        np.zeros((3, 3)),
        -np.eye(3),
        np.diag([1, 1, -1.0]),
        1.01 * np.eye(3),
        np.eye(3) + 0.01,
        np.eye(3) * np.nan,
    ],
)
def test_rotations_that_are_none(rotation: np.ndarray):
    with pytest.raises(InputError, match="rotation"):
        StereoRig.from_rotation(LENS, LENS, rotation, IDEAL[3:])


def test_the_nearest_rotation_is_taken():
    rotation = rotation_from_euler(np.array([0.1, -0.2, 0.3]))
    blurred = StereoRig.from_rotation(LENS, LENS, np.round(rotation, 4), IDEAL[3:])
    np.testing.assert_allclose(blurred.rotation @ blurred.rotation.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(blurred.rotation, rotation, atol=1e-4)


@pytest.mark.parametrize("change", [lambda one: one.resized((48, 32)), lambda one: one.cropped((48, 32), (5, 6))])
def test_a_change_of_size_is_that_of_both_cameras(change):
    stereo = rig([0.1, 0.2, 0.3, -1, 0.1, 0.2])
    small = change(stereo)
    for camera, of_before in ((small.left, stereo.left), (small.right, stereo.right)):
        assert camera.size == (48, 32)
        np.testing.assert_array_equal(camera.matrix, change(of_before).matrix)
    assert small.extrinsics.tobytes() == stereo.extrinsics.tobytes()


def test_pytree():
    stereo = rig()
    copy = jax.tree.map(lambda leaf: leaf, stereo)
    assert type(copy) is StereoRig
    assert type(copy.right) is Camera
    assert copy.extrinsics.tobytes() == IDEAL.tobytes()
    assert jax.tree.structure(stereo) == jax.tree.structure(rig([0.1, 0, 0, -1, 0, 0]))
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), stereo, stereo)  # would not pass validation
    assert stacked.extrinsics.shape == (2, 6)


def test_rig_as_an_argument_of_jit_and_grad():
    baseline = jax.jit(lambda stereo: stereo.baseline)
    assert baseline(rig()) == pytest.approx(0.1)
    assert baseline(rig([0, 0, 0, -0.3, 0, 0])) == pytest.approx(0.3)
    assert baseline._cache_size() == 1
    gradient = jax.grad(lambda e: rig().with_extrinsics(e).rotation[1, 0])(jnp.asarray(IDEAL, jnp.float32))
    np.testing.assert_array_equal(gradient, [0, 0, 1, 0, 0, 0])
