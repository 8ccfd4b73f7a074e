"""`rosbridge://host:9090`: a robot behind rosbridge_server, with ROS 1 or ROS 2, and no ROS on this computer.

Messages come in their own bytes (`cbor-raw`), or as JSON with `?encoding=json`, which takes twenty times as long.
"""

import base64
import dataclasses
import json
import re
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.recording.ros import ros2_name
from core.robots.device import Device
from core.robots.ros.bridge import RosSensors
from core.robots.ros.ros_device import TIMEOUT, stopping
from core.robots.ros.socket_link import RosAddress, RosSocket, parse_address
from core.robots.ros.topics import DESCRIPTION, RosTopics
from core.robots.ros.typestore import BOOL, GOAL, STRING, RobotTypes

DEFAULT_PORT = 9090
TYPES, TOPICS = "/rosapi/topics_and_raw_types", "/rosapi/topics"  # services; older robots have only the second
NODES, LISTENERS = "/rosapi/nodes", "/rosapi/subscribers"  # for the parameters of ROS 2, which belong to nodes,
NAMES, PARAMETER = "/rosapi/get_param_names", "/rosapi/get_param"  # and for those of ROS 1
CONTROLLER = re.compile("control|base|driv|motor")  # name of a node that may turn the wheels
MOST_ASKED = 12  # nodes
PICTURE_GAP_MS = 60  # at least between two pictures: rosbridge takes much of the robot's computer for each
LEVELS = ("warning", "error")  # of status messages that the operator is to know
OF_ROS_1 = {"secs": "sec", "nsecs": "nanosec"}
TO_ROS_1 = {there: here for here, there in OF_ROS_1.items()}


class RosbridgeRobot(RosSocket):
    """Client of rosbridge_server and rosapi."""

    kind = "rosbridge"
    advice = "Start it on the robot: ros2 launch rosbridge_server rosbridge_websocket_launch.xml"

    def __init__(self, address: RosAddress) -> None:
        super().__init__(address)
        self._json = address.options.get("encoding") == "json"
        self._unpack: Callable[[bytes], Any] = json.loads if self._json else _cbor()
        self._reset()

    def _reset(self) -> None:
        self._types: list[tuple[str, str]] | None = None  # topic, its type as the robot writes it
        self._definitions: list[str] = []
        self._texts: set[str] = set()  # topics of a String, whose data are no bytes
        self._refused = False
        self._awaited: set[str] = set()  # answers about parameters
        self._timeouts: list[object] = []  # values of cmd_vel_timeout

    def _begin(self) -> None:
        self._reset()
        self._say(op="call_service", service=TYPES, id=TYPES)

    def _is_listed(self) -> bool:
        return self._types is not None or self._refused

    def _chosen(self) -> RosTopics:
        if self._types is None:
            raise Unavailable(
                f"The rosbridge at {self.address.name} does not list the robot's topics; start its node rosapi, too."
            )
        return self._choose(self._types)

    def _subscribe(self, topics: RosTopics) -> None:
        texts = dict(zip(self._types or [], self._definitions, strict=False))
        for (topic, kind), text in texts.items():
            if text and topics.types.get(topic) == ros2_name(kind):
                self.types.register(ros2_name(kind), text)
        self._texts = {topic for topic in topics.read if topics.types[topic] == STRING}
        for topic in topics.read:
            if self.types.borrow(topics.types[topic]):
                self._say(
                    op="subscribe",
                    topic=topic,
                    type=self._name(topics.types[topic]),
                    compression="none" if self._json else "cbor-raw",
                    throttle_rate=PICTURE_GAP_MS if topic == topics.image else 0,
                    queue_length=1 if topic == topics.image else 0,
                )

    def _ask_parameters(self, topics: RosTopics) -> None:
        if self.types.encoding == "ros1":
            self._ask(NAMES)
        elif topics.cmd_vel:
            self._ask(LISTENERS, topic=topics.cmd_vel)
            self._ask(NODES)

    def _is_described(self) -> bool:
        return not self._awaited

    def _ask(self, service: str, **arguments: str) -> None:
        about = arguments.get("name", service)
        if about not in self._awaited:
            self._awaited.add(about)
            self._say(op="call_service", service=service, id=about, args=arguments)

    def _take_answer(self, fields: dict[str, Any]) -> None:
        """The answer about a parameter, about all their names (ROS 1), or about nodes that may have one (ROS 2)."""
        about, values = str(fields["id"]), fields["values"] if fields.get("result") else {}
        match about:
            case _ if about == NAMES:
                wanted = (TIMEOUT, DESCRIPTION)
                names = [str(name) for name in values.get("names", ()) if str(name).endswith(wanted)]
            case _ if about == LISTENERS:
                names = [f"{node}:{TIMEOUT}" for node in values.get("subscribers", ())]
            case _ if about == NODES:
                names = [f"{node}:{TIMEOUT}" for node in values.get("nodes", ()) if CONTROLLER.search(str(node))]
            case _:
                names = []
                self._take_parameter(about, values.get("value"))
        for name in names[:MOST_ASKED]:
            self._ask(PARAMETER, name=name)
        self._awaited.discard(about)

    def _take_parameter(self, name: str, text: object) -> None:
        """A parameter's value in JSON; "" where the robot has none of this name."""
        value = json.loads(text) if isinstance(text, str) and text else None
        if name.endswith(TIMEOUT):
            self._timeouts.append(value)
            self.timeout = stopping(self._timeouts)
        elif isinstance(value, str):
            self.description = value

    def _advertise(self, topics: RosTopics) -> None:
        written = ((topics.cmd_vel, topics.cmd_vel_type), (topics.lock, BOOL), (topics.goal, GOAL))
        for topic, kind in written:
            if topic:
                self._say(op="advertise", topic=topic, type=self._name(kind))

    def _advertise_speeds(self, topics: RosTopics) -> None:
        self._say(op="unadvertise", topic=topics.cmd_vel)
        self._say(op="advertise", topic=topics.cmd_vel, type=self._name(topics.cmd_vel_type))

    def _publish(self, topic: str, kind: str, content: Any) -> None:
        names = TO_ROS_1 if self.types.encoding == "ros1" else {}
        self._say(op="publish", topic=topic, msg=as_json(content, names))

    def _read(self, raw: str | bytes) -> tuple[str, Any] | None:
        fields: dict[str, Any] = json.loads(raw) if isinstance(raw, str) else self._unpack(raw)
        match fields.get("op"):
            case "publish":
                topic, content = str(fields["topic"]), fields["msg"]
                is_text = topic in self._texts
                return topic, as_fields(content, is_text) if self._json else bytes(content["bytes"])
            case "service_response" if fields.get("id") in self._awaited:
                self._take_answer(fields)
            case "service_response":
                self._take_list(fields)
            case "status" if fields.get("level") in LEVELS:
                self._note(f"The robot's rosbridge says: {str(fields['msg'])[:300]}")
            case _:
                pass
        return None

    def _take(self, sensors: RosSensors, topic: str, payload: Any) -> None:
        if self._json:
            sensors.take_fields(topic, payload)
        else:
            sensors.take(topic, payload)

    def _take_list(self, fields: dict[str, Any]) -> None:
        """The answer of rosapi: parallel lists of topics, types, and their definitions."""
        service = fields.get("id")
        if self._types is not None or service not in (TYPES, TOPICS):
            return
        if not fields.get("result"):
            self._refused = service == TOPICS
            if service == TYPES:
                self._say(op="call_service", service=TOPICS, id=TOPICS)
            return
        values = fields["values"]
        pairs = [(str(topic), str(kind)) for topic, kind in zip(values["topics"], values["types"], strict=True)]
        self._definitions = [str(text) for text in values.get("typedefs_full_text") or ()]
        ros1 = any(kind.count("/") == 1 for _, kind in pairs)
        self.types = RobotTypes("ros1" if ros1 else "cdr")
        self._types = pairs

    def _name(self, kind: str) -> str:
        return kind.replace("/msg/", "/") if self.types.encoding == "ros1" else kind

    def _say(self, **fields: Any) -> None:
        self._send(json.dumps(fields))


