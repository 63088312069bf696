"""The node: topics, services and parameters around a `Watch`."""
# pyright: reportMissingImports=false

from collections.abc import Callable
from dataclasses import fields
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from sensor_msgs.srv import SetCameraInfo
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from stereorecal import InputError
from stereorecal.io import json_line
from stereorecal_ros._kept import Kept
from stereorecal_ros._log import Level
from stereorecal_ros._messages import camera_info_message, diagnostics_message, transform_message
from stereorecal_ros._pairing import LEFT, RIGHT, SIDES
from stereorecal_ros._settings import Settings, about, changes
from stereorecal_ros._watch import Answer, Watch

_POLL = 0.05  # seconds
_DIAGNOSTICS = 1.0  # likewise
_OF_ALL_NODES = ("use_sim_time", "start_type_description_service")
_EVENTS_KEPT = 100  # for a subscriber that is slow


class CalibrationNode(Node):
    """Watches two cameras; `docs/reference/ros-2.md` lists its topics, services and parameters.

    Args:
        home: the folder for the state, where `state_file` does not name a file.

    Raises:
        InputError: if a parameter makes no sense, or the calibration file cannot be used.
    """

    def __init__(self, home: Path, **options: Any) -> None:
        # Declared all, to hear of names that are not known, of which ROS says nothing.
        super().__init__("stereorecal", automatically_declare_parameters_from_overrides=True, **options)
        self._name_unknown()
        settings = self._declared()
        self._full_name = self.get_fully_qualified_name().strip("/")
        place = Path(settings.state_file or home / f"{self._full_name.replace('/', '.')}.state")
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{error.filename}: {error.strerror}; give the parameter state_file.") from error
        self._topics: dict[str, tuple[str, str]] = {}  # of each input: its topic, and the type of messages
        self._watch = Watch(settings, Kept(place, named=bool(settings.state_file)), self._tell, about=self._about)
        self._frames = ["", ""]
        self._publish(settings)
        self._serve()
        self.add_on_set_parameters_callback(self._changed)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_POLL, self._poll, clock=steady)
        self.create_timer(_DIAGNOSTICS, self._diagnose, clock=steady)
        self._subscribe(settings)

    def destroy_node(self) -> None:
        """End the worker process, too; the state is saved."""
        self._watch.close()
        super().destroy_node()

    def _name_unknown(self) -> None:
        """Say which parameters are not known; those that are, are declared later."""
        known = [one.name for one in fields(Settings)]
        for name in self.get_parameters_by_prefix(""):
            if name in known or name.startswith("qos_overrides."):
                self.undeclare_parameter(name)
            elif name not in _OF_ALL_NODES:
                near = "".join(f"; is it {one}?" for one in get_close_matches(name, known, 1))
                self._tell(Level.WARN, f"the parameter {name} is not known, and not used{near}")

    def _declared(self) -> Settings:
        values = {}
        for one in fields(Settings):
            default: Any = list(one.default) if isinstance(one.default, tuple) else one.default
            described = ParameterDescriptor(description=about(one.name), read_only=not changes(one.name))
            value = self.declare_parameter(one.name, default, described).value
            values[one.name] = tuple(value) if isinstance(one.default, tuple) else value
        return Settings(**values)

    def _subscribe(self, settings: Settings) -> None:
        kind, ending = (Image, "") if settings.transport == "raw" else (CompressedImage, "/compressed")
        overrides = QoSOverridingOptions.with_default_policies()
        for side in (LEFT, RIGHT):
            # What is remapped is the topic of the raw images, as everywhere with image_transport.
            inputs = {f"{SIDES[side]}/image_raw": (kind, ending, self._on_image)}
            if not settings.files:
                inputs[f"{SIDES[side]}/camera_info"] = CameraInfo, "", self._on_info
            for name, (message, behind, come) in inputs.items():
                topic = self.resolve_topic_name(name) + behind
                self._topics[name] = topic, f"sensor_msgs/msg/{message.__name__}"
                asked = topic if behind else name  # what is resolved already would be remapped once more
                self.create_subscription(
                    message, asked, partial(come, side), _as_sensors(), qos_overriding_options=overrides
                )

    def _publish(self, settings: Settings) -> None:
        last = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._infos = [self.create_publisher(CameraInfo, f"~/{side}/camera_info", 5) for side in SIDES]
        self._events = self.create_publisher(String, "~/events", _EVENTS_KEPT)
        self._transform = self.create_publisher(TransformStamped, "~/transform", last)
        self._transformed: Any = None
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def _serve(self) -> None:
        self._drivers = [self.create_client(SetCameraInfo, f"{side}/set_camera_info") for side in SIDES]
        requests = {
            "recalibrate": self._watch.recalibrate,
            "apply": self._watch.apply,
            "roll_back": self._watch.roll_back,
            "save": self._save,
        }
        for name, request in requests.items():
            self.create_service(Trigger, f"~/{name}", partial(self._answer, request))

    def _on_image(self, side: int, message: Image | CompressedImage) -> None:
        self._frames[side] = message.header.frame_id
        corrected = self._watch.corrected
        if corrected is not None:
            self._infos[side].publish(camera_info_message(corrected[side], message.header))
        stamp = message.header.stamp
        self._watch.image(side, stamp.sec * 10**9 + stamp.nanosec, message)

    def _on_info(self, side: int, message: CameraInfo) -> None:
        self._watch.camera_info(side, message)

    def _poll(self) -> None:
        for event in self._watch.poll():
            self._events.publish(String(data=json_line(event.as_dict()).rstrip()))
        told = self._watch.corrected, *self._frames
        if self._watch.corrected is not None and all(self._frames) and told != self._transformed:
            self._transformed, rig = told, self._watch.rig
            if rig is not None:
                self._transform.publish(transform_message(rig, self._frames, self.get_clock().now().to_msg()))
        if self.get_parameter("repair").value != self._watch.settings.repair:
            self.set_parameters([Parameter("repair", value=self._watch.settings.repair)])

    def _diagnose(self) -> None:
        stamp = self.get_clock().now().to_msg()
        status = self._watch.status()
        self._diagnostics.publish(diagnostics_message(f"{self._full_name}: stereo calibration", status, stamp))

    def _about(self, name: str) -> str:
        """What else to say of an input that is silent."""
        topic, wanted = self._topics[name]
        types = {one.topic_type for one in self.get_publishers_info_by_topic(topic)}
        if not types:
            return f" (nobody publishes {topic})"
        return f" ({topic})" if wanted in types else f" ({topic} is {' and '.join(sorted(types))}, not {wanted})"

    def _answer(self, request: Callable[[], Answer], asked: Trigger.Request, answer: Trigger.Response):
        answer.success, answer.message = request()
        return answer

    def _save(self) -> Answer:
        """Into the file that the calibration was read from, or through the drivers."""
        if self._watch.settings.files:
            return self._watch.save()
        corrected = self._watch.corrected
        if corrected is None:
            return False, "there is no calibration yet."
        silent = [client.srv_name for client in self._drivers if not client.service_is_ready()]
        if silent:
            return False, (
                f"nobody serves {' and '.join(silent)}; remap it to the driver's service, or give the parameter "
                "calibration."
            )
        for side in (LEFT, RIGHT):
            info = camera_info_message(corrected[side], Header(frame_id=self._frames[side]))
            asked = self._drivers[side].call_async(SetCameraInfo.Request(camera_info=info))
            asked.add_done_callback(partial(self._saved, side))
        self._watch.asked_to_save()
        self._tell(Level.WARN, f"the drivers of both cameras are asked to take: {self._watch.change}")
        return True, "asked the drivers of both cameras; what they answer is logged."

    def _saved(self, side: int, asked: Any) -> None:
        try:
            answer = asked.result()
            level, said = Level.WARN if answer.success else Level.ERROR, answer.status_message
        except Exception as error:  # whatever a client raises
            level, said = Level.ERROR, str(error)
        did = "took" if level is Level.WARN else "did not take"
        self._tell(level, f"the driver of the {SIDES[side]} camera {did} the calibration. {said}".rstrip())

    def _changed(self, parameters: list[Parameter]) -> SetParametersResult:
        for one in parameters:
            if one.name in ("auto_apply", "repair"):
                self._watch.set(**{one.name: bool(one.value)})
        return SetParametersResult(successful=True)

    def _tell(self, level: Level, text: str) -> None:
        logger = self.get_logger()
        if level is Level.OK:  # rclpy wants a line of its own for each severity
            logger.info(text)
        elif level is Level.WARN:
            logger.warning(text)
        else:
            logger.error(text)


def _as_sensors() -> QoSProfile:
    """A value of its own for each subscription: what overrides one is written into it."""
    return QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
