"""`zenoh://host:7447/namespace?domain=0`: a ROS 2 robot on zenoh, and no ROS on this computer.

Its nodes speak zenoh by rmw_zenoh, or DDS with zenoh-bridge-ros2dds beside them; the graph shows which.
"""

import re
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from core.errors import BadInput, Unavailable
from core.robots.device import Device, Equipment
from core.robots.readings import Readings
from core.robots.ros.bridge import RosSensors
from core.robots.ros.ros_device import TIMEOUT, RosDevice, stopping
from core.robots.ros.socket_link import split_address, take_secure
from core.robots.ros.topics import NAME, TYPES, RosSettings, RosTopics, choose_topics
from core.robots.ros.typestore import BOOL, GOAL, PARAMETER_VALUES, RobotTypes
from core.robots.ros.zenoh_keys import NO_HASH, Dialect, Endpoint
from core.robots.ros.zenoh_session import TopicWriter, ZenohAddress, ZenohConnection, type_hash

DEFAULT_PORT = 7447
MOST_DOMAIN = 232
LISTING_TIMEOUT_S = 4.0  # for the list of the robot's topics
LISTING_QUIET_S = 0.3  # without a further topic after which the list is whole
LEARNING_TIMEOUT_S = 3.0  # for the first message of every topic
TICK_S = 0.02  # between looks at what is to be sent
MAX_SILENCE_S = 2.0  # without any message after which a robot that sends many is lost
LIVELY_MESSAGES = 20  # messages within LIVELY_SPAN that make such a robot
LIVELY_SPAN_S = 4.0
MOST_NAMED = 8
INTEGER_KIND, DOUBLE_KIND = 2, 3  # kinds of a parameter's value
NUMBERS = (INTEGER_KIND, DOUBLE_KIND)


