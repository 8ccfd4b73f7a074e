"""Messages between the console and a driver, apart from frames and requests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from core import errors
from core.errors import BeckonError, Unavailable
from core.robots import Profile


@dataclass(frozen=True)
class OpenRequest:
    """The console's first packet: what to open."""

    url: str
    seed: int
    settings: object | None  # sections as attributes, see `connect`


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

    @staticmethod
    def of(error: BeckonError) -> DriverTrouble:
        """Return the message for an error whose sentence is shown to people unchanged."""
        return DriverTrouble(type(error).__name__, str(error))

    @property
    def error(self) -> BeckonError:
        """The same error, to be raised on this side."""
        kind = getattr(errors, self.kind, Unavailable)
        return kind(self.sentence)


@dataclass(frozen=True)
class RobotAnswer:
    """The robot's answer to a request."""

    ref: int
    result: dict[str, Any] | DriverTrouble
