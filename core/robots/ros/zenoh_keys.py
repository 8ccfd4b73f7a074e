"""How ROS 2 looks on zenoh: keys of topics, the graph in liveliness tokens, the attachment of a message.

Two forms are on the road, and they do not understand each other. With rmw_zenoh the robot's nodes speak zenoh
themselves; zenoh-bridge-ros2dds stands beside a robot whose nodes speak DDS.
"""

import re
import struct
from collections.abc import Sequence
from typing import Literal, NamedTuple

from core.errors import Unavailable
from core.install import install_extra

Dialect = Literal["rmw", "bridge"]

BRIDGE_GRAPH = "@/*/@ros2_lv/**"
NO_HASH = "TypeHashNotSupported"  # what ROS 2 Humble says instead
ATTACHMENT = struct.Struct("<qqB16s")  # sequence number, time [ns], length of the identifier, identifier
TRANSIENT_LOCAL = "1"
NAME = re.compile(r"(/\w+)+", re.ASCII)
DDS_TYPE = re.compile(r"(\w+)::msg::dds_::(\w+)_")
TYPE = re.compile(r"\w+/msg/\w+", re.ASCII)
LONGEST_NAME = 256


class Endpoint(NamedTuple):
    """A publisher or a subscriber of a topic on the robot."""

    topic: str  # "/robot1/scan"
    type: str  # "sensor_msgs/msg/LaserScan"
    publishes: bool
    dialect: Dialect
    hash: str = ""  # of its type: "RIHS01_…", "" where it is not said
    latched: bool = False  # its last message is kept for those who come later
    owner: str = ""  # identifier of its zenoh session


def rmw_graph(domain: int) -> str:
    """The key of all tokens of a domain."""
    return f"@ros2_lv/{domain}/**"


def dds_type(name: str) -> str:
    """`sensor_msgs/msg/LaserScan` → `sensor_msgs::msg::dds_::LaserScan_`."""
    package, _, kind = name.split("/")
    return f"{package}::msg::dds_::{kind}_"


def topic_key(dialect: Dialect, domain: int, topic: str, name: str, type_hash: str = "*") -> str:
    """The key of a topic's messages; with `*` for the hash it fits those of every distribution."""
    bare = topic.strip("/")
    return bare if dialect == "bridge" else f"{domain}/{bare}/{dds_type(name)}/{type_hash}"


def parameter_services(dialect: Dialect, domain: int, namespace: str) -> str:
    """The keys of the service GetParameters of all nodes in a namespace, "" for all."""
    nodes = "/".join(filter(None, (namespace.strip("/"), "**", "get_parameters")))
    return nodes if dialect == "bridge" else f"{domain}/{nodes}/rcl_interfaces::srv::dds_::GetParameters_/*"


def parse_token(key: str) -> Endpoint | None:
    """A liveliness token → whose it is; None for nodes, services and what is no such token."""
    parts = key.split("/")
    endpoint = None
    if parts[0] == "@ros2_lv" and len(parts) >= 13:
        endpoint = _rmw_endpoint(parts)
    elif parts[0] == "@" and len(parts) == 7 and parts[2] == "@ros2_lv":
        endpoint = _bridge_endpoint(parts)
    if endpoint is None or len(endpoint.topic) > LONGEST_NAME or not NAME.fullmatch(endpoint.topic):
        return None
    return endpoint if TYPE.fullmatch(endpoint.type) else None


def _rmw_endpoint(parts: Sequence[str]) -> Endpoint | None:
    """`@ros2_lv/domain/session/node/endpoint/kind/enclave/namespace/name/topic/type/hash/qos`, or more."""
    if parts[5] not in ("MP", "MS"):
        return None
    found = DDS_TYPE.fullmatch(parts[10])
    return Endpoint(
        topic=parts[9].replace("%", "/"),
        type=f"{found[1]}/msg/{found[2]}" if found else parts[10].replace("%", "/"),
        publishes=parts[5] == "MP",
        dialect="rmw",
        hash=parts[11],
        latched=parts[12].split(":")[1:2] == [TRANSIENT_LOCAL],
        owner=parts[2],
    )


def _bridge_endpoint(parts: Sequence[str]) -> Endpoint | None:
    """`@/session/@ros2_lv/kind/key/type/qos`."""
    if parts[3] not in ("MP", "MS"):
        return None
    return Endpoint(
        topic="/" + parts[4].replace("§", "/"),
        type=parts[5].replace("§", "/"),
        publishes=parts[3] == "MP",
        dialect="bridge",
        latched=parts[6].split(":")[2:3] == [TRANSIENT_LOCAL],
        owner=parts[1],
    )


NODE_NAME = "beckon"


class OwnNode:
    """The console as a node among the robot's: its tokens.

    A camera's driver may publish only while the graph shows a listener, so listeners are announced too.
    """

    def __init__(self, domain: int, session: str) -> None:
        self._start = f"@ros2_lv/{domain}/{session}/0"
        self._endpoints = 0
        self.token = f"{self._start}/0/NN/%/%/{NODE_NAME}"

    def endpoint_token(self, topic: str, name: str, type_hash: str, *, publishes: bool) -> str:
        """The token of a new publisher or listener, with ordinary quality of service."""
        self._endpoints += 1
        kind = "MP" if publishes else "MS"
        return (
            f"{self._start}/{self._endpoints}/{kind}/%/%/{NODE_NAME}/"
            f"{topic.replace('/', '%')}/{dds_type(name)}/{type_hash}/::,10:,:,:,,"
        )


def endpoint_id(token: str) -> bytes:
    """The 16 bytes that identify a publisher: XXH3-128 of its token, the low half first, both little endian."""
    try:
        from xxhash import xxh3_128_intdigest
    except ImportError:
        raise needs_fleet() from None
    return xxh3_128_intdigest(token.encode()).to_bytes(16, "little")


def attachment(sequence: int, nanoseconds: int, identifier: bytes) -> bytes:
    """The 33 bytes without which a C++ node drops a message. `sequence` counts from 1."""
    return ATTACHMENT.pack(sequence, nanoseconds, len(identifier), identifier)


def publisher_of(attached: bytes) -> str:
    """The identifier of the publisher in a message's attachment; "": it has none."""
    return ATTACHMENT.unpack(attached)[-1].hex() if len(attached) == ATTACHMENT.size else ""


def needs_fleet() -> Unavailable:
    """The sentence for a console without zenoh."""
    return Unavailable(f"Robots on zenoh need the extra fleet: {install_extra('fleet')}")
