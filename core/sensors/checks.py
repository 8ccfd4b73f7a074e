"""Checks of readings: each has one code, one sentence that names cause and remedy, and one row of the docs.

One table, `checks.json`, serves live drivers, replay, offline commands and the docs. A reading that cannot be true is
not used; what was found is a `Fault`, which `beckon robot check`, *Connect*, `--json` and the report of a log show
with its code. Checks that compare senses run where both are known (`core.pilot`, `core.pipelines`,
`core.calibration`, `core.perception.sound`); their rows stand there all the same.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypedDict

import msgspec
import numpy as np

from core.errors import BadInput, BeckonError
from core.sentences import Statement

MAX_AGE_S = 0.3  # [s] of a reading by which a robot is driven; `Limits.scan_age` may be less
MAX_LEAD_S = 0.1  # [s] by which its stamp may lie ahead

Stage = Literal["form", "time", "limits", "agreement"]
"""form: shape, finite, units; time: age, order, clock; limits: the robot's own; agreement: between senses."""


@dataclass(frozen=True)
class ReadingCheck:
    """One check of a kind of reading."""

    code: str  # "scan.late": the subject, then the fault; it keeps its meaning
    stage: Stage
    compared: str  # what is compared with what, for the docs

    @property
    def sentence(self) -> Statement:
        """The cause and the remedy for people, from the catalogue; values stand in braces."""
        return Statement(self.code)


class Fault(msgspec.Struct, frozen=True, kw_only=True):
    """The finding of a check."""

    code: str
    sentence: str
    sensor: str = ""  # its name on the robot, topic or file; "": of all
    used: bool = False  # the readings are used all the same, with the doubt said
    values: dict[str, str] = {}  # in the sentence, by their names

    @property
    def statement(self) -> Statement:
        """The sentence, which knows its code."""
        return Statement.of(self.sentence, self.code, self.values)


class FoundFault(TypedDict):
    """A fault that a check found."""

    code: str
    sensor: str
    sentence: str


def found_faults(faults: Iterable[Fault]) -> list[FoundFault]:
    """Faults as JSON keys."""
    return [{"code": each.code, "sensor": each.sensor, "sentence": each.sentence} for each in faults]


class UnusableReading(BadInput):
    """Readings that cannot be used, with the faults that were found in them."""

    def __init__(self, sentence: str, faults: Iterable[Fault]) -> None:
        super().__init__(sentence)
        self.faults = tuple(faults)


TABLE = msgspec.json.decode(Path(__file__).with_suffix(".json").read_bytes(), type=dict[str, tuple[Stage, str]])
CHECKS = {code: ReadingCheck(code, *row) for code, row in TABLE.items()}
"""Every check by its code, in the order of the docs."""


def fault(code: str, sensor: str = "", *, used: bool = False, **values: object) -> Fault:
    """Make the fault of a check, its sentence filled with `values`; `sensor` is one of them.

    Raises KeyError for a code that is in no table, or a value that the sentence lacks.
    """
    pattern, texts = CHECKS[code].sentence, {name: f"{value}" for name, value in values.items()} | {"sensor": sensor}
    put = {name: text for name, text in texts.items() if f"{{{name}}}" in pattern}
    return Fault(code=code, sentence=pattern.format_map(put), sensor=sensor, used=used, values=put)


def refusal(code: str, sensor: str = "", **values: object) -> UnusableReading:
    """Make the error of a check after which nothing of the reading is used. Raises KeyError as `fault` does."""
    found = fault(code, sensor, used=False, **values)
    return UnusableReading(found.statement, (found,))


def faults_of(error: BeckonError, sensor: str = "") -> tuple[Fault, ...]:
    """Return the faults that an error carries; those that name no sensor are faults of `sensor`."""
    faults = error.faults if isinstance(error, UnusableReading) else ()
    return tuple(one if one.sensor else msgspec.structs.replace(one, sensor=sensor) for one in faults)


def distinct(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the newest fault of each code and sensor, in the order in which they first came."""
    newest: dict[tuple[str, str], Fault] = {}
    for one in faults:
        newest[one.code, one.sensor] = one
    return tuple(newest.values())


def time_fault(kind: str, sensor: str, now: float, oldest: float, newest: float) -> Fault | None:
    """Return the fault of a reading taken from `oldest` to `newest` [s] that is there at `now`; None: it is timely.

    `kind` is the subject of the codes: scan, odometry, picture, sound.
    """
    if oldest - now > MAX_LEAD_S:
        return fault(f"{kind}.future", sensor, lead=f"{oldest - now:.1f}")
    if now - newest > MAX_AGE_S:
        return fault(f"{kind}.late", sensor, age=f"{now - newest:.1f}", used=kind != "odometry")
    return None


def are_finite(*values: object) -> bool:
    """Return whether all of these, of which nothing is known yet, are finite numbers; a bool is none."""
    return all(
        isinstance(value, int | float | np.floating | np.integer) and type(value) is not bool and math.isfinite(value)
        for value in values
    )


def is_array(value: object, dimensions: int, kinds: str) -> bool:
    """Return whether a value, of which nothing is known yet, is an array of such numbers (numpy's `kinds`)."""
    return isinstance(value, np.ndarray) and value.ndim == dimensions and value.dtype.kind in kinds