class ZenohRobot(RosDevice):
    """A robot behind a zenoh router."""

    def __init__(self, address: ZenohAddress) -> None:
        super().__init__(address.settings)
        self.address = address
        self._link: ZenohConnection | None = None
        self._equipment: Equipment | None = None  # as it was found at the first connection
        self._dialect: Dialect = "rmw"  # of the robot
        self._latched: set[str] = set()
        self._writers: dict[str, TopicWriter] = {}  # by topic
        # [s] when the last messages came, latched ones apart
        self._arrived: deque[float] = deque(maxlen=LIVELY_MESSAGES)
        self._fell_silent = False

    def open(self) -> Equipment:
        """Connect, find the robot's topics and hear every one once. Raises Unavailable with a sentence."""
        link = self._link = ZenohConnection(self.address)
        self._listen(link, LISTING_TIMEOUT_S, lambda: self._is_listed(link))
        endpoints = self._endpoints(link)
        dialect = self._dialect = endpoints[0].dialect
        topics = self.topics = self.topics or chosen_topics(endpoints, self.address.settings)
        self.types = RobotTypes()
        sensors = self.sensors = self.sensors or RosSensors(self.types, topics, self._send_goal)
        sensors.types = self.types
        self._arrived.clear()
        self._subscribe(link, endpoints, dialect)
        lock = topics.lock if topics.cmd_vel else ""
        written = ((topics.cmd_vel, topics.cmd_vel_type), (lock, BOOL), (topics.goal, GOAL))
        self._writers = {topic: link.writer(topic, kind, dialect) for topic, kind in written if topic}
        self._listen(
            link, LEARNING_TIMEOUT_S, lambda: not sensors.missing and (self._arrived or not self._fell_silent)
        )
        if self._fell_silent and not self._arrived:
            raise Unavailable(f"The robot at {self.address.name} is there, but sends nothing.")
        self._fell_silent = False
        if self._equipment is None and topics.cmd_vel:
            sensors.timeout = self._stopping(link, dialect)
        name = f"ROS robot at {self.address.name}{self.address.settings.namespace}"
        self._equipment = self._equipment or sensors.equipment(name)
        return self._equipment

    def run(self, readings: Readings) -> None:
        """Hand on what comes, until the link or the robot's base is lost, or the link closed."""
        link, sensors, topics = self._link, self.sensors, self.topics
        if link is None or sensors is None or topics is None:
            return
        seen, listens = link.graph.changed, self._listens(link, topics)
        if topics.cmd_vel and not listens:
            readings.note(f"Nothing on the robot listens to {topics.cmd_vel}; until it does, nothing moves.")
        self._restart()
        sensors.attach(readings)
        try:
            while not link.lost.is_set():
                self._take(link, TICK_S)
                self._commands.tick()
                if link.graph.changed != seen:
                    seen, listened = link.graph.changed, listens
                    listens = self._listens(link, topics)
                    if listens != listened:
                        return
                if self._is_silent():
                    return
        finally:
            link.lost.set()  # from here on nothing counts as sent
            sensors.detach()

    def close(self) -> None:
        """Stop, and let go of the link."""
        self._finish()
        link = self._link
        if link is not None:
            link.close()

    def _is_listed(self, link: ZenohConnection) -> bool:
        return bool(link.graph.endpoints()) and time.monotonic() - link.graph.changed > LISTING_QUIET_S

    def _endpoints(self, link: ZenohConnection) -> list[Endpoint]:
        """The robot's endpoints, all of one dialect. Raises Unavailable where there are none."""
        found, space = link.graph.endpoints(), self.address.settings.namespace
        if not found:
            raise Unavailable(
                f"The zenoh router at {self.address.name} knows no topics in domain {self.address.domain}; "
                "are the robot's nodes running, on rmw_zenoh or behind zenoh-bridge-ros2dds?"
            )
        inside = [endpoint for endpoint in found if endpoint.topic.startswith(f"{space}/")]
        if not inside:
            spaces = sorted({endpoint.topic.split("/")[1] for endpoint in found if endpoint.topic.count("/") > 1})
            has = ", ".join(spaces[:MOST_NAMED]) or "none"
            raise Unavailable(f"No topic at {self.address.name} is in the namespace {space}; there are: {has}.")
        dialect = "rmw" if any(endpoint.dialect == "rmw" for endpoint in inside) else "bridge"
        return [endpoint for endpoint in found if endpoint.dialect == dialect]

    def _subscribe(self, link: ZenohConnection, endpoints: list[Endpoint], dialect: Dialect) -> None:
        """Ask for the messages of the topics that are read, as far as their types are the usual ones."""
        topics, sensors = self.topics, self.sensors
        assert topics is not None and sensors is not None
        self._latched |= {endpoint.topic for endpoint in endpoints if endpoint.latched and endpoint.publishes}
        for topic in topics.read:
            name = topics.types[topic]
            hashes = {endpoint.hash for endpoint in link.graph.of_topic(topic, name, publishes=True)}
            if not self.types.borrow(name) or hashes - {"", NO_HASH, type_hash(name)}:
                sensors.notices.append(f"{topic} is not read: the robot's {name} is not the usual one.")
                continue
            newest_only = topic in sensors.newest_only
            link.subscribe(topic, name, dialect, latched=topic in self._latched, newest_only=newest_only)

    def _stopping(self, link: ZenohConnection, dialect: Dialect) -> float | None:
        """After how long a silence [s] the base stops by its nodes' parameters; 0: never, None: they do not say."""
        request = self.types.encode_names([TIMEOUT])
        answers = link.ask_parameters(self.address.settings.namespace, request, dialect)
        self.types.borrow(PARAMETER_VALUES)
        decoded = [self.types.decode(TIMEOUT, PARAMETER_VALUES, answer) for answer in answers]
        values = [one for answer in decoded if answer is not None for one in answer.values[:1]]
        return stopping(
            one.double_value if one.type == DOUBLE_KIND else one.integer_value
            for one in values
            if one.type in NUMBERS
        )

    def _listen(self, link: ZenohConnection, seconds: float, enough: Callable[[], object]) -> None:
        end = time.monotonic() + seconds
        while not enough() and time.monotonic() < end:
            self._take(link, TICK_S)
            if link.lost.is_set():
                raise Unavailable(f"The zenoh router at {self.address.name} hung up.")

    def _take(self, link: ZenohConnection, patience: float) -> None:
        arrived, sensors = link.waiting.take(patience), self.sensors
        fresh = sum(topic not in self._latched for topic, _, _ in arrived)
        self._arrived.extend([time.monotonic()] * min(fresh, LIVELY_MESSAGES))
        if sensors is not None:
            for topic, payload, publisher in arrived:
                sensors.take(topic, payload, publisher)

    def _is_silent(self) -> bool:
        times = self._arrived
        lively = len(times) == LIVELY_MESSAGES and times[-1] - times[0] < LIVELY_SPAN_S
        self._fell_silent = lively and time.monotonic() - times[-1] > MAX_SILENCE_S
        return self._fell_silent

    def _listens(self, link: ZenohConnection, topics: RosTopics) -> bool:
        return bool(link.graph.of_topic(topics.cmd_vel, topics.cmd_vel_type, publishes=False))

    def _advertise_speeds(self, topics: RosTopics) -> None:
        if self._link is not None:
            self._writers[topics.cmd_vel] = self._link.writer(topics.cmd_vel, topics.cmd_vel_type, self._dialect)

    def _publish(self, topic: str, kind: str, content: Any) -> None:
        if topic in self._writers:
            self._writers[topic].put(self.types.encode(kind, content))


