"""Common part of all links to a ROS robot over a WebSocket: connecting, learning what is there, reading, driving.

A link of its own kind says how it asks for the robot's topics, subscribes, reads a message and sends speeds.
"""

import socket
import ssl
import time
from abc import abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, parse_qsl, urlsplit

from core.errors import BadInput, Unavailable
from core.message import message
from core.robots.device import Equipment
from core.robots.readings import Readings
from core.robots.ros.bridge import RosSensors
from core.robots.ros.ros_device import RosDevice
from core.robots.ros.topics import DESCRIPTION, NOTHING, RosSettings, RosTopics, choose_topics
from core.robots.ros.typestore import RobotTypes
from core.robots.ros.web_socket import WebSocket

CONNECT_TIMEOUT_S = 3.0  # to reach the robot
LISTING_TIMEOUT_S = 4.0  # for the list of its topics
LEARNING_TIMEOUT_S = 3.0  # for the first message of every topic
DESCRIBING_TIMEOUT_S = 1.0  # more for the robot's parameters
TICK_S = 0.02  # between looks at what is to be sent
REMEMBERED_SENTENCES = 32  # sentences of the robot that are not repeated


@message
class RosAddress:
    """Address of a robot's link, and the options of its URL."""

    host: str
    port: int
    secure: bool = False
    authority: str = ""  # a file with the certificate that the robot's one is checked by; "": the usual ones
    certified: str = ""  # the name in the robot's certificate; "": the host
    options: Mapping[str, str]  # of this kind of link
    settings: RosSettings = RosSettings()

    @property
    def name(self) -> str:
        """host:port."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def certified_name(self) -> str:
        """The same as the robot is to hear it: by the name in its certificate."""
        return f"{self.certified}:{self.port}" if self.certified else self.name


def parse_address(rest: str, port: int, options: Sequence[str] = ()) -> RosAddress:
    """`//host:port?tls=1&tls_name=robot.lan&scan=/front/scan` → where that is.

    `options` are the further keys that this kind of link knows. Raises BadInput with a sentence.
    """
    looks = f"A ROS robot's address looks like //192.168.0.7:{port}"
    parts, fields = split_address(rest, f"{looks}; this one cannot be read.")
    if not parts.hostname or parts.path not in ("", "/") or parts.username or parts.fragment:
        raise BadInput(f"{looks}, with options after a question mark.")
    return RosAddress(
        host=parts.hostname,
        port=port if parts.port is None else parts.port,
        secure=take_secure(fields),
        authority=fields.pop("ca", ""),
        certified=fields.pop("tls_name", ""),
        options={key: fields.pop(key) for key in options if key in fields},
        settings=RosSettings.of(fields),
    )


def split_address(rest: str, looks: str) -> tuple[SplitResult, dict[str, str]]:
    """The part of a URL after its scheme → its parts, and its options. Raises BadInput with the sentence `looks`."""
    try:
        parts = urlsplit(rest)
        _ = parts.port  # which is a number, or none
        return parts, dict(parse_qsl(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query)))
    except ValueError:
        raise BadInput(looks) from None


def take_secure(fields: dict[str, str]) -> bool:
    """Take the option `tls` out of a robot's. Raises BadInput."""
    secure = fields.pop("tls", "0").lower()
    if secure not in ("0", "1", "true", "false"):
        raise BadInput("tls is 1 (encrypted) or 0.")
    return secure in ("1", "true")


