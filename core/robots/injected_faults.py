"""Faults that a simulated robot can be given, `sim:lab?faults=late_scan:1.5,slip:0.2`: the table of them.

The simulator has them by these rows, the documentation's page *What happens when* is written from them. A module of
its own, since neither the console nor the drivers may know the simulation.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar
from urllib.parse import parse_qsl

from core.errors import BadInput
from core.sensors.checks import are_finite
from core.setting import Meta

ItemT = TypeVar("ItemT")
QUERY = "faults"


@dataclass(frozen=True)
class InjectableFault:
    """A fault of a simulated robot."""

    name: str
    value: float  # where none is given
    number: Meta  # what it says, and its bounds
    seen: str  # what the operator sees, and what the robot does


INJECTABLE_FAULTS = (
    InjectableFault(
        "late_scan",
        1.5,
        Meta("s", 0, 10, "scans arrive so much later than they were measured"),
        "The robot stands 0.3 s after scans begin to be late, and a notice says by how much: *Scans of laser "
        "are 1.5 s late*. After a second what is under way has failed. Up to 0.3 s late it drives on, and "
        "slows down farther from a wall.",
    ),
    InjectableFault(
        "early_scan",
        60.0,
        Meta("s", 0, 3600, "stamps of scans lie so far ahead"),
        "The robot stands within 0.3 s, and a notice says by how much the clock of the laser is ahead. Such scans "
        "are not used at all: the map stays as it is, and the pose goes on by the wheels.",
    ),
    InjectableFault(
        "lost_scan",
        1.0,
        Meta("", 0, 1, "share of the scans that never arrive"),
        "A few are not noticed. Without one the robot stands within 0.3 s, a notice says *No scan comes from "
        "the laser*, and after a second what is under way has failed.",
    ),
    InjectableFault(
        "frozen_scan",
        1.0,
        Meta("", 0, 1, "1: the laser shows the same scan again and again"),
        "A robot that drives stands within half a second, and a notice says that the laser repeats one scan. "
        "It drives again when scans change again.",
    ),
    InjectableFault(
        "blind_scan",
        1.0,
        Meta("", 0, 1, "share of the beams that measure nothing"),
        "Up to nine tenths it drives on by what is left. With a laser that is blind altogether the robot "
        "stands within 0.3 s, and what is under way fails.",
    ),
    InjectableFault(
        "slip",
        0.2,
        Meta("", 0, 0.9, "share of each way that the wheels turn in vain"),
        "The line of the wheels leaves that of the estimate, which sees the walls. Where the two differ too "
        "much, the robot says that it has lost its place, stands, and looks for it.",
    ),
    InjectableFault(
        "odometry_jump",
        1.0,
        Meta("m", 0, 100, "the odometry steps aside by so much every 5 s"),
        "The robot says that it has lost its place and stands, turns for another look, and says when it knows "
        "its place again. The command has to be given once more.",
    ),
    InjectableFault(
        "late_picture",
        1.5,
        Meta("s", 0, 10, "pictures arrive so much later than they were taken"),
        "A notice says how late the camera is. Commands without the camera go on; nobody is followed by such "
        "pictures.",
    ),
    InjectableFault(
        "black_picture",
        1.0,
        Meta("", 0, 1, "1: pictures are black"),
        "A notice says that the camera repeats one picture; it is not used. FOLLOW ME finds nobody.",
    ),
    InjectableFault(
        "frozen_picture",
        1.0,
        Meta("", 0, 1, "1: the camera shows the same picture again and again"),
        "A notice says that the camera repeats one picture while the robot moves; it is not used until "
        "another one comes.",
    ),
    InjectableFault(
        "no_sound",
        1.0,
        Meta("", 0, 1, "1: nothing comes from the microphones"),
        "Nothing is heard: words that are spoken in the room do nothing. STOP is on the page.",
    ),
    InjectableFault(
        "bumper",
        1.0,
        Meta("", 0, 1, "1: the bumper stays pressed"),
        "The robot stands at once, says *The robot touches something*, and what is under way has failed. Only "
        "the way back is open.",
    ),
    InjectableFault(
        "battery",
        0.05,
        Meta("", 0, 1, "how full the battery says it is"),
        "The battery's sign shows it; a route ends at its next stop when it is low.",
    ),
    InjectableFault(
        "after",
        10.0,
        Meta("s", 0, 3600, "no fault of its own: the others begin so long after the start"),
        "Until then the robot is well.",
    ),
)


def faults_of(place: str) -> tuple[str, dict[str, float]]:
    """`lab?faults=slip:0.2,bumper` → the place, and the faults with their values. Raises BadInput."""
    name, _, query = place.partition("?")
    asked = dict(parse_qsl(query, keep_blank_values=True))
    if unknown := sorted(set(asked) - {QUERY}):
        raise BadInput(f"A simulated robot takes faults=… alone, and no {unknown[0][:30]!r}.")
    return name, read_faults(asked.get(QUERY, ""))


def read_faults(text: str) -> dict[str, float]:
    """`late_scan:1.5,bumper` → values by name. Raises BadInput with the faults that there are."""
    known = {one.name: one for one in INJECTABLE_FAULTS}
    given: dict[str, float] = {}
    for item in filter(None, (part.strip() for part in text.split(","))):
        name, _, number = item.partition(":")
        row = known.get(name)
        if row is None:
            raise BadInput(f"There is no fault {name[:30]!r} to be simulated; choose from {', '.join(known)}.")
        try:
            value = float(number) if number else row.value
        except ValueError:
            value = float("nan")
        low, high, unit = row.number.low, row.number.high, f" {row.number.unit}" if row.number.unit else ""
        if not are_finite(value) or not low <= value <= high:
            raise BadInput(f"The fault {name} takes a number from {low:g} to {high:g}{unit}: {row.number.meaning}.")
        given[name] = value
    return given


class Delay(Generic[ItemT]):
    """Hold back what arrives late, in its order."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, ItemT]] = deque()

    def put(self, item: ItemT, due: float) -> None:
        """Hold it back until the time `due` [s]."""
        self._waiting.append((due, item))

    def arrived(self, now: float) -> Iterator[ItemT]:
        """Everything that is due by now [s], eldest first."""
        while self._waiting and self._waiting[0][0] <= now:
            yield self._waiting.popleft()[1]
