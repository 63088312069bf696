"""Bags of ROS 1 and ROS 2, written by tests."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

Stamped = Iterable[tuple[str, int, np.ndarray | bytes]]  # topic, nanoseconds, image or the file of a compressed one


def write_bag(
    path: Path,
    images: Stamped,
    *,
    ros1: bool,
    compressed: bool = False,
    encoding: str = "mono8",
    stamped: bool = True,
) -> Path:
    """A bag with these images; their rows are padded, as some cameras do; without a stamp of the camera if asked."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    kind = f"sensor_msgs/msg/{'CompressedImage' if compressed else 'Image'}"
    writer = rosbag1.Writer(path) if ros1 else rosbag2.Writer(path, version=8)
    with writer:
        connections = {}
        for number, (topic, stamp, image) in enumerate(images):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            sec, nanosec = divmod(stamp, 10**9) if stamped else (0, 0)
            time = store.types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
            extra = {"seq": number} if ros1 else {}
            header = store.types["std_msgs/msg/Header"](stamp=time, frame_id="camera", **extra)
            if compressed:
                file = image if isinstance(image, bytes) else cv2.imencode(".png", image)[1].tobytes()
                data = np.frombuffer(file, np.uint8)
                message = store.types[kind](header=header, format="png", data=data)
            else:
                height, width = image.shape[:2]
                rows = np.ascontiguousarray(image).view(np.uint8).reshape(height, -1)
                padded = np.pad(rows, ((0, 0), (0, 8)))
                message = store.types[kind](
                    header=header,
                    height=height,
                    width=width,
                    encoding=encoding,
                    is_bigendian=0,
                    step=padded.shape[1],
                    data=padded.ravel(),
                )
            write = store.serialize_ros1 if ros1 else store.serialize_cdr
            writer.write(connections[topic], stamp + 5_000_000, write(message, kind))
    return path
