"""The kernels one by one, with pytest-benchmark, to compare one state of the code with another:

    pip install -e '.[benchmarks]'
    python -m pytest -o addopts= tests/benchmarks/bench_kernels.py --benchmark-autosave --benchmark-compare

Without the options of the test run, which check types as they go. Not part of it: pytest collects no such name.
"""

from collections.abc import Callable

import jax
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.scoring import prepare
from stereorecal.scoring.host import correspondences, counts
from stereorecal.scoring.host._disparities import match_in_blocks, rectified_frame

SIZE, MATCHER = (741, 500), sr.SAD(num_disparities=80)


def kernels() -> dict[str, Callable[[], object]]:
    """Calls that take all they need with them, on one rendered street."""
    scene = sr.synthetic.render("street", 0, rig=sr.synthetic.default_rig().resized(SIZE))
    assert scene.rig is not None
    view, extrinsics = sr.view(scene.rig), with_unit_baseline(scene.rig.extrinsics)
    full, quarter = (prepare(scene.rig, scene.pairs, view, scale) for scale in (1.0, 0.25))
    frame = rectified_frame(full, np.float32(extrinsics))
    gradient = jax.jit(jax.grad(lambda e: sr.soft_count(quarter, e, MATCHER)))
    single, found = np.float32(extrinsics), sr.correspondences(full, extrinsics, MATCHER)
    return {
        "rectify": lambda: jax.block_until_ready(rectified_frame(full, single)),
        "match": lambda: match_in_blocks(MATCHER, frame),
        "count at quarter scale": lambda: counts(quarter, extrinsics[None], MATCHER),
        "ten counts at quarter scale": lambda: counts(quarter, np.repeat(extrinsics[None], 10, axis=0), MATCHER),
        "soft count at quarter scale": lambda: jax.block_until_ready(sr.soft_count(quarter, single, MATCHER)),
        "its gradient": lambda: jax.block_until_ready(gradient(single)),
        "correspondences": lambda: correspondences(full, extrinsics, MATCHER),
        "row differences": lambda: jax.block_until_ready(sr.row_differences(found, single)),
        "repair": lambda: sr.recalibrate(scene.rig, scene.pairs),
    }


KERNELS = kernels()


@pytest.mark.parametrize("name", KERNELS)
def test_kernel(benchmark, name):
    KERNELS[name]()  # compiles
    benchmark(KERNELS[name])
