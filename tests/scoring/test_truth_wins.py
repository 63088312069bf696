"""At the truth the count is higher than after a small turn."""

import numpy as np
import pytest

from stereorecal.geometry import view, with_unit_baseline
from stereorecal.io import load_scene
from stereorecal.matching import SAD
from stereorecal.scoring import prepare
from stereorecal.scoring.host import counts

TURNS = {"pitch": (0, 0.3), "roll": (2, 1.0)}


def turned(rig):
    """The rig's extrinsics, then with each turn, both ways."""
    points = np.repeat(with_unit_baseline(rig.extrinsics)[None], 5, axis=0)
    for row, (axis, degrees) in enumerate(
        (axis, sign * degrees) for axis, degrees in TURNS.values() for sign in (1, -1)
    ):
        points[row + 1, axis] += np.radians(degrees)
    return points


@pytest.mark.slow(after=3)
@pytest.mark.parametrize("kind", ["harbour", "coast", "street"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_synthetic(scene, kind, seed):
    given_scene = scene(kind, seed)
    prepared = prepare(given_scene.rig, given_scene.pairs, view(given_scene.rig))
    found = counts(prepared, turned(given_scene.rig), SAD(num_disparities=48))
    assert found[1:].max() < found[0]


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
