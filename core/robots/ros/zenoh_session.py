"""One connection to a zenoh router: the robot's graph, the messages that come, and the speeds that are sent."""

from __future__ import annotations

import itertools
import json
import socket
import threading
import time
from collections import deque
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from core.errors import BadInput, Unavailable
from core.message import message
from core.robots.ros import zenoh_keys
from core.robots.ros.topics import RosSettings
from core.robots.ros.typestore import usual_types

if TYPE_CHECKING:
    import zenoh

CONNECT_TIMEOUT_S = 3.0  # to reach the router
FAREWELL_S = 0.3  # for which the end of a session is waited for; a frozen router may take it 3 s
LEASE_MS = 2000  # of silence after which the router takes the console for gone
MAX_MESSAGE_BYTES = 2**26  # of a message; a raw picture of 4K has 25 MB
MAX_READING_BYTES = 2**20  # of a message that may wait for others
MAX_WAITING_MESSAGES = 64  # messages of a topic that may wait
MOST_ENDPOINTS = 20_000
ANSWER_TIMEOUT_S = 1.0  # for the answers of all nodes
MOST_ANSWERS = 1000
MOST_LATCHED = 100  # messages of a latched topic: as many publishers of /tf_static


@message
class ZenohAddress:
    """Address of a robot's router, and which of the robots behind it is meant."""

    host: str
    port: int
    domain: int = 0
    secure: bool = False
    authority: str = ""  # files (PEM): the certificate that the router's is checked by,
    certificate: str = ""  # the console's own, where the router asks for one,
    key: str = ""  # and its key
    settings: RosSettings = RosSettings()

    @property
    def name(self) -> str:
        """host:port."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def config(self) -> Mapping[str, Any]:
        """The settings of a zenoh session.

        As a client: rmw_zenohd does not forward between peers. Without shared memory, which takes 16 MB for every
        connection on one computer.
        """
        fields: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": [f"{'tls' if self.secure else 'tcp'}/{self.name}"],
            "connect/timeout_ms": round(CONNECT_TIMEOUT_S * 1000),
            "connect/exit_on_failure": True,
            "scouting/multicast/enabled": False,
            "transport/shared_memory/enabled": False,
            "transport/unicast/open_timeout": round(CONNECT_TIMEOUT_S * 1000),
            "transport/link/tx/lease": LEASE_MS,
            "transport/link/rx/max_message_size": MAX_MESSAGE_BYTES,
        }
        if self.authority:
            fields["transport/link/tls/root_ca_certificate"] = self.authority
        if self.certificate:
            fields["transport/link/tls/enable_mtls"] = True
            fields["transport/link/tls/connect_certificate"] = self.certificate
            fields["transport/link/tls/connect_private_key"] = self.key
        return fields


class RosGraph:
    """Publishers and subscribers on the robot, kept up to date by zenoh's threads."""

    def __init__(self) -> None:
        self._endpoints: dict[str, zenoh_keys.Endpoint] = {}
        self._guard = threading.Lock()
        self.changed = time.monotonic()  # [s]

    def put(self, token: str) -> None:
        """A publisher or a subscriber has appeared."""
        endpoint = zenoh_keys.parse_token(token)
        if endpoint is None:
            return
        with self._guard:
            if len(self._endpoints) < MOST_ENDPOINTS:
                self._endpoints[token] = endpoint
            self.changed = time.monotonic()

    def drop(self, token: str) -> None:
        """A publisher or a subscriber has gone."""
        with self._guard:
            self._endpoints.pop(token, None)
            self.changed = time.monotonic()

    def endpoints(self) -> list[zenoh_keys.Endpoint]:
        """All that are there."""
        with self._guard:
            return list(self._endpoints.values())

    def of_topic(self, topic: str, name: str, *, publishes: bool) -> list[zenoh_keys.Endpoint]:
        """The publishers of a topic with this type, or its listeners."""
        return [
            endpoint
            for endpoint in self.endpoints()
            if (endpoint.topic, endpoint.type, endpoint.publishes) == (topic, name, publishes)
        ]


