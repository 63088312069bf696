"""Run by test_ros_node.py with a Python that has ROS: plays a drive to a node, kills it, and tells what came, as JSON.

python ros_scenario.py drive.npz state-folder
"""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger
from stereorecal_ros.play import Player

from stereorecal import Camera, Pair, StereoRig

PATIENCE = 90.0  # seconds, of which a busy machine may need many
PERIOD = 0.1


class Listener(Player):
    """A driver that also listens to the node."""

    def __init__(self, rig: StereoRig, folder: Path) -> None:
        super().__init__(rig)
        self.infos: dict[str, CameraInfo] = {}
        self.sent: set[tuple[str, int, int, str]] = set()  # of each image: side, stamp and frame
        self.heard: list[tuple[str, int, int, str]] = []  # the same of each CameraInfo
        self.events: list[dict] = []
        self.status: dict[str, str] = {}
        self.taken: dict[str, dict] = {}
        self.transform: TransformStamped | None = None
        self._folder = folder
        for side in ("left", "right"):
            self.create_subscription(CameraInfo, f"/stereorecal/{side}/camera_info", self._on(side), 10)
        self.create_subscription(String, "/stereorecal/events", lambda m: self.events.append(json.loads(m.data)), 100)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_status, 10)
        last = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(TransformStamped, "/stereorecal/transform", self._on_transform, last)

    def _on(self, side: str):
        def come(message: CameraInfo) -> None:
            self.infos[side] = message
            self.heard.append(_header(side, message))

        return come

    def send(self, pair: Pair, stamp: Time | None = None) -> None:
        stamp = self.get_clock().now().to_msg() if stamp is None else stamp
        for side in ("left", "right"):
            self.sent.add((side, stamp.sec, stamp.nanosec, f"{side}_camera"))
        super().send(pair, stamp)

    def _on_transform(self, message: TransformStamped) -> None:
        self.transform = message

    def _on_status(self, message: DiagnosticArray) -> None:
        one = message.status[0]
        self.status = {**{value.key: value.value for value in one.values}, "message": one.message}

    def start(self, **parameters: object) -> subprocess.Popen:
        """The node."""
        given = {"state_file": self._folder / "state", "share": 1.0, "silent_after": 1.0, **parameters}
        words = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
        self.infos.clear()
        return subprocess.Popen([sys.executable, "-m", "stereorecal_ros", "--ros-args", *words])

    def play_until(self, pairs, done, stamped=None) -> bool:
        """Pairs in turn until something has come; whether it has."""
        until, number = time.monotonic() + PATIENCE, 0
        while not done() and time.monotonic() < until:
            self.send(pairs[number % len(pairs)], None if stamped is None else stamped())
            number += 1
            time.sleep(PERIOD)
        return done()

    def ask(self, name: str) -> tuple[bool, str]:
        client = self.create_client(Trigger, f"/stereorecal/{name}")
        client.wait_for_service(PATIENCE)
        answer = client.call_async(Trigger.Request())
        until = time.monotonic() + PATIENCE
        while not answer.done() and time.monotonic() < until:
            time.sleep(0.02)
        return answer.result().success, answer.result().message

    def allow_repair(self) -> bool:
        """As `ros2 param set /stereorecal repair true`."""
        client = self.create_client(SetParameters, "/stereorecal/set_parameters")
        client.wait_for_service(PATIENCE)
        answer = client.call_async(
            SetParameters.Request(parameters=[Parameter("repair", value=True).to_parameter_msg()])
        )
        until = time.monotonic() + PATIENCE
        while not answer.done() and time.monotonic() < until:
            time.sleep(0.02)
        return answer.result().results[0].successful

    def serve(self) -> None:
        """Take a calibration, as drivers do."""

        def take(side: str):
            def taken(asked: SetCameraInfo.Request, answer: SetCameraInfo.Response) -> SetCameraInfo.Response:
                self.taken[side] = _plain(asked.camera_info)
                answer.success = True
                return answer

            return taken

        for side in ("left", "right"):
            self.create_service(SetCameraInfo, f"{side}/set_camera_info", take(side))

    def published(self) -> dict:
        return {side: _plain(info) for side, info in self.infos.items()}


def main(drive: Path, folder: Path) -> None:
    content = np.load(drive)
    pairs = [Pair(left.astype(np.float32), right.astype(np.float32)) for left, right in content["images"]]
    before, after = pairs[: content["knock"]], pairs[content["knock"] :]
    height, width = pairs[0].left.shape
    cameras = [Camera((width, height), content[f"{side}_k"], content[f"{side}_d"]) for side in ("left", "right")]
    rig = StereoRig(cameras[0], cameras[1], content["extrinsics"])
    rclpy.init()
    one, executor, said = Listener(rig, folder), SingleThreadedExecutor(), {}
    executor.add_node(one)
    threading.Thread(target=executor.spin, daemon=True).start()
    node = one.start(auto_apply=True)
    kinds = lambda: [event["event"] for event in one.events]  # noqa: E731

    def published() -> dict:
        """What comes with pairs that are sent from now on."""
        heard = len(one.heard)
        one.play_until(after, lambda: len(one.heard) > heard + 8)
        return one.published()

    try:
        said["begins"] = one.play_until(before, lambda: "healthy" in kinds() and len(one.infos) == 2)
        said["given"] = one.published()
        turned = lambda: _plain(one.infos["left"])["r"] != said["given"]["left"]["r"]  # noqa: E731
        said["turns"] = one.play_until(after, turned)
        said["corrected"] = published()
        said["transform"] = _numbers(one.transform)
        said["strangers"] = [header for header in one.heard if header not in one.sent]
        said["twice"] = len(one.heard) - len(set(one.heard))
        first = min(header[1:3] for header in one.heard)
        said["without"] = len([header for header in one.sent if header[1:3] >= first]) - len(one.heard)
        node.send_signal(signal.SIGKILL)
        node.wait()
        node = one.start()
        said["again"] = one.play_until(after, lambda: len(one.infos) == 2 and one.status.get("pairs looked at") != "0")
        said["well"] = one.play_until(after, lambda: not one.status["message"].startswith("missing"))
        said["after the kill"] = published()
        said["hostile"] = hostile(one, after)
        said["after all that"] = published()
        said["rolled back"] = one.ask("roll_back")
        said["back"] = published()
        said["nothing to save to"] = one.ask("save")
        one.serve()
        said["asked the drivers"] = one.play_until(after, lambda: one.ask("save")[0])
        said["saved"] = one.play_until(after, lambda: len(one.taken) == 2)
        said["taken"] = one.taken
        said["repair again"] = one.allow_repair()
        said["waits"] = one.play_until(after, lambda: one.status.get(_WAITS) == "True")
        said["still"] = published()
        said["applied"] = one.ask("apply")
        said["corrected on request"] = published()
        node.send_signal(signal.SIGINT)
        said["code"] = node.wait(PATIENCE)
    finally:
        node.kill()
    said["events"] = one.events
    print(json.dumps(said))
    sys.stdout.flush()
    os._exit(0)  # rclpy's threads are daemons, and it would complain of them


_WAITS = "accepted calibration waits for apply"


def hostile(one: Listener, pairs: list[Pair]) -> dict[str, bool]:
    """Whether each is told."""
    small = [pair.resized((pair.size[0] // 2, pair.size[1] // 2)) for pair in pairs]
    zero = iter(range(10**6))
    told = lambda word: lambda: word in one.status["message"] or word in one.status["missing"]  # noqa: E731
    found = {"other size": one.play_until(small, told("and the calibration of"))}
    sent = one._images[0]
    one._images[0] = _Never()
    found["silent"] = one.play_until(pairs, told("left/image_raw"))
    one._images[0] = _Late(sent)
    found["apart"] = one.play_until(pairs, told("stamps are"))
    one._images[0] = _Odd(sent)
    found["encoding"] = one.play_until(pairs, told("encoding yuv9 is not known"))
    one._images[0] = sent
    found["well again"] = one.play_until(pairs, lambda: one.status["missing"] == "nothing")
    past = lambda: Time(sec=1000 + next(zero), nanosec=0)  # noqa: E731
    found["back in time"] = one.play_until(pairs, lambda: one.status["jumps back in time"] != "0", past)
    return found


class _Never:
    def publish(self, message: Image) -> None:
        pass


class _Late:
    def __init__(self, publisher) -> None:
        self._publisher = publisher

    def publish(self, message: Image) -> None:
        header = message.header
        stamp = Time(sec=header.stamp.sec, nanosec=(header.stamp.nanosec + 40_000_000) % 10**9)
        message.header = Header(stamp=stamp, frame_id=header.frame_id)
        self._publisher.publish(message)


class _Odd(_Late):
    def publish(self, message: Image) -> None:
        message.encoding = "yuv9"
        self._publisher.publish(message)


def _header(side: str, message: CameraInfo) -> tuple[str, int, int, str]:
    header = message.header
    return side, header.stamp.sec, header.stamp.nanosec, header.frame_id


def _plain(info: CameraInfo) -> dict:
    return {name: np.asarray(getattr(info, name)).tolist() for name in ("k", "d", "r", "p")}


def _numbers(message: TransformStamped | None) -> dict:
    assert message is not None
    shift, turn = message.transform.translation, message.transform.rotation
    frames = [message.header.frame_id, message.child_frame_id]
    return {"frames": frames, "shift": [shift.x, shift.y, shift.z], "turn": [turn.x, turn.y, turn.z, turn.w]}


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
