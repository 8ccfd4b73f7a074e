"""The message types of one robot: what it advertises, else the types of ROS 2 Humble, or of ROS 1 Noetic."""

import functools
from collections import Counter
from typing import Any, Literal

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from core.gate import Twist
from core.geometry import Pose
from core.recording.ros import TF, RosParts
from core.recording.ros_sound import with_sound

RosEncoding = Literal["cdr", "ros1"]

TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
GOAL = "geometry_msgs/msg/PoseStamped"
BOOL = "std_msgs/msg/Bool"
STRING = "std_msgs/msg/String"
PARAMETER_NAMES = "rcl_interfaces/msg/ParameterNames"  # not of ROS: the request of GetParameters,
PARAMETER_VALUES = "rcl_interfaces/msg/ParameterValues"  # and its answer
LARGEST_DEFINITION = 1_000_000  # [characters] of a type's text; real ones have some thousand

OTHERS = {
    TF: "geometry_msgs/TransformStamped[] transforms",
    PARAMETER_NAMES: "string[] names",
    PARAMETER_VALUES: "rcl_interfaces/ParameterValue[] values",
}
"""Definitions that the usual collections leave out."""


@functools.cache
def usual_types(encoding: RosEncoding) -> Typestore:
    """The types that every ROS installation has. Shared: nothing of a robot's is registered here."""
    store = get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE)
    for name, text in OTHERS.items():
        if name not in store.types:
            store.register(get_types_from_msg(text, name))
    return with_sound(store)


class RobotTypes:
    """Decodes and encodes the messages of one robot; what it cannot read is counted, never fatal."""

    def __init__(self, encoding: RosEncoding = "cdr") -> None:
        self.encoding: RosEncoding = encoding
        self.skipped: dict[str, str] = {}  # type → why it is not known
        self.errors: Counter[str] = Counter()  # topic → messages that could not be decoded
        self._store = get_typestore(Stores.EMPTY)
        self._parts = RosParts(self._store, ros1=encoding == "ros1")

    def register(self, name: str, text: str, form: str = "ros2msg") -> bool:
        """Take in a type "sensor_msgs/msg/LaserScan" with all that it is made of → whether it is known now.

        `form`: ros2msg, ros1msg or ros2idl. A text that cannot be parsed, or contradicts a type that is known
        already, is noted in `skipped`.
        """
        if len(text) > LARGEST_DEFINITION:
            self.skipped[name] = "its definition is too long"
            return False
        try:
            if form == "ros2idl":
                types = get_types_from_idl(text)
            elif form in ("ros2msg", "ros1msg"):
                types = get_types_from_msg(text, name)
            else:
                self.skipped[name] = f"its definition has the unknown form {form[:30]!r}"
                return False
            self._store.register(types)
        except Exception:  # whatever the parser raises on a text from outside
            self.skipped[name] = "its definition cannot be read"
            return False
        return self._known(name)

    def borrow(self, name: str) -> bool:
        """Make sure that a type is known, by the usual definition where the robot gave none."""
        if name in self._store.types:
            return True
        usual = usual_types(self.encoding)
        if name not in usual.types:
            self.skipped[name] = "it is not one of the usual types"
            return False
        ros1 = self.encoding == "ros1"
        return self.register(name, usual.generate_msgdef(name, ros_version=1 if ros1 else 2)[0])

    def decode(self, topic: str, name: str, payload: bytes | memoryview) -> Any | None:
        """Bytes of a message → its fields; None for bytes that are no such message."""
        try:
            if self.encoding == "ros1":
                return self._store.deserialize_ros1(payload, name)
            return self._store.deserialize_cdr(payload, name)
        except Exception:  # whatever the decoder raises on damaged bytes: the next message may be fine
            self.errors[topic] += 1
            return None

    def encode(self, name: str, content: Any) -> bytes:
        """A message of `types[name]` → its bytes."""
        if self.encoding == "ros1":
            return bytes(self._store.serialize_ros1(content, name))
        return bytes(self._store.serialize_cdr(content, name))

    def speeds(self, name: str, twist: Twist, frame: str = "") -> Any:
        """Speeds as a Twist or a TwistStamped. Its stamp is 0, which controllers replace by their own time."""
        self.borrow(name)
        content = self._parts.twist(twist.v, twist.w)
        if name == TWIST:
            return content
        return self._parts.make(name, header=self._parts.header(0.0, frame), twist=content)

    def goal(self, frame: str, goal: Pose) -> Any:
        """A PoseStamped [m], [rad] in that frame, with the stamp 0."""
        self.borrow(GOAL)
        return self._parts.make(GOAL, header=self._parts.header(0.0, frame), pose=self._parts.planar(goal))

    def flag(self, value: bool) -> Any:
        """A std_msgs/Bool."""
        self.borrow(BOOL)
        return self._parts.make(BOOL, data=value)

    def encode_names(self, names: list[str]) -> bytes:
        """The request of GetParameters."""
        self.borrow(PARAMETER_NAMES)
        return self.encode(PARAMETER_NAMES, self._parts.make(PARAMETER_NAMES, names=names))

    def definition(self, name: str) -> str:
        """The text of a type with all that it is made of; "" where it is not known."""
        if not self.borrow(name):
            return ""
        return self._store.generate_msgdef(name, ros_version=1 if self.encoding == "ros1" else 2)[0]

    def _known(self, name: str) -> bool:
        known = name in self._store.types
        if known:
            self.skipped.pop(name, None)
        else:
            self.skipped[name] = "its definition is of another type"
        return known
