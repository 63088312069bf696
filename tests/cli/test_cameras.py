"""`monitor --camera`, with files that pose as cameras."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from rides import Ride

import stereorecal as sr
from stereorecal.io import camera_pairs, save_rig
from stereorecal.online import load
from stereorecal.recordings import Pair

SIZE = (320, 240)


def film(path: Path, images, rate: float = 10.0) -> Path:
    """A video, with next to no loss."""
    height, width = images[0].shape
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), rate, (width, height))
    for image in images:
        video.write(cv2.cvtColor(np.clip(np.rint(image), 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR))
    video.release()
    return path


@pytest.fixture(scope="module")
def cameras(drive: Ride, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with left.avi, right.avi, both.avi side by side, and rig.json. It begins with a black pair, as cameras
    that are switched on do."""
    folder, black = tmp_path_factory.mktemp("cameras"), np.zeros(SIZE[::-1], np.float32)
    left, right = ([black, *(getattr(pair, side) for pair in drive.pairs)] for side in ("left", "right"))
    film(folder / "left.avi", left)
    film(folder / "right.avi", right)
    film(folder / "both.avi", [np.hstack(pair) for pair in zip(left, right, strict=True)])
    save_rig(drive.rig, folder / "rig.json")
    return folder


def test_some_of_the_pairs(command, cameras: Path, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(cameras)
    words = ("--calibration", "rig.json", "--state", tmp_path / "state", "--once", "--quiet", "--pairs", "2:6:2")
    command("monitor", "--camera", "left.avi,right.avi", *words)
    assert load(tmp_path / "state").frame == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--camera", "99", "--calibration", "rig.json"), "camera 99: cannot be opened"),
        (("--camera", "left.avi,right.avi"), "--camera needs --calibration"),
        (("--camera", "left.avi,none.avi", "--calibration", "rig.json"), "camera none.avi: cannot be opened"),
        (("--camera", "0,", "--calibration", "rig.json"), "give one name, or two"),
        (("--camera", "0", "--left", "left.avi", "--calibration", "rig.json"), "leave the others out"),
        (("--camera", "0", "--limit", "3", "--calibration", "rig.json"), "leave the others out"),
        (("--camera", "0", "--tolerance", "nan", "--calibration", "rig.json"), "--tolerance is nan"),
        (("--camera", "left.avi,both.avi", "--calibration", "rig.json"), "none can be used"),
        (("--camera", "left.avi", "--calibration", "rig.json"), "160x240"),
        (("--camera", "left.avi,right.avi", "--calibration", "no.json"), "there is no such file"),
        (("--camera", "left.avi,right.avi", "--calibration", "rig.json", "--output", "left.avi"), "left.avi"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_what_cannot_be_watched_is_refused(command, cameras: Path, monkeypatch, words, said):
    monkeypatch.chdir(cameras)
    command("monitor", *words, "--force").refuses(said)


@pytest.mark.skipif("GStreamer:                   NO" not in cv2.getBuildInformation(), reason="GStreamer is there")
def test_pipelines(command, cameras: Path):
    """What GStreamer makes of one is its own; that there is none is said."""
    pipeline = "v4l2src device=/dev/video0 ! video/x-raw,width=640 ! videoconvert ! appsink"
    answer = command("monitor", "--camera", pipeline, pipeline, "--calibration", cameras / "rig.json")
    answer.refuses("built without GStreamer")


def test_frames_that_lie_apart(cameras: Path, tmp_path: Path, drive: Ride):
    """By the times of the files: one runs at ten images a second, the other at seven."""
    slow = film(tmp_path / "slow.avi", [pair.right for pair in drive.pairs], rate=7.0)
    names = [str(cameras / "left.avi"), str(slow)]
    assert len(list(camera_pairs(names))) == len(drive.pairs)
    assert len(list(camera_pairs(names, 0.1))) == 3
    near = list(camera_pairs([str(cameras / "left.avi"), str(cameras / "right.avi")], 1e-6))
    assert not isinstance(near[0], Pair)  # black
    assert all(isinstance(pair, Pair) for pair in near[1:])


def test_an_odd_width_cannot_be_halved(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 63), np.uint8))
    with pytest.raises(sr.InputError, match=r"%d\.png: the image is 63 pixels wide, which cannot be halved"):
        next(camera_pairs([str(tmp_path / "%d.png")]))


def test_a_camera_that_is_unplugged(monkeypatch):
    """Anything that is no file is expected to go on."""

    real = cv2.VideoCapture

    class Capture:  # it says that it is a capture; one that inherits from OpenCV's crashes Python when it is collected
        frames, __class__ = 0, property(lambda self: real)

        def __init__(self, name, *options):
            assert name == 0

        def isOpened(self):
            return True

        def set(self, *options):
            return False

        def get(self, what):
            return float("nan")

        def grab(self):
            self.frames += 1
            return self.frames < 4

        def retrieve(self):
            return True, np.random.default_rng(self.frames).integers(0, 255, (48, 128, 3), np.uint8)

        def release(self):
            self.released = True

    monkeypatch.setattr(cv2, "VideoCapture", Capture)
    coming = camera_pairs(["0"])
    assert [next(coming).left.shape for _ in range(3)] == [(48, 64)] * 3
    with pytest.raises(sr.InputError, match="camera 0: sends no images any more, after 3"):
        next(coming)
