"""What a command is, and what it needs to be obeyed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from core.gate import Twist
from core.message import Array, message
from core.navigation.surroundings import Surroundings
from core.perception.people.call import Call
from core.perception.people.person import PersonSeen


@message
class Number:
    """A parameter of a command."""

    name: str  # "distance_m": its key in JSON, with the unit
    says: str  # "x": how Table 2 writes it
    unit: str  # "m" | "rad"
    low: float
    high: float
    default: float | None = None  # None: the words must give it
    spoken_high: float | None = None  # a tighter bound on the size of what was spoken aloud; None: none


@message
class Command:
    """Words that were understood."""

    name: str  # "continue"
    numbers: Mapping[str, float]  # {"distance_m": 1.5}
    heard_as: str  # canonical words: "continue 1.5 meters"
    remark: str = ""  # a sentence for the operator: why this and not what the words began to say
    call: Call | None = None  # from where it was spoken; None: it was not, or nobody knows


@message
class Progress:
    """One step of obeying."""

    twist: Twist = Twist()
    finished: str = ""  # "" while under way, else "done" or "failed"
    remark: str = ""  # a sentence for the operator
    fraction: float | None = None  # 0..1 of the way
    path: Array | None = None  # (P, 2) [m], world: newly planned; None: unchanged
    goal: Array | None = None  # (2,) [m], world
    person: PersonSeen | None = None  # who is looked at


class Action(Protocol):
    """A command being obeyed: made once by the kind's `begin`, then asked for a twist with every frame."""

    def drive(self, here: Surroundings) -> Progress:
        """One frame further."""
        ...


class Kind(Protocol):
    """One row of Table 2."""

    @property
    def name(self) -> str:
        """The row's key in JSON: "turn_left"."""
        ...

    @property
    def words(self) -> tuple[str, ...]:
        """Patterns; numbers stand as {distance_m}: "continue {distance_m} meters". The first is the canonical one."""
        ...

    @property
    def numbers(self) -> tuple[Number, ...]:
        """The parameters."""
        ...

    @property
    def example(self) -> str:
        """Words that are understood as they stand: "continue 1.5 meters"."""
        ...

    @property
    def summary(self) -> str:
        """A sentence for people: "Turns left 90 degrees on the spot."."""
        ...

    @property
    def moves(self) -> bool:
        """Whether obeying it moves the robot."""
        ...

    def begin(self, command: Command, here: Surroundings) -> Action:
        """Start obeying. Raises Refused with a sentence when that is impossible from here."""
        ...
