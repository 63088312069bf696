"""One look at a calibration: will depth be right, what would mend it, and what is said where nothing can be."""

from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest
from fixtures import SAD_48

from stereorecal import Solution, recalibrate
from stereorecal.matching import SGBM
from stereorecal.recalibration import Condition, Interval, Reason, health
from stereorecal.recordings import Pair
from stereorecal.scoring import image_quality
from stereorecal.synthetic import decalibrate, photographs, plan_drive

SIZE = (320, 240)


@pytest.fixture
def under(scene):
    """under(pitch, yaw, roll): the health of a rendered rig that is turned so many degrees from the truth."""

    def look(pitch: float = 0.0, yaw: float = 0.0, roll: float = 0.0, matcher=SAD_48, prior=None) -> Solution:
        shown = scene("harbour", 0, SIZE)
        turned = shown.rig.extrinsics + np.array([*np.radians([pitch, yaw, roll]), 0, 0, 0])
        return health(shown.rig.with_extrinsics(turned), shown.pairs, matcher=matcher, prior=prior)

    return look


def corrections(found: Solution) -> np.ndarray:
    """The changes of the parameters of its uncertainty, in degrees and percent."""
    return found.decision.theta[[found.estimate.names.index(name) for name in found.uncertainty.names]]


@pytest.mark.parametrize("matcher", [SAD_48, SGBM(num_disparities=48)], ids=["sad", "sgbm"])
def test_the_truth_is_healthy(under, matcher):
    found = under(matcher=matcher)
    assert found.condition is Condition.HEALTHY
    assert found.healthy
    assert found.row_errors.before < 0.15
    assert found.covered > 0.4
    assert (np.abs(corrections(found)) < found.uncertainty.interval + 0.1).all()


@pytest.mark.slow(after=3)
@pytest.mark.parametrize("axis", ["pitch", "yaw", "roll"])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_axis_that_is_off_is_named(under, axis, sign):
    degrees = {"pitch": 0.1, "yaw": 0.5, "roll": 0.2}[axis]
    found = under(**{axis: sign * degrees}, prior="exact")
    assert found.condition is Condition.REPAIR
    assert axis in found.main_axes
    assert axis in found.to_dict()["main_axes"]
    assert corrections(found)[found.uncertainty.names.index(axis)] == pytest.approx(-sign * degrees, rel=0.15)


def test_wrong_yaw_is_wrong_depth(under):
    """0.5 degrees are 0.0087 focal lengths of disparity straight ahead, a tenth more over the view; 30 baselines show
    0.033."""
    for sign in (1, -1):
        estimate = under(yaw=0.5 * sign, prior="exact").estimate
        error = Interval(*estimate.depth_error_percent(np.zeros(len(estimate.names)))[30])
        assert error.low < error.value < error.high
        assert abs(1 / (1 + error.value / 100) - 1) == pytest.approx(1.1 * 30 * np.radians(0.5), rel=0.15)


@pytest.mark.parametrize("pitch", [-2.0, 0.8])
def test_the_correction_of_a_rig_that_is_degrees_off_is_told(under, pitch):
    """It looks from where a survey of the rotation ends, and says by how much the given one is off."""
    found = under(pitch)
    assert found.score_before.fraction > 0.15
    assert found.condition is Condition.REPAIR
    assert found.accepted
    assert "pitch" in found.main_axes
    at = found.uncertainty.names.index("pitch")
    assert corrections(found)[at] == pytest.approx(-pitch, abs=0.02 + found.uncertainty.interval[at])


def test_images_of_few_grey_levels_are_not_called_good(scene):
    """Rounding moves what matches, here by the .8 px that the rows are off; nothing else shows it."""
    shown = scene("street", 5, SIZE)
    drifted = decalibrate(shown.rig, jax.random.key(7), 0.5, 0.01)
    (pair,) = shown.pairs
    few = Pair(np.rint(np.asarray(pair.left) / 64), np.rint(np.asarray(pair.right) / 64))
    assert image_quality(few).coarse
    assert not image_quality(pair).coarse
    assert health(drifted, [few], matcher=SAD_48).condition is Condition.CANNOT_TELL
    assert recalibrate(drifted, [few], matcher=SAD_48).reason is Reason.TOO_LITTLE_TEXTURE


def test_what_is_noticed_names_axes(scene):
    """Where nothing is, one axis is named: the first. What is matched does not depend on it."""
    shown = scene("harbour", 0, (320, 240))
    off = shown.rig.with_extrinsics(shown.rig.extrinsics + np.radians([-0.3, 0.1, 0.2, 0.0, 0.0, 0.0]))
    named = []
    for tolerances in (None, {"rows_px": 1e-6}, {"rows_px": 1e6, "depth_points": 1e6}):
        found = recalibrate(off, shown.pairs, matcher=SAD_48, tolerances=tolerances, prior="exact")
        named.append(len(found.main_axes))
        assert found.cost.judging == pytest.approx(2.0)
    assert named[1:] == [5, 1]
    assert 1 <= named[0] < 5


@pytest.mark.parametrize("k1", [0.0, 0.06])
def test_images_are_matched_again_where_the_estimate_moves_their_rows(scene, k1):
    """The look's own fit moves extrinsics alone."""
    shown = scene("harbour", 0, (320, 240))
    distortion = np.asarray(shown.rig.right.distortion) + np.append(k1, np.zeros(len(shown.rig.right.distortion) - 1))
    off = replace(shown.rig, right=replace(shown.rig.right, distortion=distortion))
    found = recalibrate(off, shown.pairs, matcher=SAD_48)
    assert found.cost.judging - 2.0 in ((1.0, 2.0) if k1 else (0.0,))


@pytest.mark.slow
def test_a_dozen_pairs_of_one_drive_tell_what_one_does(tmp_path: Path):
    """They err together: neither are lenses bent to explain that, nor does depth become less known than by one."""
    drive = plan_drive("street", 2, 12, weather=False)
    true = drive.truth(0)
    pitched = true.with_extrinsics(np.asarray(true.extrinsics) + np.radians([0.3, 0.0, 0.0, 0.0, 0.0, 0.0]))
    pairs = list(photographs(drive, folder=tmp_path))
    found, of_one = health(pitched, pairs), health(pitched, pairs[:1])
    assert found.condition is Condition.REPAIR
    assert all(error.percent.low < 0.0 < error.percent.high for error in found.depth)
    for error, other in zip(found.depth, of_one.depth, strict=True):
        assert error.percent.high - error.percent.low < 1.1 * (other.percent.high - other.percent.low)
