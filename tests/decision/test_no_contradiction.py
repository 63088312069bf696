"""`health` and `recalibrate` never contradict each other, on real scenes as on rendered ones."""

import numpy as np
import pytest

import stereorecal as sr
from stereorecal.recalibration import Condition, Reason

SCENES = (
    *("oak_d/desk", "kitti2012/000000_10", "kitti2015/000001_10"),
    *("oak_d/selfie", "oak_d/toy", "oak_d/cycles", "boofcv_bumblebee2/garden01", "boofcv_bumblebee2/stones01"),
    *("drobotics_wide/office_050", "simplestereo/guitar_room", "middlebury2014/motorcycle_quarter"),
    *("euroc/vicon_room_seq", "kitti_odometry/suburb_seq"),
)


def agree(rig: sr.StereoRig, pairs) -> None:
    said, done = sr.health(rig, pairs), sr.recalibrate(rig, pairs)
    if said.condition is Condition.HEALTHY:
        assert done.rig is rig
        assert done.reason is Reason.ALREADY_GOOD
    if done.accepted:
        assert said.condition is not Condition.HEALTHY
    if said.condition is Condition.REPAIR and said.correction is not None:
        assert done.accepted
    if done.row_errors is not None and said.condition is Condition.HEALTHY:
        assert done.row_errors.before == pytest.approx(said.row_error, abs=0.01)  # one number, whoever prints it


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", SCENES)
def test_real_scenes(data_dir, name):
    scene = sr.io.load_scene(data_dir / name)
    agree(scene.rig, scene.pairs[:1])


@pytest.mark.slow(after=3)
@pytest.mark.parametrize("degrees", [0.0, 0.05, 0.3, 0.1])
def test_rendered_scenes(scene, degrees):
    given = scene("street", 2, (320, 240))
    drift = np.array([*np.radians(np.array([0.6, -1.0, 0.8]) * degrees), 0, 0, 0])
    agree(given.rig.with_extrinsics(given.rig.extrinsics + drift), given.pairs)
