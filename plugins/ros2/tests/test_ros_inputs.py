"""What comes in: what can be used is handed over, and all else is counted and told, once."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from robots import SIZE, image, message_of
from stereorecal_ros import LEFT, RIGHT, Level, corrected

from stereorecal.online import Event, Kind


def test_what_it_cannot_follow_is_dropped_and_counted(robot):
    one = robot()
    one.see(2)
    one.work.ready = False
    one.see(20)
    assert len(one.work.pairs) == 2  # the first pair came before there was a worker
    assert one.watch.status().values["pairs dropped, which could not be followed"] == "21"
    assert one.watch.status().values["pairs"] == "23"


def compressed(ending: str, kind: type = np.uint8) -> SimpleNamespace:
    """As `CompressedImage`, which has no encoding."""
    pixels = np.random.default_rng(0).integers(0, 255, SIZE[::-1]).astype(kind)
    return SimpleNamespace(format=ending[1:], data=cv2.imencode(ending, pixels)[1].tobytes())


ENCODINGS = {
    "mono8": image(),
    "mono16": image(encoding="mono16", depth=2),
    "bgr8": image(encoding="bgr8", channels=3),
    "rgb8": image(encoding="rgb8", channels=3),
    "bgra8": image(encoding="bgra8", channels=4),
    "bayer_rggb8": image(encoding="bayer_rggb8"),
    "bayer_gbrg16": image(encoding="bayer_gbrg16", depth=2),
    "jpeg": compressed(".jpg"),
    "png, mono16": compressed(".png", np.uint16),
}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_encodings_become_grey(robot, encoding: str):
    one = robot()
    for side in (LEFT, RIGHT):
        one.watch.image(side, 10**12, ENCODINGS[encoding])
    ((left, right, _),) = one.work.pairs
    assert left.shape == right.shape == SIZE[::-1]
    assert left.dtype == (np.uint16 if "16" in encoding else np.uint8)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"encoding": "nv21"}, "encoding nv21 is not known"),
        ({"encoding": "32FC1"}, "encoding 32FC1 is not known"),
        ({"encoding": "rgb8"}, "cut short"),
        ({"width": 0}, "cut short"),
        ({"height": 0}, "cut short"),
        ({"data": np.zeros(5, np.uint8)}, "cut short"),
        ({"size": (32, 24)}, "the image is 32x24, and the calibration of 64x48"),
    ],
)
def test_images_that_cannot_be_used_are_told_once(robot, changes, said):
    one = robot()
    one.see(50, **changes)
    assert one.work.pairs == []
    assert sum(said in text for _, text in one.log) == 1
    status = one.watch.status()
    assert status.values["pairs refused"] == "50"
    assert said in status.message
    assert status.level is Level.STALE
    one.see()
    assert said not in one.watch.status().message


def test_pairs_that_the_worker_cannot_use_are_told_once(robot):
    """Such as those of topics that are exchanged: every pair is refused with the same words."""
    one = robot()
    assert one.watch.status().message == "no pair has been evaluated yet"
    for number in range(30):
        one.work.events.append(Event(number, Kind.BAD_FRAME, "left and right look exchanged"))
        one.see()
    assert sum("look exchanged" in text for _, text in one.log) == 1
    assert (
        "images that can be used (the pair cannot be used: left and right look exchanged)" in one.watch.status().message
    )
    one.work.state = one.work.state.replace(seen=1)
    one.see()
    assert one.watch.status().values["missing"] == "nothing"


def test_a_topic_that_is_silent_is_named(blank):
    one = blank()
    assert one.watch.status().level is Level.STALE
    assert "left/image_raw, right/image_raw, left/camera_info, right/camera_info" in one.watch.status().message
    one.calibrate()
    for number in range(100):
        one.now += 0.1
        one.watch.image(LEFT, number * 100_000_000, image())
    assert "missing: right/image_raw, left/camera_info, right/camera_info" in one.watch.status().message
    one.see(30, apart=20_000_000)
    assert "stamps are" in one.watch.status().message
    assert "tolerance is 5.0 ms" in one.watch.status().message
    one.see()
    assert one.watch.status().values["missing"] == "nothing"


@pytest.mark.parametrize("sides", [(LEFT,), (LEFT, RIGHT)])
def test_stamps_that_stay_the_same_are_named(blank, sides):
    """As of a driver that does not stamp its images: all are of time 0."""
    one = blank()
    one.calibrate()
    for number in range(40):
        one.now += 0.1
        one._inform()
        for side in (LEFT, RIGHT):
            one.watch.image(side, 0 if side in sides else number * 10**8, image())
    one.stamp = 10**11
    names = " and ".join(f"{name}/image_raw" for name in ("left", "right")[: len(sides)])
    assert f"missing: stamps of {names} (they stay the same" in one.watch.status().message
    one.see()
    assert one.watch.status().values["missing"] == "nothing"


def test_time_that_jumps_back_is_told(robot):
    one = robot()
    one.see(19)
    one.stamp = 0
    one.see(20)
    assert one.said("jumped back in time")
    assert one.watch.status().values["jumps back in time"] == "1"
    assert one.watch.status().values["pairs"] == "40"


def test_pairs_have_the_times_of_their_stamps(blank):
    one = blank()
    one.calibrate()
    one.watch.poll()
    one.see(2)
    assert [time for _, _, time in one.work.pairs] == pytest.approx([0.1, 0.2])


def test_camera_info_that_is_none(blank):
    one = blank()
    left, right = corrected(one.rig)
    one.watch.camera_info(LEFT, message_of(left, binning_x=2))
    assert one.said("left/camera_info", "binned")
    one.watch.camera_info(LEFT, message_of(left))
    one.watch.camera_info(RIGHT, message_of(right, k=(0.0,) * 9))
    one.see(30)
    assert one.works == []
    assert one.watch.corrected is None
    assert one.said("right/camera_info", "not calibrated")
    one.calibrate()
    one.see(30)
    assert len(one.works) == 1


def test_a_recalibration_rests_on_other_views_of_one_rig(blank):
    one = blank()
    assert not one.watch.recalibrate()[0]
    one.calibrate()
    one.watch.poll()
    assert "no recent pair" in one.watch.recalibrate()[1]
    one.see(45)
    done, said = one.watch.recalibrate()
    assert done
    assert "last 4 pairs" in said
    assert len(one.work.changes[-1].keywords["pairs"]) == 4
    assert one.watch.recalibrate() == (False, "a recalibration is under way.")
    one.work.events.append(Event(45, Kind.REJECTED, "no candidate"))
    one.work.events.append(Event(46, Kind.KNOCK))
    one.watch.poll()
    assert "no recent pair" in one.watch.recalibrate()[1]  # that shows the knocked rig
    one.see()
    assert one.watch.recalibrate()[0]


def test_a_recalibration_rests_on_no_old_pairs(blank):
    """Whatever their stamps say; the cameras may have been off, and the rig was knocked meanwhile."""
    one = blank()
    one.calibrate()
    one.watch.poll()
    one.see(25)
    one.now += 28.0
    done, said = one.watch.recalibrate()
    assert done
    assert "last 2 pairs" in said
    one.work.events.append(Event(45, Kind.REJECTED, "no candidate"))
    one.watch.poll()
    one.now += 2.0
    done, said = one.watch.recalibrate()
    assert not done
    assert said.startswith("no recent pair")
