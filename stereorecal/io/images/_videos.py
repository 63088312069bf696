"""Videos, and live cameras (devices, streams, GStreamer pipelines; or files in place of them), read by OpenCV."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.io.images._frame_source import FrameSource, Image, halved
from stereorecal.io.images._image_files import MOST_PIXELS, quiet_opencv
from stereorecal.recordings import Images, Pair, make_pair

_SUFFIXES = (".avi", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".ogv", ".ts", ".webm", ".wmv")


def is_video(path: Path) -> bool:
    """Whether the name is that of a video."""
    return path.suffix.lower() in _SUFFIXES


def video_source(path: Path) -> FrameSource:
    """The frames of a video, named by their number; their times follow from the frame rate."""
    video = _Video(path)
    names = tuple(f"{path.name} {number:06d}" for number in range(video.frames))
    return FrameSource(str(path), names, np.arange(video.frames) / video.rate, video.read)


def _captured(source: str | int, else_say: str, kind: int = cv2.CAP_ANY) -> cv2.VideoCapture:
    """What OpenCV opens, with images as they were taken, which is what the calibration knows."""
    with quiet_opencv():
        capture = cv2.VideoCapture(source, kind)
    if not capture.isOpened():
        raise InputError(else_say)
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    return capture


class _Video:
    """An open video. Frames that are read in order are decoded once: seeking is not exact in every format."""

    def __init__(self, path: Path):
        self.path = path
        self._open()
        self.rate = self._video.get(cv2.CAP_PROP_FPS)
        self.frames = int(self._video.get(cv2.CAP_PROP_FRAME_COUNT))
        width, height = (self._video.get(what) for what in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        if self.frames > path.stat().st_size:
            raise InputError(
                f"{path}: the video claims {self.frames} frames, more than such a file can hold; copy or convert it."
            )
        if width * height > MOST_PIXELS:
            raise InputError(
                f"{path}: frames of {width:.0f}x{height:.0f} are too large; convert the video to smaller ones."
            )
        if self.frames < 1 or not self.rate > 0.0:
            raise InputError(f"{path}: the video does not say how many frames it has, or their rate; convert it.")

    def _open(self) -> None:
        if not self.path.is_file():
            raise InputError(f"{self.path}: there is no such file; check the path.")
        # FFmpeg's own lines about damaged videos; OpenCV asks once, when it first needs FFmpeg.
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        self._video = _captured(
            str(self.path), f"{self.path}: not a video that OpenCV can read, or a damaged one; convert it."
        )
        self._next = 0

    def read(self, number: int) -> Image:
        """The image of a frame."""
        if number < self._next:
            self._video.release()
            self._open()
        with quiet_opencv():
            while self._next < number and self._video.grab():
                self._next += 1
            found, image = self._video.read() if self._next == number else (False, None)
        if not found or image is None:
            raise InputError(
                f"{self.path}: frame {self._next} of {self.frames} cannot be decoded; the video is damaged or cut: "
                f"use the frames before it (--to {self._next}), or copy it again."
            )
        self._next = number + 1
        return image


_MOST_APART = 100  # pairs in a row whose frames are too far apart in time


def camera_pairs(names: Sequence[str], tolerance: float | None = None) -> Iterator[Pair | Images]:
    """The pairs of two cameras, or of one that shows both images side by side, as they come; it ends when a file does.

    A frame of each camera is grabbed before either is decoded. A pair that cannot be used, such as a black one, comes
    as two arrays.

    Args:
        names: of one or two: the number of a device, the path of one or of a video, the address of a stream, or a
            GStreamer pipeline that ends in appsink.
        tolerance: the largest difference of the cameras' own times [s] within a pair, default any; others are left out.

    Raises:
        InputError: if a camera cannot be opened, or sends no images any more, or images that cannot be halved; or no
            two of a hundred frames are near enough.
    """
    cameras = [_Camera(name) for name in names]
    try:
        number = unsynchronised = 0
        while all(camera.grab() for camera in cameras):
            times = [camera.time for camera in cameras]
            off = abs(times[0] - times[-1])
            if tolerance is not None and off > tolerance:
                unsynchronised += 1
                if unsynchronised == _MOST_APART:
                    raise InputError(
                        f"cameras {' and '.join(names)}: their frames are {off:.3f} s apart, the tolerance is "
                        f"{tolerance:g} s; synchronise them, or give a larger --tolerance."
                    )
                continue
            unsynchronised = 0
            images = [camera.image() for camera in cameras]
            left, right = images if len(images) == 2 else halved(images[0], f"camera {names[0]}")
            yield _pair_of(left, right, f"{number:06d}", times[0] or None)
            number += 1
    finally:
        for camera in cameras:
            camera.capture.release()


def _pair_of(left: Image, right: Image, name: str, time: float | None) -> Pair | Images:
    try:
        return make_pair(left, right, channels="bgr", name=name, time=time)
    except InputError:
        return left, right  # the consumer reports what is wrong; the next pair may be good


class _Camera:
    """An open camera."""

    def __init__(self, name: str) -> None:
        self._name, self._is_file = name, Path(name).is_file()
        self._frames = 0
        if "!" in name and "GStreamer:                   YES" not in cv2.getBuildInformation():
            raise InputError(
                f"camera {name}: this OpenCV was built without GStreamer; name a device, such as 0, or install one "
                "that has it (python3-opencv of Debian and Ubuntu has)."
            )
        self.capture = _captured(
            int(name) if name.isdecimal() else name,
            f"camera {name}: cannot be opened; check that it is there, and that nothing else uses it.",
            cv2.CAP_GSTREAMER if "!" in name else cv2.CAP_ANY,
        )
        if not self._is_file:
            self.capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest frame, where a driver can

    @property
    def time(self) -> float:
        """Seconds, by the camera's own clock, of the frame that was grabbed; 0 if it has none."""
        time = float(self.capture.get(cv2.CAP_PROP_POS_MSEC)) / 1e3
        return time if np.isfinite(time) else 0.0

    def grab(self) -> bool:
        """Take the next frame; False at the end of a file."""
        with quiet_opencv():
            found = self.capture.grab()
        if not found and not self._is_file:
            raise InputError(f"camera {self._name}: sends no images any more, after {self._frames}; check its cable.")
        self._frames += found
        return found

    def image(self) -> Image:
        """The frame that was grabbed."""
        with quiet_opencv():
            found, image = self.capture.retrieve()
        if not found or image is None:
            raise InputError(f"camera {self._name}: image {self._frames} cannot be decoded; check camera and file.")
        return image
