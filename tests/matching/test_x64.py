"""With JAX_ENABLE_X64 the library computes as without it."""

import os
import subprocess
import sys

import numpy as np
import pytest
from gpu import as_on_a_gpu

from stereorecal.matching import SAD

try:
    from jax import enable_x64
except ImportError:  # before JAX 0.8
    from jax.experimental import enable_x64

MATCHER = SAD(num_disparities=16, block_size=5)
IMAGE = np.random.default_rng(0).uniform(0, 255, (24, 48)).astype(np.float32)

WHOLE = """
import numpy as np, stereorecal as sr
from stereorecal.synthetic import default_rig, render
scene = render("harbour", 0, rig=default_rig().resized((96, 72)))
print(sr.health(scene.rig, scene.pairs))
print(sr.recalibrate(scene.rig, scene.pairs))
"""


@pytest.mark.slow
@pytest.mark.parametrize("made", [lambda: MATCHER.match, lambda: as_on_a_gpu(MATCHER, IMAGE.shape)], ids=["CPU", "GPU"])
def test_search(made):
    images = IMAGE, np.roll(IMAGE, -3, 1)
    expected = made()(*images)
    as_on_a_gpu.cache_clear()
    with enable_x64(True):
        found = made()(*images)
    for name in ("values", "valid"):
        one, other = getattr(expected, name), getattr(found, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


def test_soft_search():
    with enable_x64(True):
        found = MATCHER.soft_match(IMAGE, np.roll(IMAGE, -3, 1), 0.1)
    assert found.confidence.dtype == np.float32


@pytest.mark.slow
def test_health_and_repair():
    run = [sys.executable, "-c", WHOLE]
    ended = subprocess.run(run, env=os.environ | {"JAX_ENABLE_X64": "1"}, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout
