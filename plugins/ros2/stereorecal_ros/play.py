"""Plays a recording, or a rendered drive, as the driver of a stereo camera would publish it.

    python -m stereorecal_ros.play scene-folder/ [--rate 10] [--loop]
    python -m stereorecal_ros.play --drive          a rendered harbour; the right camera is knocked by 0.3 degrees
                                                    after ten seconds, and the drive stays where it ends

Publishes left/image_raw, left/camera_info, right/image_raw and right/camera_info, all with the stamp of now; -r, -p and
the like after --ros-args. Ends with the recording; Ctrl-C ends it before.
"""
# pyright: reportMissingImports=false

import argparse
import itertools
import sys
import time
from collections.abc import Iterable, Sequence

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from stereorecal import InputError, Pair, StereoRig
from stereorecal.io import load_scene
from stereorecal.recordings import LazyPairs
from stereorecal.synthetic import Knock, photographs, plan_drive
from stereorecal_ros._camera_info import corrected
from stereorecal_ros._messages import camera_info_message
from stereorecal_ros._pairing import SIDES

_FRAMES, _KNOCK, _LAST = 300, 100, 40  # of the drive; the pair that shows the knock; pairs that are shown on and on


class Player(Node):
    """A driver of two cameras with a calibration, which sends what it is given."""

    def __init__(self, rig: StereoRig) -> None:
        super().__init__("player")
        self._calibrated = corrected(rig)
        self._images = [self.create_publisher(Image, f"{side}/image_raw", qos_profile_sensor_data) for side in SIDES]
        self._infos = [
            self.create_publisher(CameraInfo, f"{side}/camera_info", qos_profile_sensor_data) for side in SIDES
        ]

    def send(self, pair: Pair, stamp: Time | None = None) -> None:
        """Publish a pair, as mono8, and the CameraInfo of both cameras."""
        stamp = self.get_clock().now().to_msg() if stamp is None else stamp
        for side, name, image in zip((0, 1), SIDES, (pair.left, pair.right), strict=True):
            header = Header(stamp=stamp, frame_id=f"{name}_camera")
            height, width = image.shape
            message = Image(header=header, height=height, width=width, encoding="mono8", step=width)
            message.data.frombytes(np.clip(np.rint(image), 0, 255).astype(np.uint8).tobytes())
            self._images[side].publish(message)
            self._infos[side].publish(camera_info_message(self._calibrated[side], header))


def main(words: Sequence[str] | None = None) -> int:
    """Play; returns the exit code."""
    rclpy.init(args=sys.argv if words is None else ["play", *words])
    try:
        rig, pairs, rate = _wanted(remove_ros_args(sys.argv if words is None else ["play", *words])[1:])
        player = Player(rig)
        for pair in pairs:
            player.send(pair)
            time.sleep(1.0 / rate)
            if not rclpy.ok():
                break
    except InputError as error:
        print(f"play: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
    return 0


def _wanted(words: Sequence[str]) -> tuple[StereoRig, Iterable[Pair], float]:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", help="a folder with a recording and its calibration, in any layout")
    parser.add_argument("--drive", action="store_true", help="a rendered drive in place of a recording")
    parser.add_argument("--rate", type=float, default=10.0, help="pairs a second (default: %(default)s)")
    parser.add_argument("--loop", action="store_true", help="again and again")
    options = parser.parse_args(words)
    if (options.scene is None) is not options.drive or not options.rate > 0.0:
        parser.error("give a scene or --drive, and a rate above 0.")
    if options.drive:
        drive = plan_drive("harbour", 2, _FRAMES, knocks=(Knock(_KNOCK, (0.3, 0.0, 0.0)),), weather=False)
        rig, last = drive.rig, photographs(drive, _FRAMES - _LAST)
        pairs = itertools.chain(photographs(drive), itertools.cycle(last))
    else:
        every: list[LazyPairs] = []  # read one by one, as they are sent

        def first(pairs: LazyPairs) -> tuple[Pair, ...]:
            every.append(pairs)
            return tuple(pairs[:1])

        rig, pairs = load_scene(options.scene, choose=first).rig, every[0]
        if rig is None:
            raise InputError(f"{options.scene}: the recording has no calibration.")
    return rig, itertools.cycle(pairs) if options.loop else pairs, options.rate


if __name__ == "__main__":
    sys.exit(main())
