"""Checks of readings: each has one code, one sentence that names cause and remedy, and one row of the docs.

The same table serves live drivers, replay and offline commands. A reading that cannot be true is not used; what was
found is a `Fault`, which `beckon robot check`, *Connect*, `--json` and the report of a log show with its code.
Checks that compare senses run where both are known (`core.pilot`, `core.pipelines`, `core.calibration`,
`core.perception.sound`); their rows stand here all the same.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import msgspec

Stage = Literal["form", "time", "limits", "agreement"]
"""form: shape, finite, units; time: age, order, clock; limits: the robot's own; agreement: between senses."""


@dataclass(frozen=True)
class Check:
    """One check of a kind of reading."""

    code: str  # "scan.late": the subject, then the fault; it keeps its meaning
    stage: Stage
    compared: str  # what is compared with what, for the docs
    sentence: str  # for people: the cause and the remedy; values stand in braces


class Fault(msgspec.Struct, frozen=True, kw_only=True):
    """What a check found."""

    code: str
    sentence: str
    sensor: str = ""  # its name on the robot, topic or file; "": of all
    used: bool = False  # the readings are used all the same, with the doubt said


SCANS = (
    Check(
        "scan.malformed",
        "form",
        "number of beams, step between beams, stamp: two beams at least, finite numbers",
        "A scan of {sensor} is malformed ({what}); it is left out. Check the driver of the laser.",
    ),
)

ODOMETRY: tuple[Check, ...] = ()

CLOCKS: tuple[Check, ...] = ()

ROBOTS: tuple[Check, ...] = ()

MOUNTINGS: tuple[Check, ...] = ()

AGREEMENT: tuple[Check, ...] = ()

PICTURES: tuple[Check, ...] = ()

SOUND: tuple[Check, ...] = ()

FILES: tuple[Check, ...] = ()

CHECKS: dict[str, Check] = {
    check.code: check
    for table in (SCANS, ODOMETRY, CLOCKS, ROBOTS, MOUNTINGS, AGREEMENT, PICTURES, SOUND, FILES)
    for check in table
}


def fault(code: str, sensor: str = "", *, used: bool = False, **values: object) -> Fault:
    """Make the fault of a check, its sentence filled with `values`; `sensor` is one of them.

    Raises KeyError for a code that is in no table, or a value that the sentence lacks.
    """
    sentence = CHECKS[code].sentence.format(sensor=sensor, **values)
    return Fault(code=code, sentence=sentence, sensor=sensor, used=used)


def distinct(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Return the newest fault of each code and sensor, in the order in which they first came."""
    newest: dict[tuple[str, str], Fault] = {}
    for one in faults:
        newest[one.code, one.sensor] = one
    return tuple(newest.values())
