"""ROS 1 and ROS 2 bags, and images in messages of ROS, read without ROS. Bags need rosbags: pip install
'stereorecal[bags]'."""

import json
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError, extra
from stereorecal.io._read_files import note_input
from stereorecal.io.images._frame_source import FrameSource, Image
from stereorecal.io.images._image_files import decode_image

_METADATA, _PARTS = "metadata.yaml", (".db3", ".mcap")
_INFO, _FIELDS = "sensor_msgs/msg/CameraInfo", ("width", "height", "distortion_model", "d", "k", "r", "p")
_RAW, _COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


def is_bag(path: Path) -> bool:
    """Whether the path is that of a bag: a file of ROS 1, a folder with metadata.yaml of ROS 2."""
    return path.suffix.lower() == ".bag" or (path / _METADATA).is_file()


def bag_folder(path: Path) -> Path:
    """The bag that a path names: of ROS 2 its folder, for one of the files in it."""
    part = path.name == _METADATA or path.suffix.lower() in _PARTS
    return path.parent if part and is_bag(path.parent) else path


def bag_sources(path: Path, topics: tuple[str, str]) -> tuple[FrameSource, FrameSource]:
    """The images of two topics of a bag, named and timed by the stamps of their headers."""
    bag = _Bag(path)
    left, right = (bag.source(topic) for topic in topics)
    return left, right


def camera_infos(path: Path, topics: tuple[str, str]) -> dict[str, str]:
    """The camera_info beside two topics of images, as JSON, by topic: /left/camera_info of /left/image_raw."""
    bag = _Bag(path)
    found = dict(bag.camera_info(topic) for topic in topics)
    if len(found) < 2:
        raise InputError(f"{path}: {' and '.join(topics)} have the same {next(iter(found))}; give --calibration.")
    return found


class _Bag:
    """An open bag."""

    def __init__(self, path: Path):
        if not path.exists():
            raise InputError(f"{path}: there is no such bag; check the path.")
        if not is_bag(path):
            raise InputError(f"{path}: neither a .bag file nor a folder with a {_METADATA} in it; give one of these.")
        for file in (path, *path.rglob("*")):
            note_input(file)
        with extra("bags", "reading a bag"):
            ros, types = import_module("rosbags.highlevel"), import_module("rosbags.typesys")
        self.path = path
        # For bags of ROS 2 that do not say what their messages look like; images have not changed since.
        types_of_ros2 = types.get_typestore(types.Stores.ROS2_HUMBLE)
        with _sound(path):
            self._reader = ros.AnyReader([path], default_typestore=types_of_ros2)
            self._reader.open()
            weakref.finalize(self, self._reader.close)

    def camera_info(self, images: str) -> tuple[str, str]:
        """The topic, and what its messages say, as JSON."""
        topic = images.removesuffix("/compressed").rpartition("/")[0] + "/camera_info"
        connections = [one for one in self._reader.connections if one.topic == topic and one.msgtype == _INFO]
        said: dict[str, dict[str, Any]] = {}
        for _, _, message in self._messages(connections) if connections else ():
            fields = {key: getattr(message, key, getattr(message, key.upper(), None)) for key in _FIELDS}
            content = {key: item.tolist() if isinstance(item, np.ndarray) else item for key, item in fields.items()}
            said[json.dumps(content)] = content
        if not said:
            known = in_a_line(", ".join(sorted({c.topic for c in self._reader.connections if c.msgtype == _INFO})))
            raise InputError(
                f"{self.path}: there is no {in_a_line(topic)}, which would be the calibration of {in_a_line(images)} ("
                + (f"there is {known}" if known else "nor any other camera_info")
                + "); give --calibration."
            )
        if len(said) > 1:
            raise InputError(f"{self.path}: {in_a_line(topic)} changes during the recording; give --calibration.")
        ((text, content),) = said.items()
        turned = np.any(content["d"]) or content["r"] != np.eye(3).ravel().tolist()
        if turned and "rect" in images.removeprefix(topic.removesuffix("camera_info")):
            raise InputError(
                f"{self.path}: {in_a_line(images)} has rectified images, and {in_a_line(topic)} the lens of raw ones; "
                "give the topics of the raw images, or --calibration."
            )
        return topic, text

    def _messages(self, connections: list[Any], **span: int) -> Iterator[tuple[int, int, Any]]:
        """When each was stamped and recorded, in nanoseconds, and the message."""
        with _sound(self.path):
            for connection, recorded, data in self._reader.messages(connections, **span):
                message = self._reader.deserialize(data, connection.msgtype)
                stamp = message.header.stamp
                yield stamp.sec * 10**9 + stamp.nanosec or recorded, recorded, message

    def source(self, topic: str) -> FrameSource:
        """The images of a topic, in the order of their stamps."""
        connections = [one for one in self._reader.connections if one.topic == topic]
        known = sorted({one.topic for one in self._reader.connections if one.msgtype in (_RAW, _COMPRESSED)})
        if not connections or any(one.msgtype not in (_RAW, _COMPRESSED) for one in connections):
            raise InputError(
                f"{self.path}: there are no images on the topic {topic}; "
                + (f"choose from {in_a_line(', '.join(known))}." if known else "the bag has no images at all.")
            )
        entries = sorted((stamp, recorded) for stamp, recorded, _ in self._messages(connections))
        if not entries:
            raise InputError(f"{self.path}: the topic {topic} is empty; choose another.")
        stamps = [stamp for stamp, _ in entries]

        def read(index: int) -> Image:
            stamp, recorded = entries[index]
            for own, _, message in self._messages(connections, start=recorded, stop=recorded + 1):
                if own == stamp:
                    return image_of_message(message, f"{self.path}, {topic}, {stamp}")
            raise InputError(f"{self.path}: the message {stamp} on {topic} has gone; was the bag written to?")

        names = tuple(f"{topic} {stamp / 1e9:.3f}" for stamp in stamps)
        return FrameSource(f"{self.path}, {topic}", names, np.array(stamps) / 1e9, read)


