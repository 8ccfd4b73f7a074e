"""`foxglove://host:8765`: a robot behind foxglove_bridge, with ROS 2 or ROS 1, and no ROS on this computer."""

import json
import struct
import time
from dataclasses import replace
from typing import Any, NamedTuple

from core.recording.ros import ros2_name
from core.robots.device import Device
from core.robots.ros.ros_device import TIMEOUT, stopping
from core.robots.ros.socket_link import RosAddress, RosSocket, parse_address
from core.robots.ros.topics import DESCRIPTION, RosTopics
from core.robots.ros.typestore import BOOL, GOAL, RobotTypes

DEFAULT_PORT = 8765
SPEEDS_CHANNEL = 1  # number of the first channel that is written to
MESSAGE_OPCODE = 0x01  # opcode both ways
MESSAGE_HEAD = struct.Struct("<BIQ")  # opcode, subscription, time [ns]
SEND_HEAD = struct.Struct("<BI")  # opcode, channel
MOST_CHANNELS_LISTED = 10_000
WARNING_LEVEL = 1  # level of a status message from which on the operator is to know
LISTING_QUIET_S = 0.3  # without a further topic after which the list is whole


class AdvertisedChannel(NamedTuple):
    """A topic that the bridge offers."""

    topic: str
    type: str
    schema: str
    schema_form: str  # "ros2msg", "ros1msg", "ros2idl"


class FoxgloveRobot(RosSocket):
    """Client of foxglove_bridge, in both of its dialects."""

    kind = "foxglove bridge"
    advice = "Start it on the robot: ros2 launch foxglove_bridge foxglove_bridge_launch.xml"
    subprotocols = ("foxglove.sdk.v1", "foxglove.websocket.v1")

    def __init__(self, address: RosAddress) -> None:
        super().__init__(address)
        self._reset()

    def _reset(self) -> None:
        self._capabilities: list[str] | None = None  # None: it has not said hello yet
        self._channels: dict[int, AdvertisedChannel] = {}
        self._listeners: set[str] | None = None  # topics that a node of the robot subscribes to
        self._numbers: dict[int, str] = {}  # subscription → topic
        self._written: dict[str, int] = {}  # topic that is written to → number of its channel
        self._newest = time.monotonic()  # [s] when a topic was last listed
        self._tells_parameters = False

    def _begin(self) -> None:
        self._reset()

    def _is_listed(self) -> bool:
        quiet = time.monotonic() - self._newest > LISTING_QUIET_S
        return self._capabilities is not None and bool(self._channels) and quiet

    def _chosen(self) -> RosTopics:
        found = [(channel.topic, channel.type) for channel in self._channels.values()]
        topics = self._choose(found, self._listeners)
        if "clientPublish" not in (self._capabilities or []):
            sentence = (
                "This bridge takes no speeds, so the robot cannot be driven: give it the capability clientPublish."
            )
            return replace(topics, cmd_vel="", lock="", goal="", notices=(*topics.notices, sentence))
        return topics

    def _subscribe(self, topics: RosTopics) -> None:
        for number, channel in self._channels.items():
            self._subscribe_channel(topics, number, channel)

    def _subscribe_channel(self, topics: RosTopics, number: int, channel: AdvertisedChannel) -> None:
        if channel.topic not in topics.read or channel.type != topics.types[channel.topic]:
            return
        if channel.topic in self._numbers.values():
            return
        if self.types.register(channel.type, channel.schema, channel.schema_form):
            self._numbers[number] = channel.topic
            self._send(json.dumps({"op": "subscribe", "subscriptions": [{"id": number, "channelId": number}]}))

    def _advertise(self, topics: RosTopics) -> None:
        written = ((topics.cmd_vel, topics.cmd_vel_type), (topics.lock, BOOL), (topics.goal, GOAL))
        self._written = {topic: number for number, (topic, _) in enumerate(written, SPEEDS_CHANNEL) if topic}
        channels = [self._own_channel(topic, kind) for topic, kind in written if topic]
        self._send(json.dumps({"op": "advertise", "channels": channels}))

    def _advertise_speeds(self, topics: RosTopics) -> None:
        channel = self._own_channel(topics.cmd_vel, topics.cmd_vel_type)
        self._send(json.dumps({"op": "unadvertise", "channelIds": [SPEEDS_CHANNEL]}))
        self._send(json.dumps({"op": "advertise", "channels": [channel]}))

    def _own_channel(self, topic: str, kind: str) -> dict[str, Any]:
        ros1 = self.types.encoding == "ros1"
        return {
            "id": self._written[topic],
            "topic": topic,
            "encoding": self.types.encoding,
            "schemaName": kind.replace("/msg/", "/") if ros1 else kind,
            "schema": self.types.definition(kind),
            "schemaEncoding": "ros1msg" if ros1 else "ros2msg",
        }

    def _publish(self, topic: str, kind: str, content: Any) -> None:
        if topic in self._written:
            self._send(SEND_HEAD.pack(MESSAGE_OPCODE, self._written[topic]) + self.types.encode(kind, content))

    def _read(self, raw: str | bytes) -> tuple[str, Any] | None:
        if isinstance(raw, str):
            self._read_text(json.loads(raw))
            return None
        if raw[0] != MESSAGE_OPCODE:
            return None
        _, number, _ = MESSAGE_HEAD.unpack_from(raw)
        return self._numbers[number], memoryview(raw)[MESSAGE_HEAD.size :]

    def _read_text(self, fields: dict[str, Any]) -> None:
        match fields.get("op"):
            case "serverInfo":
                self._take_hello(fields)
            case "advertise":
                for entry in fields["channels"]:
                    self._take_channel(entry)
            case "unadvertise":
                for number in fields["channelIds"]:
                    self._channels.pop(number, None)
                    self._numbers.pop(number, None)
            case "status" if fields["level"] >= WARNING_LEVEL:
                self._note(f"The robot's bridge says: {str(fields['message'])[:300]}")
            case "connectionGraphUpdate":
                self._take_graph(fields)
            case "parameterValues":
                self._take_parameters(fields["parameters"])
            case _:
                pass

    def _take_hello(self, fields: dict[str, Any]) -> None:
        """Capabilities of the bridge; with them, whether it is one of ROS 1. Said once in a connection."""
        if self._capabilities is not None:
            return
        self._capabilities = [str(name) for name in fields["capabilities"]]
        encodings = fields.get("supportedEncodings") or ["cdr"]
        self.types = RobotTypes("ros1" if "ros1" in encodings and "cdr" not in encodings else "cdr")
        if "connectionGraph" in self._capabilities:
            self._send('{"op": "subscribeConnectionGraph"}')
        if "parameters" in self._capabilities:
            self._tells_parameters = True
            self._send('{"op": "getParameters", "parameterNames": [], "id": "beckon"}')

    def _take_parameters(self, parameters: list[dict[str, Any]]) -> None:
        """Every parameter of the robot: of interest are when its base stops by itself, and its URDF in ROS 1."""
        self._tells_parameters = False
        self.timeout = stopping(one.get("value") for one in parameters if str(one["name"]).endswith(TIMEOUT))
        texts = (one.get("value") for one in parameters if str(one["name"]).endswith(DESCRIPTION.strip("/")))
        self.description = next((text for text in texts if isinstance(text, str)), "")

    def _is_described(self) -> bool:
        return not self._tells_parameters

    def _take_channel(self, entry: dict[str, Any]) -> None:
        if len(self._channels) >= MOST_CHANNELS_LISTED or entry["encoding"] != self.types.encoding:
            return
        number, form = int(entry["id"]), str(entry.get("schemaEncoding") or "ros2msg")
        channel = AdvertisedChannel(
            str(entry["topic"]), ros2_name(str(entry["schemaName"])), str(entry["schema"]), form
        )
        self._channels[number] = channel
        self._newest = time.monotonic()
        if self.topics is not None:
            self._subscribe_channel(self.topics, number, channel)

    def _take_graph(self, fields: dict[str, Any]) -> None:
        listeners = set() if self._listeners is None else self._listeners
        listeners |= {str(entry["name"]) for entry in fields["subscribedTopics"] if entry["subscriberIds"]}
        listeners -= {str(name) for name in fields["removedTopics"]}
        self._listeners = listeners


def open_device(rest: str) -> Device:
    """`//host:8765?tls=1&cmd_vel=/tab_vel` → the robot. Raises BadInput."""
    return FoxgloveRobot(parse_address(rest, DEFAULT_PORT))
