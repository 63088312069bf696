"""The traced count is the host's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from stereorecal.matching import BM, SAD
from stereorecal.objectives import objective


@pytest.mark.slow
def test_vmap_equals_host(scene):
    given_scene = scene(size=(160, 120))
    made = objective(given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=24))
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (6, 5))
    points[0] = 0.0
    host = made.batch(points)
    traced = np.asarray(jax.vmap(made.traced.count)(jnp.asarray(points, jnp.float32)))
    np.testing.assert_allclose(traced, host, rtol=1e-3)
    assert host[0] == host.max()
    assert len(set(host)) > 3


def test_opencv_matchers_have_no_traced_face(scene):
    given_scene = scene(size=(160, 120))
    made = objective(given_scene.rig, given_scene.pairs, matcher=BM(num_disparities=32))
    assert made.traced.count is None
    assert made.value(np.zeros(5)) > 0


def test_value_is_a_python_float(scene):
    given_scene = scene(size=(160, 120))
    made = objective(given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=24))
    assert type(made.value(np.zeros(5))) is float


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_cost_is_frames_times_scale_squared(scene, scale):
    given_scene = scene("street", 0, frames=2)
    made = objective(given_scene.rig, given_scene.pairs, matcher=SAD(num_disparities=32), scale=scale)
    assert made.cost == 2 * scale**2
