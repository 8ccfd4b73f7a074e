"""A ROS 2 robot on zenoh: nodes on rmw_zenoh with their router, or DDS nodes behind zenoh-bridge-ros2dds.

`python -m tests.emulators.zenoh_robot --port 7447`, then `beckon run --robot zenoh://127.0.0.1:7447`.
"""

import argparse
import itertools
import json
import socket
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import xxhash
import zenoh
import zenoh.ext

from core.robots.ros.typestore import BOOL, GOAL, PARAMETER_NAMES, PARAMETER_VALUES, STRING, TWIST, TWIST_STAMPED
from core.sensors import Wheels
from tests.emulators.by_hand import serve
from tests.emulators.foxglove import CLOCK, TOPICS
from tests.emulators.own_navigation import EmulatedNavigation
from tests.emulators.ros_messages import DESCRIPTION, PROFILE, SIMULATED_START_S, URDF, RosMessageMaker, speeds_of
from tests.emulators.world import World

PERIOD = 1.0  # [s] between repeated descriptions
LEASE = 2000  # [ms]; rmw_zenoh's own settings have a minute
ATTACHMENT = struct.Struct("<qqB16s")
ARRAYS = {"byte": np.uint8, "bool": np.bool_, "integer": np.int64, "double": np.float64}
Put = Callable[[bytes], None]


def session(mode: str, **fields: Any) -> zenoh.Session:
    """A session with settings `connect__endpoints=[…]`."""
    config = zenoh.Config()
    usual = {
        "mode": mode,
        "scouting__multicast__enabled": False,
        "transport__shared_memory__enabled": False,
        "timestamping__enabled": True,
    }
    for key, value in {**usual, **fields}.items():
        config.insert_json5(key.replace("__", "/"), json.dumps(value))
    return zenoh.open(config)


def free_port() -> int:
    with socket.socket() as end:
        end.bind(("127.0.0.1", 0))
        return end.getsockname()[1]


class RmwNode:
    """A node as rmw_zenoh puts it on the wire."""

    def __init__(
        self, link: zenoh.Session, hash_of: Callable[[str], str], domain: int = 0, name: str = "bot"
    ) -> None:
        self.link, self.hash_of, self.domain, self.name = link, hash_of, domain, name
        self.start = f"@ros2_lv/{domain}/{link.zid()}/0"
        self.ids = itertools.count(1)
        self.kept: list[Any] = [self.token(f"{self.start}/0/NN/%/%/{name}")]

    def token(self, key: str) -> Any:
        return self.link.liveliness().declare_token(key)

    def key(self, topic: str, kind: str) -> str:
        package, _, name = kind.split("/")
        return f"{self.domain}/{topic[1:]}/{package}::msg::dds_::{name}_/{self.hash_of(kind)}"

    def announce(self, role: str, topic: str, kind: str, qos: str) -> str:
        package, _, name = kind.split("/")
        mangled = topic.replace("/", "%")
        token = (
            f"{self.start}/{next(self.ids)}/{role}/%/%/{self.name}/{mangled}/"
            f"{package}::msg::dds_::{name}_/{self.hash_of(kind)}/{qos}"
        )
        self.kept.append(self.token(token))
        return token

    def publisher(self, topic: str, kind: str, *, latched: bool = False) -> Put:
        token = self.announce("MP", topic, kind, ":1:,1:,:,:,," if latched else "::,7:,:,:,,")
        gid = xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")
        numbers = itertools.count(1)
        publisher: Any
        if latched:
            cache = zenoh.ext.CacheConfig(max_samples=1)
            publisher = zenoh.ext.declare_advanced_publisher(
                self.link, self.key(topic, kind), cache=cache, publisher_detection=True
            )
        else:
            publisher = self.link.declare_publisher(
                self.key(topic, kind), congestion_control=zenoh.CongestionControl.DROP
            )
        self.kept.append(publisher)
        return lambda payload: publisher.put(
            payload, attachment=ATTACHMENT.pack(next(numbers), time.time_ns(), 16, gid)
        )

    def service_key(self, node: str) -> str:
        return f"{self.domain}{node}/get_parameters/rcl_interfaces::srv::dds_::GetParameters_/RIHS01_{'0' * 64}"

    def parameters(self, node: str, answer: Callable[[bytes], bytes]) -> None:
        """The service GetParameters of a node; like a C++ one it is silent where the attachment is missing."""
        key = self.service_key(node)

        def reply(query: zenoh.Query) -> None:
            attached = query.attachment.to_bytes() if query.attachment else b""
            if query.payload is not None and self.is_attached(attached):
                query.reply(key, answer(query.payload.to_bytes()), attachment=attached or None)

        self.kept.append(self.link.declare_queryable(key, reply))

    def is_attached(self, raw: bytes) -> bool:
        return len(raw) == ATTACHMENT.size

    def listener(self, topic: str, kind: str, take: Callable[[zenoh.Sample], None]) -> None:
        self.announce("MS", topic, kind, "::,10:,:,:,,")
        self.kept.append(self.link.declare_subscriber(self.key(topic, kind), take))


