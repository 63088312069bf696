"""The promise of the library: a rig that drifted a little sees again as well as before.

r is the paper's: the count after the repair over the count at the truth, both in the view of the start.
"""

import numpy as np
from hypothesis import Phase, given, settings, strategies as st

from stereorecal.geometry import view
from stereorecal.matching import SAD
from stereorecal.recalibration import Schedule, recalibrate
from stereorecal.scoring import score
from stereorecal.strategies import strategy

COMPASS = Schedule.count(strategy("compass"), scale=1.0)
MATCHER = SAD(num_disparities=96)  # what most of these scenes measure, or a little more: compiled once
component = st.floats(-1, 1)


# An example takes several seconds, so falsifying ones are not shrunk.
@settings(max_examples=8, phases=[Phase.explicit, Phase.generate])
@given(seed=st.integers(0, 24), drift=st.tuples(*[component] * 5))
def test_recovery(scene, seed, drift):
    given_scene = scene("harbour", seed, (640, 480))
    rig = given_scene.rig
    limits = np.array([*[np.radians(0.3)] * 3, 0.0, *[0.005 * rig.baseline] * 2])
    start = rig.with_extrinsics(rig.extrinsics + limits * np.insert(drift, 3, 0.0))
    solution = recalibrate(start, given_scene.pairs, schedule=COMPASS, matcher=MATCHER)
    reference = score(rig, given_scene.pairs, matcher=MATCHER, view=view(start))
    assert solution.score_after.count >= 0.95 * reference.count
