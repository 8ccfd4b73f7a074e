"""What the console and a driver write to each other, apart from frames and requests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from core import errors
from core.errors import BeckonError, Unavailable
from core.robots import Profile


@dataclass(frozen=True)
class Opening:
    """The console's first packet: what to open."""

    url: str
    seed: int
    settings: object | None  # sections as attributes, see `connect`


@dataclass(frozen=True)
class Hello:
    """The driver's first message: here is the robot."""

    profile: Profile


@dataclass(frozen=True)
class Trouble:
    """Why there is no robot, or no answer."""

    kind: str  # name of a class in core.errors
    sentence: str
    details: str = ""  # for the log

    @staticmethod
    def of(error: BeckonError) -> Trouble:
        """An error that is told to people as it stands."""
        return Trouble(type(error).__name__, str(error))

    @property
    def error(self) -> BeckonError:
        """The same error, to be raised on this side."""
        kind = getattr(errors, self.kind, Unavailable)
        return kind(self.sentence)


@dataclass(frozen=True)
class Answer:
    """What the robot said to a request."""

    ref: int
    told: dict[str, Any] | Trouble
