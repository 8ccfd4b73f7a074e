"""Messages between the console and a driver, apart from frames.

To the driver go packets of JSON; what a request asks for stays unread until the robot's own types are known.
"""

import socket
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import msgspec

from core import errors
from core.errors import BeckonError, Unavailable
from core.robots import Profile


@dataclass(frozen=True)
class OpenRequest:
    """The console's first packet: what to open."""

    url: str
    seed: int
    settings: object | None  # sections as attributes, see `connect`
    lock: Path | None = None  # a file that the driver of a real robot holds while it lives


@dataclass(frozen=True)
class DriverHello:
    """The driver's first message: here is the robot."""

    profile: Profile


@dataclass(frozen=True)
class DriverTrouble:
    """An error of the driver: there is no robot, or no answer."""

    kind: str  # name of a class in core.errors
    sentence: str
    details: str = ""  # for the log

    @classmethod
    def of(cls, error: BeckonError) -> Self:
        """Return the message for an error whose sentence is shown to people unchanged."""
        return cls(type(error).__name__, str(error))

    @property
    def error(self) -> BeckonError:
        """The same error, to be raised on this side."""
        return getattr(errors, self.kind, Unavailable)(self.sentence)


@dataclass(frozen=True)
class RobotAnswer:
    """The robot's answer to a request."""

    ref: int
    result: bytes | DriverTrouble  # JSON of the struct that the request asks for


class ControlPacket(msgspec.Struct, frozen=True, tag_field="kind"):
    """Base of what the console says to a driver that runs."""


class AskPacket(ControlPacket, frozen=True, tag="ask"):
    """A request to the robot."""

    ref: int
    request: msgspec.Raw


class GatePacket(ControlPacket, frozen=True, tag="gate"):
    """Another gate: the pipe to it comes with this packet."""


class RestPacket(ControlPacket, frozen=True, tag="rest"):
    """Nothing is under way and nobody looks, so that frames may come less often; or so no more."""

    rests: bool


class LeavePacket(ControlPacket, frozen=True, tag="leave"):
    """Stop the robot and end."""


AnyControlPacket = AskPacket | GatePacket | RestPacket | LeavePacket


def send_control(end: socket.socket, packet: ControlPacket) -> bool:
    """Send without waiting → whether it is on its way."""
    try:
        end.send(msgspec.json.encode(packet))
    except OSError:
        return False
    return True


def read_control(raw: bytes) -> AnyControlPacket | None:
    """Bytes → the packet; None for anything else."""
    try:
        return msgspec.json.decode(raw, type=AnyControlPacket)
    except msgspec.DecodeError:
        return None