class WaitingMessages:
    """Messages between zenoh's threads and the device's; of every topic only so many wait."""

    def __init__(self) -> None:
        self._waiting: dict[str, deque[tuple[int, bytes, str]]] = {}
        self._ready = threading.Condition()
        self._numbers = itertools.count()
        self.dropped = 0

    def add(self, topic: str, *, newest_only: bool) -> None:
        """Messages of this topic will come."""
        self._waiting[topic] = deque(maxlen=1 if newest_only else MAX_WAITING_MESSAGES)

    def put(self, topic: str, payload: bytes, publisher: str = "") -> None:
        """A message has come; `publisher`: who sent it, "": it does not say."""
        with self._ready:
            waiting = self._waiting[topic]
            if len(payload) > MAX_READING_BYTES and waiting.maxlen != 1:
                self.dropped += 1
                return
            self.dropped += len(waiting) == waiting.maxlen
            waiting.append((next(self._numbers), payload, publisher))
            self._ready.notify()

    def take(self, patience: float) -> list[tuple[str, bytes, str]]:
        """All that wait in their order, or the next within `patience` [s]: topic, message, publisher."""
        with self._ready:
            if not any(self._waiting.values()):
                self._ready.wait(patience)
            arrived = [
                (number, topic, payload, publisher)
                for topic, waiting in self._waiting.items()
                for number, payload, publisher in waiting
            ]
            for waiting in self._waiting.values():
                waiting.clear()
        return [(topic, payload, publisher) for _, topic, payload, publisher in sorted(arrived)]

    def wake(self) -> None:
        """Let `take` return."""
        with self._ready:
            self._ready.notify_all()