class RosSocket(RosDevice):
    """A ROS robot behind a WebSocket."""

    kind = ""  # "foxglove bridge"
    advice = ""  # how it is started on the robot
    subprotocols: Sequence[str] = ()

    def __init__(self, address: RosAddress) -> None:
        super().__init__(address.settings)
        self.address = address
        self.unreadable = 0  # messages of the link itself that could not be read
        self.timeout: float | None = None  # [s] of silence after which the base stops, 0: never; None: not known
        self.description = ""  # the robot's URDF where it comes as a parameter
        self._socket: WebSocket | None = None
        self._readings: Readings | None = None
        self._equipment: Equipment | None = None  # as it was found at the first connection
        self._notes: list[str] = []
        self._said: deque[str] = deque(maxlen=REMEMBERED_SENTENCES)

    def open(self) -> Equipment:
        """Connect, find the robot's topics and hear every one once. Raises Unavailable with a sentence."""
        self.types = RobotTypes()
        self._socket = self._connected()
        self._begin()
        self._listen(LISTING_TIMEOUT_S, self._is_listed)
        if self.topics is None:
            self.topics = self._chosen()
        if self.sensors is None:
            self.sensors = RosSensors(self.types, self.topics, self._send_goal)
        sensors = self.sensors
        sensors.types = self.types
        self._subscribe(self.topics)
        self._ask_parameters(self.topics)
        self._listen(LEARNING_TIMEOUT_S, lambda: not sensors.missing)
        self._listen(DESCRIBING_TIMEOUT_S, self._is_described)
        sensors.timeout = self.timeout
        if self.description and not self.topics.description and self.address.settings.description != NOTHING:
            sensors.describe(self.description, DESCRIPTION)
        if self.topics.cmd_vel or self.topics.goal:
            self._advertise(self.topics)
        for name, why in self.types.skipped.items():
            self._note(f"{name} is not read: {why}.")
        self._equipment = self._equipment or sensors.equipment(f"ROS robot at {self.address.name}")
        return self._equipment

    def run(self, readings: Readings) -> None:
        """Hand on what comes, until the link is lost or closed."""
        if self.sensors is None:
            return
        self._readings = readings
        for sentence in self._notes:
            readings.note(sentence)
        self._notes = []
        self._restart()
        self.sensors.attach(readings)
        try:
            while self._hear(TICK_S):
                self._commands.tick()
        finally:
            self.sensors.detach()
            self._readings = None

    def close(self) -> None:
        """Stop, and let go of the link."""
        self._finish()
        link, self._socket = self._socket, None
        if link is not None:
            link.close()

    # What a kind of link says of itself.

    @abstractmethod
    def _begin(self) -> None:
        """Ask for the robot's topics; `_read` hears the answer."""

    @abstractmethod
    def _is_listed(self) -> bool:
        """Return whether the list of topics is whole."""

    def _ask_parameters(self, topics: RosTopics) -> None:
        """Ask for the robot's parameters, where that was not done with the topics; `_read` hears the answers."""

    def _is_described(self) -> bool:
        """Return whether the robot's parameters have come, where the link tells them."""
        return True

    @abstractmethod
    def _chosen(self) -> RosTopics:
        """Choose among the topics that are listed. Raises Unavailable."""

    @abstractmethod
    def _subscribe(self, topics: RosTopics) -> None:
        """Ask for the messages of the topics that are read, and take in their types."""

    @abstractmethod
    def _advertise(self, topics: RosTopics) -> None:
        """Say that speeds, goals and beats of the lock will come, as far as the topics are there."""

    @abstractmethod
    def _read(self, raw: str | bytes) -> tuple[str, Any] | None:
        """A message of the link → a topic and what came on it; None for what was of another kind, and is done."""

    def _take(self, sensors: RosSensors, topic: str, payload: Any) -> None:
        """Hand a message on, which is bytes here."""
        sensors.take(topic, payload)

    # What they have in common.

    def _choose(self, found: Sequence[tuple[str, str]], listeners: set[str] | None = None) -> RosTopics:
        if not found:
            raise Unavailable(
                f"The {self.kind} at {self.address.name} knows no topics; are the robot's nodes running?"
            )
        return choose_topics(found, self.address.settings, listeners)

    def _connected(self) -> WebSocket:
        address = self.address
        try:
            end = socket.create_connection((address.host, address.port), CONNECT_TIMEOUT_S)
        except OSError as trouble:
            why = trouble.strerror or "it did not answer in time"
            raise Unavailable(f"No {self.kind} at {address.name}: {why}. {self.advice}") from None
        try:
            url = f"ws://{address.name}/"
            if address.secure:
                end = self._trust().wrap_socket(end, server_hostname=address.certified or address.host)
                url = f"wss://{address.certified_name}/"
            return WebSocket(end, url, self.subprotocols, CONNECT_TIMEOUT_S)
        except ssl.SSLError as trouble:
            end.close()
            raise Unavailable(f"The connection to {address.name} cannot be encrypted: {trouble.reason}.") from None
        except OSError:
            end.close()
            raise Unavailable(
                f"What answers at {address.name} is no {self.kind}, or of a version that this console does not speak."
            ) from None
        except BaseException:
            end.close()
            raise

    def _trust(self) -> ssl.SSLContext:
        authority = self.address.authority
        if authority and not Path(authority).is_file():
            raise BadInput("ca names a file with a certificate (PEM); there is no such file.")
        try:
            return ssl.create_default_context(cafile=authority or None)
        except ssl.SSLError:
            raise BadInput("The file that ca names holds no certificate (PEM).") from None

    def _listen(self, seconds: float, enough: Callable[[], bool]) -> None:
        end = time.monotonic() + seconds
        while not enough() and time.monotonic() < end:
            if not self._hear(0.05):
                raise Unavailable(f"The {self.kind} at {self.address.name} hung up.")

    def _hear(self, patience: float) -> bool:
        """All messages that are there, or the next within `patience` [s] → False when the link is lost."""
        link = self._socket
        if link is None:
            return False
        try:
            read = [self._read_safely(raw) for raw in link.receive(patience)]
        except OSError:
            return False
        arrived = [found for found in read if found is not None]
        if self._readings is not None:
            self._readings.arrived(f"the {self.kind}", readable=len(arrived))
        if arrived and self.sensors is not None:
            self._hand_on(self.sensors, arrived)
        return True

    def _hand_on(self, sensors: RosSensors, arrived: list[tuple[str, Any]]) -> None:
        newest = {topic: number for number, (topic, _) in enumerate(arrived)}
        for number, (topic, payload) in enumerate(arrived):
            if topic not in sensors.newest_only or newest[topic] == number:
                self._take(sensors, topic, payload)

    def _read_safely(self, raw: str | bytes) -> tuple[str, Any] | None:
        try:
            return self._read(raw)
        except Exception:  # whatever a hostile message brings about, the next one may be fine
            self.unreadable += 1
            if self._readings is not None:
                self._readings.arrived(f"the {self.kind}", unreadable=1)
            return None

    def _send(self, payload: str | bytes) -> None:
        link = self._socket
        if link is None:
            raise ConnectionResetError("the link is closed")
        link.send(payload)

    def _note(self, sentence: str) -> None:
        if sentence in self._said:
            return
        self._said.append(sentence)
        if self._readings is not None:
            self._readings.note(sentence)
        else:
            self._notes.append(sentence)
