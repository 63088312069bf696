"""Images in messages of ROS, decoded without ROS."""

from typing import Any

import cv2
import numpy as np

from stereorecal._errors import InputError
from stereorecal.io.images._frame_source import Image
from stereorecal.io.images._image_files import decode_image

_TO_BGR = {"rgb8": cv2.COLOR_RGB2BGR, "rgba8": cv2.COLOR_RGBA2BGR}
_TO_BGR |= {"rgb16": cv2.COLOR_RGB2BGR, "rgba16": cv2.COLOR_RGBA2BGR}
# OpenCV names a Bayer pattern by its second row, ROS by its first.
_BAYER = {"rggb": cv2.COLOR_BayerBG2BGR, "bggr": cv2.COLOR_BayerRG2BGR, "gbrg": cv2.COLOR_BayerGR2BGR}
_BAYER["grbg"] = cv2.COLOR_BayerGB2BGR
_SAME: dict[str, str] = {"8UC1": "mono8", "8UC3": "bgr8", "16UC1": "mono16"}
_CHANNELS = {"mono": 1, "bgr": 3, "rgb": 3, "bgra": 4, "rgba": 4, "bayer_": 1}


def image_of_message(message: Any, where: str) -> Image:
    """The pixels of a message, grey (h, w) or in BGR order (h, w, 3 or 4), of 8 or 16 bit.

    Args:
        message: anything with the fields of `sensor_msgs/Image` or `sensor_msgs/CompressedImage`, of ROS 1 or ROS 2.
        where: names the message in errors.

    Raises:
        InputError: if they are damaged, or encoded in a way that is not known.
    """
    if not hasattr(message, "encoding"):
        return decode_image(bytes(message.data), f"{where} ({in_a_line(message.format)})")
    encoding = _SAME.get(message.encoding, str(message.encoding))
    name = encoding.rstrip("0123456789")
    pattern = name.removeprefix("bayer_").rstrip("0123456789")
    channels = 1 if pattern in _BAYER else _CHANNELS.get(name)
    depth = encoding.removeprefix(name)
    if channels is None or depth not in ("8", "16"):
        raise InputError(f"{where}: the encoding {in_a_line(encoding)} is not known; republish as mono8 or bgr8.")
    order = ">" if message.is_bigendian else "<"
    width = channels * int(depth) // 8 * message.width
    if not 0 < width <= message.step or not 0 < message.step * message.height <= len(message.data):
        raise InputError(f"{where}: the image is cut short; leave it out or record it again.")
    rows = np.asarray(message.data, np.uint8)[: message.step * message.height].reshape(message.height, message.step)
    image = np.ascontiguousarray(rows[:, :width]).view(f"{order}u{int(depth) // 8}").astype(f"u{int(depth) // 8}")
    image = image.reshape(message.height, message.width, channels) if channels > 1 else image
    conversion = _BAYER.get(pattern, _TO_BGR.get(encoding))
    return image if conversion is None else cv2.cvtColor(image, conversion)


def in_a_line(text: str) -> str:
    """What a bag or the library that reads it says, short and without breaks."""
    return " ".join(text.split())[:200]
