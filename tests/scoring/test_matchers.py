"""Every matcher sees at the truth and goes blind beside it."""

import numpy as np
import pytest

from stereorecal.matching import BM, SAD, SGBM
from stereorecal.scoring.host import score


@pytest.mark.parametrize("cls", [SAD, BM, SGBM])
@pytest.mark.parametrize("kind", ["harbour", "street"])
def test_truth_against_off(scene, cls, kind):
    given_scene = scene(kind, 2)
    rig, matcher = given_scene.rig, cls(num_disparities=32)
    off = rig.with_extrinsics(rig.extrinsics + np.radians([1.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    at_truth = score(rig, given_scene.pairs, matcher=matcher)
    beside = score(off, given_scene.pairs, matcher=matcher)
    assert 0.25 < at_truth.fraction < 1.0
    assert beside.count < 0.8 * at_truth.count


def test_bm_and_sad_agree(scene):
    """The same method in two implementations; BM leaves out a border of half a window."""
    given_scene = scene("harbour", 2)
    found = [score(given_scene.rig, given_scene.pairs, matcher=cls(num_disparities=32)).count for cls in (SAD, BM)]
    assert found[0] == pytest.approx(found[1], rel=0.12)
