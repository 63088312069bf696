"""`health` and `recalibrate` never contradict each other, on real scenes as on rendered ones."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.recalibration import Condition, Reason

SCENES = (
    *("oak_d/desk", "kitti2012/000000_10", "kitti2015/000001_10"),
    *("oak_d/selfie", "oak_d/toy", "oak_d/cycles", "boofcv_bumblebee2/garden01", "boofcv_bumblebee2/stones01"),
    *("drobotics_wide/office_050", "simplestereo/guitar_room", "middlebury2014/motorcycle_quarter"),
    *("euroc/vicon_room_seq", "kitti_odometry/suburb_seq"),
)


def agree(rig: sr.StereoRig, pairs) -> sr.Solution:
    """Both of the same rig and images."""
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
    return done


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("name", SCENES)
def test_real_scenes(data_dir, name):
    scene = sr.io.load_scene(data_dir / name)
    agree(scene.rig, scene.pairs[:1])


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("prior", [None, "exact"])
def test_chance_matches_make_no_rig_good(data_dir, prior):
    """Seven frames of a room under a rig two degrees off: what matches by chance covers an eighth of the image."""
    scene = sr.io.load_scene(data_dir / "euroc/vicon_room_seq", limit=7)
    drift = np.array([*np.radians([-1.17, 1.17, 2.27]), 0.0, *(0.01 * scene.rig.baseline * np.array([-2.21, 1.42]))])
    far = scene.rig.with_extrinsics(scene.rig.extrinsics + drift)
    done = sr.recalibrate(far, scene.pairs, prior=prior)
    assert done.accepted
    assert np.abs(np.degrees(done.rig.extrinsics - scene.rig.extrinsics)[[0, 2]]).max() < 0.1


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", ["street", "harbour"])
@settings(max_examples=3, deadline=None)
@given(
    degrees=st.sampled_from([0.0, 0.02, 0.05, 0.1, 0.3, 1.0]),
    axis=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda axis: np.linalg.norm(axis) > 0.1),
)
def test_rendered_scenes(scene, degrees, axis, kind):
    shown = scene(kind, 2, (320, 240))
    turn = np.radians(degrees) * np.array(axis) / np.linalg.norm(axis)
    used = shown.rig.with_extrinsics(shown.rig.extrinsics + np.append(turn, np.zeros(3)))
    done = agree(used, shown.pairs)
    if done.accepted:  # what was written is good, to the same images and to others
        assert sr.health(done.rig, scene("street", 1, (320, 240)).pairs).condition is not Condition.REPAIR
        again = sr.recalibrate(done.rig, shown.pairs, prior=done.prior)
        assert not again.accepted