def chosen_topics(endpoints: list[Endpoint], settings: RosSettings) -> RosTopics:
    """Choose the robot's topics. What speeds and goals are sent as, its listeners say, not who else sends some."""
    written = (*TYPES["cmd_vel"], *TYPES["goal"])
    found = {
        (endpoint.topic, endpoint.type) for endpoint in endpoints if endpoint.publishes != (endpoint.type in written)
    }
    listeners = {endpoint.topic for endpoint in endpoints if not endpoint.publishes}
    return choose_topics(sorted(found), settings, listeners)


def open_device(rest: str) -> Device:
    """`//host:7447/robot1?domain=3` → the robot. Raises BadInput with a sentence."""
    return ZenohRobot(parse_address(rest))


def parse_address(rest: str) -> ZenohAddress:
    """`//host:7447/namespace?domain=0&tls=1&ca=FILE&cert=FILE&key=FILE&scan=/front/scan` → where that is.

    Raises BadInput with a sentence.
    """
    looks = f"A robot's address on zenoh looks like //192.168.0.7:{DEFAULT_PORT}/robot1?domain=0."
    parts, fields = split_address(rest, looks)
    if not parts.hostname or parts.username or parts.fragment:
        raise BadInput(looks)
    space = parts.path.strip("/")
    if space:
        fields["namespace"] = f"/{space}"
    files = {name: _pem(name, fields.pop(name, "")) for name in ("ca", "cert", "key")}
    if bool(files["cert"]) != bool(files["key"]):
        raise BadInput("cert and key name two files that belong together; one of them is missing.")
    secure = take_secure(fields)
    return ZenohAddress(
        host=parts.hostname,
        port=DEFAULT_PORT if parts.port is None else parts.port,
        domain=_domain(fields.pop("domain", "0")),
        secure=secure,
        authority=files["ca"],
        certificate=files["cert"],
        key=files["key"],
        settings=_settings(fields),
    )


def _settings(fields: dict[str, str]) -> RosSettings:
    namespace = fields.get("namespace", "")
    if NAME.fullmatch(namespace):
        fields["namespace"] = f"/{namespace.strip('/')}"
    return RosSettings.of(fields)


def _domain(said: str) -> int:
    if not re.fullmatch("[0-9]{1,3}", said) or int(said) > MOST_DOMAIN:
        raise BadInput(f"domain is a whole number from 0 to {MOST_DOMAIN}, as in ROS_DOMAIN_ID.")
    return int(said)


def _pem(name: str, said: str) -> str:
    if said and not Path(said).is_file():
        raise BadInput(f"{name} names a file (PEM); there is no such file.")
    return said