def as_json(value: Any, names: Mapping[str, str]) -> Any:
    """A message → the same in JSON, some of its fields by other names; the robot numbers headers itself."""
    if not dataclasses.is_dataclass(value):
        return value
    known = (field.name for field in dataclasses.fields(value) if field.name not in ("__msgtype__", "seq"))
    return {names.get(name, name): as_json(getattr(value, name), names) for name in known}


def as_fields(value: Any, is_text: bool = False) -> Any:
    """A message in JSON → the same with attributes, named as in ROS 2. Bytes come in base 64, null is no number.

    `is_text`: it is a String, whose data are no bytes.
    """
    if isinstance(value, dict):
        fields = SimpleNamespace()
        for key, content in value.items():
            is_bytes = key == "data" and isinstance(content, str) and not is_text
            setattr(fields, OF_ROS_1.get(key, key), base64.b64decode(content) if is_bytes else as_fields(content))
        return fields
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [as_fields(entry) for entry in value]
    return value


def _cbor() -> Callable[[bytes], Any]:
    try:
        from cbor2 import loads
    except ModuleNotFoundError:
        raise Unavailable(
            f"rosbridge needs the extra rosbridge: {install_extra('rosbridge')}. "
            "Without it, add ?encoding=json to the address."
        ) from None
    return loads


def open_device(rest: str) -> Device:
    """`//host:9090?encoding=json&cmd_vel=/tab_vel` → the robot.

    Raises BadInput, or Unavailable without the package cbor2.
    """
    address = parse_address(rest, DEFAULT_PORT, ("encoding",))
    if address.options.get("encoding", "cbor") not in ("cbor", "json"):
        raise BadInput("encoding is cbor or json.")
    return RosbridgeRobot(address)
