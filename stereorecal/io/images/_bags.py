"""ROS 1 and ROS 2 bags, read without ROS. Needs rosbags: pip install 'stereorecal[bags]'."""

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal._extras import extra
from stereorecal.io._inputs import note_input
from stereorecal.io.images._files import decode_image
from stereorecal.io.images._source import Image, Source

_METADATA, _PARTS = "metadata.yaml", (".db3", ".mcap")
_RAW, _COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
_TO_BGR = {"rgb8": cv2.COLOR_RGB2BGR, "rgba8": cv2.COLOR_RGBA2BGR}
_TO_BGR |= {"rgb16": cv2.COLOR_RGB2BGR, "rgba16": cv2.COLOR_RGBA2BGR}
# OpenCV names a Bayer pattern by its second row, ROS by its first.
_BAYER = {"rggb": cv2.COLOR_BayerBG2BGR, "bggr": cv2.COLOR_BayerRG2BGR, "gbrg": cv2.COLOR_BayerGR2BGR}
_BAYER["grbg"] = cv2.COLOR_BayerGB2BGR
_SAME: dict[str, str] = {"8UC1": "mono8", "8UC3": "bgr8", "16UC1": "mono16"}
_CHANNELS = {"mono": 1, "bgr": 3, "rgb": 3, "bgra": 4, "rgba": 4, "bayer_": 1}


def is_bag(path: Path) -> bool:
    """Whether the path is that of a bag: a file of ROS 1, a folder with metadata.yaml of ROS 2."""
    return path.suffix.lower() == ".bag" or (path / _METADATA).is_file()


def bag_folder(path: Path) -> Path:
    """The bag that a path names: of ROS 2 its folder, for one of the files in it."""
    part = path.name == _METADATA or path.suffix.lower() in _PARTS
    return path.parent if part and is_bag(path.parent) else path


def bag_sources(path: Path, topics: tuple[str, str]) -> tuple[Source, Source]:
    """The images of two topics of a bag, named and timed by the stamps of their headers.

    Raises:
        InputError: if rosbags is not installed, the bag cannot be read, or a topic has no images.
    """
    if not path.exists():
        raise InputError(f"{path}: there is no such bag; check the path.")
    if not is_bag(path):
        raise InputError(f"{path}: neither a .bag file nor a folder with a {_METADATA} in it; give one of these.")
    for file in (path, *path.rglob("*")):
        note_input(file)
    bag = _Bag(path)
    left, right = (bag.source(topic) for topic in topics)
    return left, right


class _Bag:
    """An open bag."""

    def __init__(self, path: Path):
        with extra("bags", "reading a bag"):
            ros, types = import_module("rosbags.highlevel"), import_module("rosbags.typesys")
        self.path = path
        # For bags of ROS 2 that do not say what their messages look like; images have not changed since.
        kept = types.get_typestore(types.Stores.ROS2_HUMBLE)
        with _sound(path):
            self._reader = ros.AnyReader([path], default_typestore=kept)
            self._reader.open()
            weakref.finalize(self, self._reader.close)

    def source(self, topic: str) -> Source:
        """The images of a topic, in the order of their stamps."""
        connections = [one for one in self._reader.connections if one.topic == topic]
        known = sorted({one.topic for one in self._reader.connections if one.msgtype in (_RAW, _COMPRESSED)})
        if not connections or any(one.msgtype not in (_RAW, _COMPRESSED) for one in connections):
            raise InputError(
                f"{self.path}: there are no images on the topic {topic}; "
                + (f"choose from {_in_a_line(', '.join(known))}." if known else "the bag has no images at all.")
            )
        entries = []  # when it was stamped, when it was recorded
        with _sound(self.path):
            for connection, recorded, data in self._reader.messages(connections=connections):
                stamp = self._reader.deserialize(data, connection.msgtype).header.stamp
                entries.append((stamp.sec * 10**9 + stamp.nanosec or recorded, recorded))
        entries.sort()
        if not entries:
            raise InputError(f"{self.path}: the topic {topic} is empty; choose another.")
        stamps = [stamp for stamp, _ in entries]

        def read(index: int) -> Image:
            stamp, recorded = entries[index]
            with _sound(self.path):
                for connection, _, data in self._reader.messages(connections, start=recorded, stop=recorded + 1):
                    message = self._reader.deserialize(data, connection.msgtype)
                    own = message.header.stamp
                    if (own.sec * 10**9 + own.nanosec or recorded) == stamp:
                        return _image(message, connection.msgtype, f"{self.path}, {topic}, {stamp}")
            raise InputError(f"{self.path}: the message {stamp} on {topic} has gone; was the bag written to?")

        names = tuple(f"{topic} {stamp / 1e9:.3f}" for stamp in stamps)
        return Source(f"{self.path}, {topic}", names, np.array(stamps) / 1e9, read)


@contextmanager
def _sound(path: Path) -> Iterator[None]:
    """Around what reads a bag: of a damaged one, anything may be raised."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        why = _in_a_line(str(error)) or type(error).__name__
        raise InputError(f"{path}: not a bag that can be read, or a damaged one ({why}); record it again.") from error


def _in_a_line(text: str) -> str:
    """What a bag or the library that reads it says, short and without breaks."""
    return " ".join(text.split())[:200]


def _image(message: Any, kind: str, where: str) -> Image:
    """The pixels of a message.

    Raises:
        InputError: if they are damaged, or encoded in a way that is not known.
    """
    if kind == _COMPRESSED:
        return decode_image(bytes(message.data), f"{where} ({_in_a_line(message.format)})")
    encoding = _SAME.get(message.encoding, str(message.encoding))
    name = encoding.rstrip("0123456789")
    pattern = name.removeprefix("bayer_").rstrip("0123456789")
    channels = 1 if pattern in _BAYER else _CHANNELS.get(name)
    depth = encoding.removeprefix(name)
    if channels is None or depth not in ("8", "16"):
        raise InputError(f"{where}: the encoding {_in_a_line(encoding)} is not known; republish as mono8 or bgr8.")
    order = ">" if message.is_bigendian else "<"
    width = channels * int(depth) // 8 * message.width
    if message.step < width or len(message.data) < message.step * message.height:
        raise InputError(f"{where}: the image is cut short; leave it out or record it again.")
    rows = np.asarray(message.data, np.uint8)[: message.step * message.height].reshape(message.height, message.step)
    image = np.ascontiguousarray(rows[:, :width]).view(f"{order}u{int(depth) // 8}").astype(f"u{int(depth) // 8}")
    image = image.reshape(message.height, message.width, channels) if channels > 1 else image
    conversion = _BAYER.get(pattern, _TO_BGR.get(encoding))
    return image if conversion is None else cv2.cvtColor(image, conversion)
