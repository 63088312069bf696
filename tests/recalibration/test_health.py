"""One look at a calibration: will depth be right, what would mend it, and what is said where nothing can be."""

import json
from dataclasses import replace

import jax
import numpy as np
import pytest

from stereorecal import recalibrate
from stereorecal.decision import Decision, Verdict
from stereorecal.geometry import Camera
from stereorecal.matching import SAD, SGBM
from stereorecal.recalibration import Condition, Health, Interval, Reason, health
from stereorecal.recordings import Pair, make_pair
from stereorecal.scoring import ImageQuality, image_quality
from stereorecal.scoring.host import Score, score
from stereorecal.synthetic import decalibrate

SAD_48 = SAD(num_disparities=48)
SIZE = (320, 240)
DAYLIGHT = ImageQuality(120.0, 0.8)


@pytest.fixture
def under(scene):
    """under(pitch, yaw, roll): the health of a rendered rig that is turned so many degrees from the truth."""

    def look(pitch: float = 0.0, yaw: float = 0.0, roll: float = 0.0, matcher=SAD_48, prior=None) -> Health:
        given = scene("harbour", 0, SIZE)
        turned = given.rig.extrinsics + np.array([*np.radians([pitch, yaw, roll]), 0, 0, 0])
        return health(given.rig.with_extrinsics(turned), given.pairs, matcher=matcher, prior=prior)

    return look


@pytest.mark.parametrize("matcher", [SAD_48, SGBM(num_disparities=48)], ids=["sad", "sgbm"])
def test_the_truth_is_healthy(under, matcher):
    found = under(matcher=matcher)
    assert found.condition is Condition.HEALTHY
    assert found.healthy
    assert found.row_error < 0.15
    assert found.covered > 0.4
    for axis in found.correction.axes.values():
        assert axis.low - 0.1 < 0 < axis.high + 0.1


@pytest.mark.slow(after=3)
@pytest.mark.parametrize("axis", ["pitch", "yaw", "roll"])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_axis_that_is_off_is_named(under, axis, sign):
    degrees = {"pitch": 0.1, "yaw": 0.5, "roll": 0.2}[axis]
    found = under(**{axis: sign * degrees}, prior="exact")
    assert found.condition is Condition.REPAIR
    assert axis in found.correction.main_axes
    assert axis in found.verdict
    assert found.correction.axes[axis].value == pytest.approx(-sign * degrees, rel=0.15)


@pytest.mark.parametrize("axis", ["pitch", "yaw", "roll"])
def test_the_axis_that_is_off_is_named_though_its_interval_is_wide(under, axis):
    """Of one pair, principal points may be what a pitch or a yaw seems to be: no axis but roll is known surely."""
    found = under(**{axis: {"pitch": 0.1, "yaw": 0.5, "roll": 0.2}[axis]})
    assert found.correction.main_axes[0] == axis
    assert f"repair it: {axis}" in found.verdict


def test_wrong_yaw_is_wrong_depth(under):
    """0.5 degrees are 0.0087 focal lengths of disparity; 30 baselines show 0.033."""
    for sign in (1, -1):
        error = under(yaw=0.5 * sign, prior="exact").correction.depth_percent[30]
        assert error.low < error.value < error.high
        assert abs(1 / (1 + error.value / 100) - 1) == pytest.approx(30 * np.radians(0.5), rel=0.15)


@pytest.mark.parametrize("pitch", [-2.0, 0.8, 2.0])
def test_far_out_it_is_to_be_repaired(under, pitch):
    found = under(pitch)
    assert found.score.fraction > 0.15
    assert found.condition is Condition.REPAIR
    assert found.correction is None
    assert np.isnan(found.row_error)


def test_the_score_is_that_of_score(scene, under):
    given = scene("harbour", 0, SIZE)
    assert under().score == score(given.rig, given.pairs, matcher=SAD_48)


@pytest.mark.parametrize(("yaw", "apart"), [(0.0, 0.02), (0.3, 0.1)])
def test_the_row_error_is_measured_as_that_of_a_repair(scene, under, yaw, apart):
    """Of the matches that each finds: the same where the rig is true, and nearly so where it is not."""
    given = scene("harbour", 0, SIZE)
    off = given.rig.with_extrinsics(given.rig.extrinsics + np.array([0, np.radians(yaw), 0, 0, 0, 0]))
    rows = recalibrate(off, given.pairs, matcher=SAD_48).row_errors
    assert rows is not None
    assert under(yaw=yaw).row_error == pytest.approx(rows.before, abs=apart)


@pytest.mark.parametrize(("gain", "why"), [(0.03, "too dark"), (0.0, "too little texture")])
def test_night_and_fog_are_no_alarm(scene, gain, why):
    given = scene("harbour", 0, SIZE)
    noise = np.random.default_rng(0)

    def spoiled(image):
        grey = gain * np.asarray(image) + (4.0 if gain else 128.0) + noise.normal(0, 2, image.shape)
        return np.clip(np.round(grey), 0, 255).astype(np.float32)

    (pair,) = given.pairs
    found = health(given.rig, [Pair(spoiled(pair.left), spoiled(pair.right))], matcher=SAD_48)
    assert found.condition is Condition.CANNOT_TELL
    assert why in found.verdict


def test_nothing_to_match(scene):
    fog = np.full((240, 320), 128.0, np.float32)
    fog[0, 0] = 129.0
    found = health(scene("harbour", 0, SIZE).rig, [Pair(fog, fog[::-1].copy())], matcher=SAD_48)
    assert found.condition is Condition.CANNOT_TELL
    data = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert data["row_error_px"] is None
    assert data["correction"] is None
    assert data["count"] == 0


