"""With JAX_ENABLE_X64 the library computes as without it."""

import os
import subprocess
import sys

import jax
import numpy as np
import pytest

from stereorecal.matching import SAD
from stereorecal.matching.sad._planes import winners as winners_by_planes
from stereorecal.matching.sad._sad import winners_by_rows

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
@pytest.mark.parametrize("by", [winners_by_rows, winners_by_planes])
def test_search(by):
    whole = IMAGE.astype(np.int16), np.roll(IMAGE, -3, 1).astype(np.int16)
    expected = by(*map(jax.numpy.asarray, whole), MATCHER)
    with enable_x64(True):
        found = by(*map(jax.numpy.asarray, whole), MATCHER)
    for one, other in zip(expected, found, strict=True):
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