class BridgeNode(RmwNode):
    """DDS nodes as zenoh-bridge-ros2dds shows them."""

    def __init__(
        self, link: zenoh.Session, hash_of: Callable[[str], str], domain: int = 0, name: str = "bot"
    ) -> None:
        super().__init__(link, hash_of, domain, name)
        self.kept = []

    def key(self, topic: str, kind: str) -> str:
        return topic[1:]

    def service_key(self, node: str) -> str:
        return f"{node[1:]}/get_parameters"

    def is_attached(self, raw: bytes) -> bool:
        return not raw

    def announce(self, role: str, topic: str, kind: str, qos: str) -> str:
        durability = "1" if qos.startswith(":1") else "0"
        names = topic[1:].replace("/", "§"), kind.replace("/", "§")
        token = f"@/{self.link.zid()}/@ros2_lv/{role}/{names[0]}/{names[1]}/:1:{durability}:1,7"
        self.kept.append(self.token(token))
        return token


class ZenohEmulator:
    """One robot and its router, which can be stopped and started again on the same port."""

    def __init__(
        self,
        world: World,
        port: int = 0,
        *,
        bridge: bool = False,
        humble: bool = False,
        namespace: str = "",
        domain: int = 0,
        cmd_vel_type: str = TWIST,
        router: dict[str, Any] | None = None,
    ) -> None:
        """`humble`: types have no hash. `router`: further settings of its session, with TLS for instance."""
        self.world, self.port = world, port or free_port()
        self.bridge, self.humble, self.namespace, self.domain = bridge, humble, namespace, domain
        self.cmd_vel_type, self.router_settings = cmd_vel_type, router or {}
        self.received: list[tuple[float, float, float]] = []  # time.monotonic(), v, w of every message on the wire
        self.frames: list[bytes] = []  # every command as it came
        self.locks: list[tuple[float, bool]] = []
        self.sequences: list[int] = []  # of the commands' attachments
        self.strangers = 0  # messages that a C++ node would drop, or whose sender is not in the graph
        self.tokens: set[str] = set()  # of others
        self._senders: set[bytes] = set()  # identifiers of all whose tokens were ever there
        self.maker = RosMessageMaker(SIMULATED_START_S)
        self.navigation: EmulatedNavigation | None = None  # set it before `start`, and
        self.urdf = ""  # on /robot_description
        self.simulates = True  # it has a simulator's clock, which a slow computer holds up
        self.timeout: float | None = None  # [s] cmd_vel_timeout of its controller; None: it has no such parameter
        self.node: RmwNode | None = None
        self.router: zenoh.Session | None = None
        self.puts: dict[str, Put] = {}
        self._stamp = 0.0
        self._speaking = threading.Lock()
        world.on_scan.append(lambda scan: self.log("/scan", self.maker.scan(scan)))
        world.on_image.append(lambda image: self.log("/camera/image/compressed", self.maker.image(image)))
        world.on_sound.append(lambda sound: self.log("/microphones", self.maker.sound(sound)))
        world.on_wheels.append(self._wheels)

    @property
    def url(self) -> str:
        return f"zenoh://127.0.0.1:{self.port}"

    def start(self) -> None:
        kind = "tls" if self.router_settings else "tcp"
        listens = {"listen__endpoints": [f"{kind}/127.0.0.1:{self.port}"], "transport__link__tx__lease": LEASE}
        self.router = session("router", **listens, **self.router_settings)
        self.start_nodes()

    def stop(self) -> None:
        """The link ends; the robot does not."""
        self.stop_nodes()
        router, self.router = self.router, None
        if router is not None:
            router.close()

    def start_nodes(self) -> None:
        assert self.router is not None
        if self.bridge or self.router_settings:
            link = self.router
        else:
            connects = {
                "connect__endpoints": [f"tcp/127.0.0.1:{self.port}"],
                "listen__endpoints": ["tcp/127.0.0.1:0"],
            }
            link = session("peer", **connects, transport__link__tx__lease=LEASE)
        node = self.node = (BridgeNode if self.bridge else RmwNode)(link, self.hash_of, self.domain)
        node.kept.append(link.liveliness().declare_subscriber("@ros2_lv/**", self._graph, history=True))
        node.listener(f"{self.namespace}/cmd_vel", self.cmd_vel_type, self._command)
        node.listener(f"{self.namespace}/stop_lock", BOOL, self._locked)
        own = (self.navigation.topics if self.navigation else {}) | ({DESCRIPTION: STRING} if self.urdf else {})
        own |= CLOCK if self.simulates else {}
        self.puts = {
            topic: node.publisher(self.namespace + topic, kind, latched=topic in ("/tf_static", "/map", DESCRIPTION))
            for topic, kind in (TOPICS | own).items()
        }
        if self.navigation is not None:
            node.listener(f"{self.namespace}/goal_pose", GOAL, self._take_goal)
        if self.timeout is not None:
            node.parameters(f"{self.namespace}/diff_drive_controller", self._answer_parameters)
        node.parameters(f"{self.namespace}/camera", lambda request: self._parameter_values(0, 0.0))
        self.describe(latched=True)

    def _answer_parameters(self, request: bytes) -> bytes:
        """The answer of the controller, which knows one parameter."""
        asked = self.maker.store.deserialize_cdr(request, PARAMETER_NAMES).names
        return self._parameter_values(3 if asked == ["cmd_vel_timeout"] else 0, self.timeout or 0.0)

    def _parameter_values(self, kind: int, value: float) -> bytes:
        lists = {f"{name}_array_value": np.zeros(0, code) for name, code in ARRAYS.items()}
        one = self.maker.make["rcl_interfaces/msg/ParameterValue"](
            type=kind,
            bool_value=False,
            integer_value=0,
            double_value=value,
            string_value="",
            string_array_value=[],
            **lists,
        )
        return self.maker.encode(PARAMETER_VALUES, values=[one])

    def stop_nodes(self) -> None:
        """The robot's nodes end; their router does not."""
        with self._speaking:
            self.puts = {}
        node, self.node = self.node, None
        if node is None:
            return
        if node.link is not self.router:
            node.link.close()
        for one in node.kept:
            one.undeclare()

    def hash_of(self, kind: str) -> str:
        return "TypeHashNotSupported" if self.humble else str(self.maker.store.hash_rihs01(kind))

    def log(self, topic: str, payload: bytes) -> None:
        with self._speaking:
            if topic in self.puts:
                self.puts[topic](payload)

    def describe(self, *, latched: bool = False) -> None:
        """What the robot says of itself: mountings once, calibration and battery again and again."""
        if latched:
            self.log("/tf_static", self.maker.frames())
            self.log(DESCRIPTION, self.maker.description(self.urdf))
            if self.navigation is not None:
                self.log("/map", self.navigation.grid())
        self.log("/camera/camera_info", self.maker.camera_info(self._stamp))
        self.log("/battery_state", self.maker.battery(0.8))

    def _wheels(self, wheels: Wheels) -> None:
        count = round(self._stamp * PROFILE.rate) + 1
        self._stamp = count / PROFILE.rate
        self.log("/odom", self.maker.odometry(wheels, self._stamp))
        for topic, payload in self.navigation.step(wheels, self._stamp) if self.navigation else ():
            self.log(topic, payload)
        if count % round(PERIOD * PROFILE.rate) == 0:
            self.describe()

    def _graph(self, sample: zenoh.Sample) -> None:
        token = str(sample.key_expr)
        if sample.kind == zenoh.SampleKind.PUT:
            self.tokens.add(token)
            self._senders.add(xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little"))
        else:
            self.tokens.discard(token)

    def _is_heard(self, sample: zenoh.Sample) -> bool:
        """Whether a C++ node takes this message, and knows its sender."""
        if self.bridge:
            return sample.attachment is None
        raw = sample.attachment.to_bytes() if sample.attachment else b""
        if len(raw) != ATTACHMENT.size:
            return False
        number, stamp, length, gid = ATTACHMENT.unpack(raw)
        self.sequences.append(number)
        return length == 16 and abs(stamp - time.time_ns()) < 60 * 10**9 and gid in self._senders

    def _command(self, sample: zenoh.Sample) -> None:
        payload = sample.payload.to_bytes()
        speeds = speeds_of(payload)
        if speeds is None or not self._is_heard(sample):
            self.strangers += 1
            return
        self.received.append((time.monotonic(), *speeds))
        self.frames.append(payload)
        self.world.drive(*speeds)

    def _take_goal(self, sample: zenoh.Sample) -> None:
        if self.navigation is not None and self._is_heard(sample):
            self.navigation.take_cdr(sample.payload.to_bytes())

    def _locked(self, sample: zenoh.Sample) -> None:
        payload = sample.payload.to_bytes()
        if len(payload) == 5:
            self.locks.append((time.monotonic(), bool(payload[4])))
            if self.navigation is not None:
                self.navigation.locked = self.locks[-1]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.emulators.zenoh_robot", description=__doc__)
    parser.add_argument("--port", type=int, default=7447)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--bridge", action="store_true", help="DDS nodes behind zenoh-bridge-ros2dds")
    parser.add_argument("--humble", action="store_true", help="ROS 2 Humble, whose types have no hash")
    parser.add_argument("--namespace", default="", help="/robot1")
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--stamped", action="store_true", help="the robot takes TwistStamped")
    given = parser.parse_args()
    world = World(seed=given.seed)
    emulator = ZenohEmulator(
        world,
        given.port,
        bridge=given.bridge,
        humble=given.humble,
        namespace=given.namespace,
        domain=given.domain,
        cmd_vel_type=TWIST_STAMPED if given.stamped else TWIST,
    )
    emulator.timeout, emulator.urdf = 0.5, URDF
    serve(emulator, world)


if __name__ == "__main__":
    main()
