"""Bags of ROS 1 and ROS 2, written by tests."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

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
    infos: Sequence[tuple[str, Mapping[str, Any]]] = (),
) -> Path:
    """A bag with these images; their rows are padded, as some cameras do; without a stamp of the camera if asked.

    Args:
        infos: topics and contents of messages camera_info: width, height, distortion_model, d, k, r, p.
    """
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    kind = f"sensor_msgs/msg/{'CompressedImage' if compressed else 'Image'}"
    writer = rosbag1.Writer(path) if ros1 else rosbag2.Writer(path, version=8)
    with writer:
        connections = {}
        for topic, content in infos:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, "sensor_msgs/msg/CameraInfo", typestore=store)
            writer.write(connections[topic], 10**9, _camera_info(store, content, ros1))
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


def _camera_info(store: Any, content: Mapping[str, Any], ros1: bool) -> bytes:
    types, kind = store.types, "sensor_msgs/msg/CameraInfo"
    time = types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="camera", **({"seq": 0} if ros1 else {}))
    whole = types["sensor_msgs/msg/RegionOfInterest"](x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    arrays = {key.upper() if ros1 else key: np.array(content[key], float) for key in "dkrp"}
    plain = {key: content[key] for key in ("width", "height", "distortion_model")}
    message = types[kind](header=header, **plain, **arrays, binning_x=0, binning_y=0, roi=whole)
    return (store.serialize_ros1 if ros1 else store.serialize_cdr)(message, kind)
