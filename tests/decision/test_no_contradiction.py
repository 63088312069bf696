"""`health` and `recalibrate` never contradict each other, on real scenes as on rendered ones."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.estimation import points_of_view, readings
from stereorecal.recalibration import Condition

SCENES = ("oak_d/desk", "oak_d/toy", "kitti2012/000000_10", "boofcv_bumblebee2/stones01", "kitti_odometry/suburb_seq")


def agree(rig: sr.StereoRig, pairs) -> sr.Solution:
    """Both of the same rig and images."""
    said, done = sr.health(rig, pairs), sr.recalibrate(rig, pairs)
    if said.condition is Condition.HEALTHY:
        assert (done.rig, done.reason) == (rig, said.reason)
        assert done.row_errors is None or done.row_errors.before == pytest.approx(said.row_error, abs=0.01)
    if done.accepted:
        assert said.condition is not Condition.HEALTHY
    if said.condition is Condition.REPAIR and said.correction is not None:
        assert done.accepted
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
    done, points = sr.recalibrate(far, scene.pairs, prior=prior), points_of_view(scene.rig, 10)
    assert done.accepted
    rows = [np.median(np.abs(readings(rig, scene.rig, points)[0])) for rig in (done.rig, far)]
    assert rows[0] < 0.05 * rows[1]  # the stored rig is right to some tenths of a pixel


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
    done = agree(shown.rig.with_extrinsics(shown.rig.extrinsics + np.append(turn, np.zeros(3))), shown.pairs)
    if done.accepted:  # what was written is good, to the same images and to others
        assert sr.health(done.rig, scene("street", 1, (320, 240)).pairs).condition is not Condition.REPAIR
        assert not sr.recalibrate(done.rig, shown.pairs, prior=done.prior).accepted
