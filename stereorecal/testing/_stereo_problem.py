"""A small rendered stereo problem: a harbour seen by a rig that is half a degree off."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

from stereorecal.matching import SAD
from stereorecal.objectives import Reach, count_chart, objective
from stereorecal.strategies import Objective
from stereorecal.synthetic import default_rig, render

_SIZE = (160, 120)
_REACH = Reach(degrees=1.0, baseline_fraction=0.01)
_TRUTH = np.array([0.45, -0.3, 0.4, 0.3, -0.2])  # relative to the start, in units of the reach; our choice


@lru_cache(maxsize=1)
def stereo_objective() -> tuple[Objective, Float[np.ndarray, "n"]]:
    """The objective of a decalibrated rig, and the point of its box that is the true rig."""
    true = default_rig().resized(_SIZE)
    scene = render("harbour", 3, rig=true)
    offset = count_chart(true, _REACH).extrinsics(_TRUTH) - true.extrinsics
    drifted = true.with_extrinsics(true.extrinsics - offset)
    truth = np.asarray(count_chart(drifted, _REACH).coordinates(true.extrinsics))
    return objective(drifted, scene.pairs, matcher=SAD(num_disparities=32, block_size=7), reach=_REACH), truth
