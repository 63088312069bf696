"""Plain data as messages of ROS."""
# pyright: reportMissingImports=false

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo as CameraInfoMessage
from std_msgs.msg import Header

from stereorecal import StereoRig
from stereorecal_ros._camera_info import CameraInfo
from stereorecal_ros._quaternion import quaternion
from stereorecal_ros._status import Status


def camera_info_message(info: CameraInfo, header: Header) -> CameraInfoMessage:
    """With the stamp and the frame of an image."""
    message = CameraInfoMessage(
        header=header, width=info.width, height=info.height, distortion_model=info.distortion_model
    )
    message.d, message.k, message.r, message.p = list(info.d), list(info.k), list(info.r), list(info.p)
    return message


def diagnostics_message(name: str, status: Status, stamp: Time) -> DiagnosticArray:
    """One status, for `/diagnostics`."""
    values = [KeyValue(key=key, value=value) for key, value in status.values.items()]
    one = DiagnosticStatus(level=bytes([status.level]), name=name, message=status.message, values=values)
    return DiagnosticArray(header=Header(stamp=stamp), status=[one])


def transform_message(rig: StereoRig, frames: Sequence[str], stamp: Time) -> TransformStamped:
    """The right camera in the frame of the left one: x_left = R' (x_right - T)."""
    message = TransformStamped(header=Header(stamp=stamp, frame_id=frames[0]), child_frame_id=frames[1])
    back = np.asarray(rig.rotation).T
    shift, turn = message.transform.translation, message.transform.rotation
    shift.x, shift.y, shift.z = (-back @ np.asarray(rig.translation)).tolist()
    turn.x, turn.y, turn.z, turn.w = quaternion(back)
    return message