@contextmanager
def _sound(path: Path) -> Iterator[None]:
    """Around what reads a bag: of a damaged one, anything may be raised."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        why = in_a_line(str(error)) or type(error).__name__
        raise InputError(f"{path}: not a bag that can be read, or a damaged one ({why}); record it again.") from error


_SAME: dict[str, str] = {"8UC1": "mono8", "8UC3": "bgr8", "16UC1": "mono16"}
_ENCODINGS: dict[str, tuple[int, int | None]] = {  # the channels, and what makes them BGR
    "mono": (1, None),
    "bgr": (3, None),
    "bgra": (4, None),
    "rgb": (3, cv2.COLOR_RGB2BGR),
    "rgba": (4, cv2.COLOR_RGBA2BGR),
    "bayer_rggb": (1, cv2.COLOR_BayerBG2BGR),  # OpenCV names a Bayer pattern by its second row, ROS by its first
    "bayer_bggr": (1, cv2.COLOR_BayerRG2BGR),
    "bayer_gbrg": (1, cv2.COLOR_BayerGR2BGR),
    "bayer_grbg": (1, cv2.COLOR_BayerGB2BGR),
}


def image_of_message(message: Any, where: str) -> Image:
    """The pixels of a message, grey (h, w) or in BGR order (h, w, 3 or 4), of 8 or 16 bit.

    Args:
        message: anything with the fields of `sensor_msgs/Image` or `sensor_msgs/CompressedImage`, of ROS 1 or ROS 2.
        where: names the message in errors.

    Raises:
        InputError: if they are damaged, or encoded in a way that is not known.
    """
    if not hasattr(message, "encoding"):
        return decode_image(bytes(message.data), f"{where} ({in_a_line(message.format)})")[0]
    encoding = _SAME.get(message.encoding, str(message.encoding))
    name = encoding.rstrip("0123456789")
    depth = encoding.removeprefix(name)
    if name not in _ENCODINGS or depth not in ("8", "16"):
        raise InputError(f"{where}: the encoding {in_a_line(encoding)} is not known; republish as mono8 or bgr8.")
    (channels, conversion), numbers = _ENCODINGS[name], np.dtype(f"u{int(depth) // 8}")
    width = channels * numbers.itemsize * message.width
    if not 0 < width <= message.step or not 0 < message.step * message.height <= len(message.data):
        raise InputError(f"{where}: the image is cut short; leave it out or record it again.")
    rows = np.asarray(message.data, np.uint8)[: message.step * message.height].reshape(message.height, message.step)
    sent = numbers.newbyteorder(">" if message.is_bigendian else "<")
    image = np.ascontiguousarray(rows[:, :width]).view(sent).astype(numbers)
    image = image.reshape(message.height, message.width, channels) if channels > 1 else image
    return image if conversion is None else cv2.cvtColor(image, conversion)


def in_a_line(text: str) -> str:
    """What a bag or the library that reads it says, short and without breaks."""
    return " ".join(text.split())[:200]
