"""Videos, read by OpenCV."""

import os
from pathlib import Path

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.io.images._frame_source import FrameSource, Image
from stereorecal.io.images._image_files import MOST_PIXELS, quiet_opencv

_SUFFIXES = (".avi", ".m4v", ".mjpeg", ".mjpg", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".ogv", ".ts", ".webm", ".wmv")


def is_video(path: Path) -> bool:
    """Whether the name is that of a video."""
    return path.suffix.lower() in _SUFFIXES


def video_source(path: Path) -> FrameSource:
    """The frames of a video, named by their number; their times follow from the frame rate.

    Raises:
        InputError: if the file is missing, empty, or no video that OpenCV can read.
    """
    video = _Video(path)
    numbers = range(video.frames)
    return FrameSource(
        str(path),
        tuple(f"{path.name} {number:06d}" for number in numbers),
        np.arange(video.frames) / video.rate,
        video.read,
    )


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
        with quiet_opencv():
            self._video = cv2.VideoCapture(str(self.path))
        if not self._video.isOpened():
            raise InputError(f"{self.path}: not a video that OpenCV can read, or a damaged one; convert it.")
        self._video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)  # as it was taken: what the calibration knows
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