class ZenohConnection:
    """A session with a router, until it is lost or closed; never used again afterwards."""

    def __init__(self, address: ZenohAddress) -> None:
        """Raises Unavailable with a sentence."""
        self.lost = threading.Event()
        self.graph, self.waiting = RosGraph(), WaitingMessages()
        self.domain = address.domain
        self._closing = threading.Lock()
        self._zenoh = load_zenoh()
        self._session = self._opened(address)
        self._own_id = str(self._session.zid())
        self._node = zenoh_keys.OwnNode(address.domain, self._own_id)
        self._kept: list[Any] = []  # what zenoh lets go of when it is not held
        liveliness = self._session.liveliness()
        try:
            self._kept.append(self._session.info.declare_transport_events_listener(self._transport_changed))
            for key in (zenoh_keys.rmw_graph(address.domain), zenoh_keys.BRIDGE_GRAPH):
                self._kept.append(liveliness.declare_subscriber(key, self._graph_changed, history=True))
            self._kept.append(liveliness.declare_token(self._node.token))
            if not self._session.info.links():
                raise Unavailable(f"The zenoh router at {address.name} hung up.")
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let go; harmless when done twice."""
        self.lost.set()
        self.waiting.wake()
        if self._closing.acquire(blocking=False):  # once
            farewell = threading.Thread(target=self._session.close, name="zenoh-farewell", daemon=True)
            farewell.start()
            farewell.join(FAREWELL_S)

    def subscribe(
        self, topic: str, name: str, dialect: zenoh_keys.Dialect, *, latched: bool, newest_only: bool
    ) -> None:
        """Have the messages of a topic put among those that wait; of a latched one also the last from before."""
        self.waiting.add(topic, newest_only=newest_only)
        key = zenoh_keys.topic_key(dialect, self.domain, topic, name)

        def take(sample: zenoh.Sample) -> None:
            attached = sample.attachment.to_bytes() if sample.attachment is not None else b""
            self.waiting.put(topic, sample.payload.to_bytes(), zenoh_keys.publisher_of(attached))

        if dialect == "rmw":
            self._announce(self._node.endpoint_token(topic, name, type_hash(name), publishes=False))
        if latched:
            extended = self._zenoh.ext
            history = extended.HistoryConfig(detect_late_publishers=True, max_samples=MOST_LATCHED)
            self._kept.append(extended.declare_advanced_subscriber(self._session, key, take, history=history))
        else:
            self._kept.append(self._session.declare_subscriber(key, take))

    def writer(self, topic: str, name: str, dialect: zenoh_keys.Dialect) -> TopicWriter:
        """Publisher of messages on a topic of the robot, under the hash that its listener goes by."""
        listeners = self.graph.of_topic(topic, name, publishes=False)
        known = next((listener.hash for listener in listeners if listener.hash), type_hash(name))
        publisher = self._session.declare_publisher(
            zenoh_keys.topic_key(dialect, self.domain, topic, name, known),
            congestion_control=self._zenoh.CongestionControl.DROP,
            priority=self._zenoh.Priority.INTERACTIVE_HIGH,
            express=True,
        )
        token = self._node.endpoint_token(topic, name, known, publishes=True)
        if dialect == "rmw":
            self._announce(token)
        return TopicWriter(publisher, zenoh_keys.endpoint_id(token) if dialect == "rmw" else None, self.lost)

    def ask_parameters(self, namespace: str, request: bytes, dialect: zenoh_keys.Dialect) -> list[bytes]:
        """Send a request of GetParameters to all nodes in a namespace → their answers, within ASKING."""
        attached = (
            zenoh_keys.attachment(1, time.time_ns(), zenoh_keys.endpoint_id(self._node.token))
            if dialect == "rmw"
            else None
        )
        replies = self._session.get(
            zenoh_keys.parameter_services(dialect, self.domain, namespace),
            payload=request,
            attachment=attached,
            target=self._zenoh.QueryTarget.ALL,
            consolidation=self._zenoh.ConsolidationMode.NONE,
            timeout=ANSWER_TIMEOUT_S,
        )
        return [
            reply.ok.payload.to_bytes() for reply in itertools.islice(replies, MOST_ANSWERS) if reply.ok is not None
        ]

    def _announce(self, token: str) -> None:
        self._kept.append(self._session.liveliness().declare_token(token))

    def _opened(self, address: ZenohAddress) -> zenoh.Session:
        try:
            socket.create_connection((address.host, address.port), CONNECT_TIMEOUT_S).close()
        except OSError as trouble:
            why = trouble.strerror or "it did not answer in time"
            raise Unavailable(
                f"No zenoh router at {address.name}: {why}. Start it on the robot: "
                "ros2 run rmw_zenoh_cpp rmw_zenohd, or zenoh-bridge-ros2dds where its nodes speak DDS."
            ) from None
        config = self._zenoh.Config()
        try:
            for key, value in address.config().items():
                config.insert_json5(key, json.dumps(value))
            return self._zenoh.open(config)
        except self._zenoh.ZError:
            kind = "with this certificate" if address.secure else "as a zenoh router"
            raise Unavailable(f"What is at {address.name} does not answer {kind}.") from None

    def _transport_changed(self, event: zenoh.TransportEvent) -> None:
        if event.kind == self._zenoh.SampleKind.DELETE:
            self.lost.set()
            self.waiting.wake()

    def _graph_changed(self, sample: zenoh.Sample) -> None:
        token = str(sample.key_expr)
        if self._own_id in token:
            return
        if sample.kind == self._zenoh.SampleKind.PUT:
            self.graph.put(token)
        else:
            self.graph.drop(token)
            self.waiting.wake()


class TopicWriter:
    """Puts messages on one topic, with the attachment that nodes of rmw_zenoh ask for."""

    def __init__(self, publisher: zenoh.Publisher, identifier: bytes | None, lost: threading.Event) -> None:
        """`identifier`: of this publisher; None: no attachment."""
        self._publisher, self._identifier, self._lost = publisher, identifier, lost
        self._numbers = itertools.count(1)

    def put(self, payload: bytes) -> None:
        """Send a message without waiting. Raises OSError when the link is lost."""
        if self._lost.is_set():
            raise ConnectionResetError("the link is lost")
        identifier = self._identifier
        attached = zenoh_keys.attachment(next(self._numbers), time.time_ns(), identifier) if identifier else None
        try:
            self._publisher.put(payload, attachment=attached)
        except Exception as trouble:  # zenoh's own error, which is of no common kind
            raise ConnectionResetError("the link is lost") from trouble


def load_zenoh() -> Any:
    """The package of zenoh. Raises Unavailable where it is not installed."""
    try:
        import_module("xxhash")
        import_module("zenoh.ext")
        return import_module("zenoh")
    except ImportError:
        raise zenoh_keys.needs_fleet() from None


def type_hash(name: str) -> str:
    """`RIHS01_…` of one of the usual types. Raises BadInput for another."""
    try:
        return usual_types("cdr").hash_rihs01(name)
    except KeyError:
        raise BadInput(f"{name} is not one of the usual types.") from None