def test_images_of_few_grey_levels_are_not_called_good(scene):
    """Rounding moves what matches, here by the .8 px that the rows are off; nothing else shows it."""
    given = scene("street", 5, SIZE)
    drifted = decalibrate(given.rig, jax.random.key(7), 0.5, 0.01)
    (pair,) = given.pairs
    few = Pair(np.rint(np.asarray(pair.left) / 64), np.rint(np.asarray(pair.right) / 64))
    assert image_quality(few).coarse
    assert not image_quality(pair).coarse
    assert health(drifted, [few]).condition is Condition.CANNOT_TELL
    assert recalibrate(drifted, [few]).reason is Reason.TOO_LITTLE_TEXTURE


def test_wider_images_with_an_offset_have_grey_levels_enough(scene):
    """As those of thermal cameras: of white they take a few hundredths."""
    given = scene("harbour", 0, SIZE)
    (pair,) = given.pairs
    left, right = ((29300 + np.asarray(image) / 255.0 * 1100).astype(np.uint16) for image in (pair.left, pair.right))
    assert not image_quality(make_pair(left, right)).coarse


def about(value: float, half: float) -> Interval:
    return Interval(value, value - half, value + half)


@pytest.fixture(scope="module")
def looked(scene) -> Health:
    given = scene("harbour", 0, SIZE)
    return health(given.rig, given.pairs, matcher=SAD_48)


def judged(looked: Health, verdict: Verdict, after: float = 0.1) -> Health:
    """A look with a correction that is made up."""
    axes = {name: about(0.0, 1.0) for name in ("pitch", "roll", "y", "z")} | {"yaw": about(1.0, 0.5)}
    rows = np.array([[0.2, 0.1, 0.3], [after, 0.0, 2.0 * after]])
    decision = Decision(verdict, np.zeros(5), False, 0.5, 0.5, 0.0, rows)
    depths = dict.fromkeys((5, 10, 30, 100), about(0.0, 1.0))
    made_up = {"axes": axes, "rows_px": about(0.2, 0.1), "depth_percent": depths, "main_axes": ("yaw",)}
    return replace(
        looked, covered=0.5, correction=replace(looked.correction, decision=decision, row_error=0.1, **made_up)
    )


@pytest.mark.parametrize(
    ("verdict", "after", "condition", "said"),
    [
        (Verdict.GOOD, 0.1, Condition.HEALTHY, "healthy"),
        (Verdict.REPAIR, 0.1, Condition.REPAIR, "yaw"),
        (Verdict.CANNOT_TELL, 0.1, Condition.CANNOT_TELL, "more frames"),
        (Verdict.CANNOT_TELL, 0.5, Condition.CANNOT_TELL, "four scenes or more"),
    ],
)
def test_it_says_what_the_decision_says(looked, verdict, after, condition, said):
    found = judged(looked, verdict, after)
    assert found.condition is condition
    assert found.healthy == (condition is Condition.HEALTHY)
    assert str(found).startswith(f"{condition.value}")
    assert said in found.verdict
    assert found.as_dict()["axes"] == (["yaw"] if condition is Condition.REPAIR else [])


@pytest.mark.parametrize(
    ("shown", "condition"),
    [
        (DAYLIGHT, Condition.REPAIR),
        (ImageQuality(19.0, 0.8), Condition.CANNOT_TELL),
        (ImageQuality(120.0, 0.3), Condition.CANNOT_TELL),
    ],
)
def test_where_hardly_anything_matches(shown, condition):
    assert Health(Score(1, 2), float("nan"), 0.0, shown, None).condition is condition


def test_more_frames_are_one_look(scene):
    given = scene("harbour", 0, SIZE, 2)
    found = health(given.rig, given.pairs, matcher=SAD_48)
    assert found.healthy
    assert found.score.pixels == 2 * SIZE[0] * SIZE[1]
    assert replace(found, correction=None).condition is Condition.REPAIR


@pytest.mark.parametrize("counts", [40.0, 0.5])
def test_a_covered_lens_is_no_alarm(scene, counts):
    """Images of 16 bit and of floating point are stretched to full contrast, and so is their noise."""
    given, draw = scene("harbour", 0, SIZE), np.random.default_rng(1)

    def covered(shape) -> np.ndarray:
        dark = np.abs(draw.normal(0, counts, shape))
        return np.round(dark).astype(np.uint16) if counts > 1 else (dark / 65535.0).astype(np.float32)

    shape = (SIZE[1], SIZE[0])
    found = health(given.rig, [make_pair(covered(shape), covered(shape))], matcher=SAD_48)
    assert found.condition is Condition.CANNOT_TELL
    assert "noise" in found.verdict


@pytest.mark.parametrize("factor", [10.0, 0.1])
def test_a_focal_length_ten_times_off_is_named(scene, factor):
    given = scene("harbour", 0, SIZE)
    left, right = (
        Camera(camera.size, np.asarray(camera.matrix) * [[factor, 1, 1], [1, factor, 1], [1, 1, 1]], camera.distortion)
        for camera in (given.rig.left, given.rig.right)
    )
    found = health(replace(given.rig, left=left, right=right), given.pairs, matcher=SAD_48)
    assert found.condition is not Condition.REPAIR
    assert any("view of" in doubt and "check fx" in doubt for doubt in found.doubts)
    assert "check fx" in str(found)
    assert found.as_dict()["doubts"] == list(found.doubts)


def test_centimetres_for_metres_are_named(scene):
    given = scene("harbour", 0, SIZE)
    far = given.rig.with_extrinsics(given.rig.extrinsics * np.array([1, 1, 1, 100, 100, 100]))
    found = health(far, given.pairs, matcher=SAD_48)
    assert "check the unit" in str(found)
    assert not health(given.rig, given.pairs, matcher=SAD_48).doubts
