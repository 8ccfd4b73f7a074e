"""The typed messages of the gate: requests of the console, reports of the driver, and twists for the driver.

Each is read from a packet by one rule: it has exactly its fields, or it is no such message. Whether the numbers of a
setpoint are any good is the gate's to judge, which answers for each.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from core.gate.limits import is_count, is_number
from core.gate.packets import Packet, construct
from core.gate.setpoint import Setpoint

ReachingPart = Literal["pilot", "ears"]
MOST_LETTERS = 200  # of an owner's name


@dataclass(frozen=True)
class GateHeartbeat:
    """The console is alive."""


@dataclass(frozen=True)
class GateStop:
    """Zero; the present press moves the robot no more."""


@dataclass(frozen=True)
class GateHalt:
    """Zero, latched on disk."""

    number: int = 0  # returned in the status when the latch is on disk


@dataclass(frozen=True)
class GateReset:
    """Lift the halt."""


@dataclass(frozen=True)
class GateArm:
    """A lease begins."""

    epoch: object  # as it was sent: the gate says why it refuses one that is no number
    owner: str


@dataclass(frozen=True)
class GateDisarm:
    """The lease ends."""


@dataclass(frozen=True)
class GateCap:
    """No faster than this from now on [m/s]; None: as the limits say."""

    speed: float | None


@dataclass(frozen=True)
class GateReach:
    """A part of the console has worked on what a simulator sensed until then [s]; None: nobody need wait for it."""

    stamp: float | None
    part: ReachingPart = "pilot"


@dataclass(frozen=True)
class GateLeave:
    """The console ends."""


GateRequest = (
    Setpoint
    | GateHeartbeat
    | GateStop
    | GateHalt
    | GateReset
    | GateArm
    | GateDisarm
    | GateCap
    | GateReach
    | GateLeave
)


@dataclass(frozen=True)
class DriverReport:
    """The driver's report with every frame."""

    contact: bool
    points: Sequence[Sequence[float]] | None  # (N, 2) [m], robot frame: near scan points; None: no new scan
    field: float  # [rad] to either side that the scan covers
    stamp: float | None = None  # [s] of the frame, robot's clock; None: a real robot, whose clock is not looked at
    age: float | None = None  # [s] of the scan by its stamp; without points: of one left out for it, < 0: ahead
    trouble: bool = False  # the robot cannot be driven now


def read_request(packet: Packet) -> GateRequest | None:
    """A packet of the console → its request; None where it is not of the form that the console sends."""
    fields = {name: value for name, value in packet.items() if name != "kind"}
    read = KINDS.get(str(packet.get("kind")))
    try:
        return None if read is None else read(fields)
    except (KeyError, TypeError):
        return None


def read_report(packet: Packet) -> DriverReport:
    """A packet of the driver → what it reports; a part that is not of its form counts as left out."""
    points, field, stamp, age = (packet.get(name) for name in ("points", "field", "stamp", "age"))
    return DriverReport(
        contact=packet.get("contact") is True,
        points=points if isinstance(points, list) else None,
        field=float(field) if is_number(field) else math.pi,
        stamp=float(stamp) if is_number(stamp) else None,
        age=float(age) if is_number(age) else None,
        trouble=packet.get("trouble") is True,
    )


def _halt(fields: Packet) -> GateHalt:
    number = fields.get("number")
    return GateHalt(number if is_count(number) else 0)


def _reach(fields: Packet) -> GateReach:
    stamp = fields.get("stamp")
    return GateReach(float(stamp) if is_number(stamp) else None, "ears" if fields.get("part") == "ears" else "pilot")


def _cap(fields: Packet) -> GateCap:
    speed = fields["speed"]
    if speed is None:
        return GateCap(None)
    if not is_number(speed):
        raise TypeError("a cap is a number")
    return GateCap(float(speed))


def _arm(fields: Packet) -> GateArm:
    return GateArm(fields["epoch"], str(fields["owner"])[:MOST_LETTERS])


KINDS: dict[str, Callable[[Packet], GateRequest]] = {
    "set": lambda fields: construct(Setpoint, fields),
    "beat": lambda _: GateHeartbeat(),
    "stop": lambda _: GateStop(),
    "halt": _halt,
    "reset": lambda _: GateReset(),
    "arm": _arm,
    "disarm": lambda _: GateDisarm(),
    "cap": _cap,
    "reach": _reach,
    "leave": lambda _: GateLeave(),
}
"""How each is read, by its `kind`. What stops the robot is understood whatever else the packet holds."""
