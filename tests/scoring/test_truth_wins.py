"""At the truth the count is higher than after a small turn, by every matcher."""

import numpy as np
import pytest

from stereorecal.geometry import view, with_unit_baseline
from stereorecal.io import load_scene
from stereorecal.matching import BM, SAD, SGBM
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts, score

TURNS = {"pitch": (0, 0.3), "roll": (2, 1.0)}


def turned(rig):
    """The rig's extrinsics, then with each turn, both ways."""
    points = np.repeat(with_unit_baseline(rig.extrinsics)[None], 5, axis=0)
    for row, (axis, degrees) in enumerate(
        (axis, sign * degrees) for axis, degrees in TURNS.values() for sign in (1, -1)
    ):
        points[row + 1, axis] += np.radians(degrees)
    return points


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(
    ("name", "disparities"),
    [("boofcv_bumblebee2/garden01", 96), ("middlebury2014/motorcycle_quarter", 96), ("kitti_odometry/suburb_seq", 96)],
)
def test_real(data_dir, name, disparities):
    given_scene = load_scene(data_dir / name, limit=1)
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    found = counts(prepared, turned(given_scene.rig), SAD(num_disparities=disparities))
    assert found[1:].max() < found[0]


@pytest.mark.parametrize("cls", [SAD, BM, SGBM])
@pytest.mark.parametrize("kind", ["harbour", "street"])
def test_every_matcher_sees_at_the_truth_and_goes_blind_beside_it(scene, cls, kind):
    given_scene = scene(kind, 2)
    rig, matcher = given_scene.rig, cls(num_disparities=32)
    off = rig.with_extrinsics(rig.extrinsics + np.radians([1.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    at_truth, beside = (score(one, given_scene.pairs, matcher=matcher) for one in (rig, off))
    assert 0.25 < at_truth.fraction < 1.0
    assert beside.count < 0.8 * at_truth.count
    if cls is BM and kind == "harbour":  # the method of SAD; it leaves out a border of half a window
        assert at_truth.count == pytest.approx(
            score(rig, given_scene.pairs, matcher=SAD(num_disparities=32)).count, rel=0.12
        )
