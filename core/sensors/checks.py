"""Checks of readings: each has one code, one sentence that names cause and remedy, and one row of the docs.

The same table serves live drivers, replay and offline commands. A reading that cannot be true is not used; what was
found is a `Fault`, which `beckon robot check`, *Connect*, `--json` and the report of a log show with its code.
Checks that compare senses run where both are known (`core.pilot`, `core.pipelines`, `core.calibration`,
`core.perception.sound`); their rows stand here all the same.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

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


class UnusableReading(BadInput):
    """Readings that cannot be used, with the faults that were found in them."""

    def __init__(self, sentence: str, faults: Iterable[Fault]) -> None:
        super().__init__(sentence)
        self.faults = tuple(faults)


SCAN_CHECKS = (
    ReadingCheck(
        "scan.malformed", "form", "number of beams, step between beams, stamp: two beams at least, finite numbers"
    ),
    ReadingCheck(
        "scan.late", "time", "the stamp of a scan's last beam with the time at which it came: 0.3 s at most"
    ),
    ReadingCheck(
        "scan.future", "time", "the stamp of a scan's first beam with the time at which it came: 0.1 s ahead at most"
    ),
    ReadingCheck(
        "scan.units",
        "limits",
        "the ranges of a laser with what a laser can measure: from below 2 m, to 500 m at most",
    ),
    ReadingCheck(
        "scan.no_return_mark",
        "limits",
        "how many beams end within 1 % of the longest range with how many end just before that",
    ),
    ReadingCheck(
        "scan.limits", "limits", "the ranges of a laser with range_min and range_max: some lie between them"
    ),
    ReadingCheck("scan.whole_numbers", "limits", "the ranges of a laser with whole numbers of metres"),
    ReadingCheck("scan.constant", "limits", "the ranges of a scan with each other: 2 % of difference at least"),
    ReadingCheck("scan.frozen", "agreement", "each scan with the one before while the wheels roll"),
    ReadingCheck(
        "scan.standing_beams", "agreement", "each beam over a log with the others, which vary as the robot moves"
    ),
    ReadingCheck("scan.empty", "limits", "how many beams of a log measure something: some do"),
    ReadingCheck("scan.few_hits", "limits", "how many beams of a log measure something: 0.5 % at least"),
    ReadingCheck("scan.degrees", "form", "the span of a scan's angles with a full turn in radians"),
    ReadingCheck(
        "scan.step_differs", "form", "the span of a scan by the step between its beams with that by its two ends: 5°"
    ),
    ReadingCheck(
        "scan.step_zero", "form", "the step between the beams with the angles of the first and the last one"
    ),
)

ODOMETRY_CHECKS = (
    ReadingCheck("odometry.malformed", "form", "position, heading, speeds and stamp of the odometry: finite numbers"),
    ReadingCheck("odometry.late", "time", "the stamp of the odometry with the time at which it came: 0.3 s at most"),
    ReadingCheck(
        "odometry.future", "time", "the stamp of the odometry with the time at which it came: 0.1 s ahead at most"
    ),
)

RECORDED_ODOMETRY_CHECKS = (
    ReadingCheck("odometry.no_heading", "form", "the orientation of the odometry: a quaternion of length 1"),
    ReadingCheck(
        "odometry.degrees", "limits", "the turn rate by the odometry's headings with that of a base: 4 rad/s"
    ),
    ReadingCheck("odometry.mirrored", "agreement", "the direction of the odometry's way with its own heading"),
    ReadingCheck("odometry.half_turn", "agreement", "the range of the odometry's headings with the way that it goes"),
    ReadingCheck("odometry.stands", "agreement", "the way of the odometry's place with the way of its own speeds"),
    ReadingCheck(
        "odometry.too_fast", "limits", "speed by the odometry's places with that of any robot that maps rooms: 6 m/s"
    ),
    ReadingCheck("odometry.restarted", "limits", "each step of the odometry with what the base can do in that time"),
    ReadingCheck("odometry.several", "form", "how many topics carry odometry"),
    ReadingCheck("odometry.unknown", "form", "frames that move with the usual names of odometry and robot"),
)

CLOCK_CHECKS = (
    ReadingCheck(
        "clock.set", "time", "steps of a device's stamps with the time that passed meanwhile for the recorder"
    ),
    ReadingCheck(
        "clock.recorder_set",
        "time",
        "steps of the recorder's time in the order of the file: 1 s back, 10 minutes ahead at most",
    ),
    ReadingCheck(
        "clock.differs", "time", "stamps of two devices with the times at which they were recorded: 1 s at most"
    ),
    ReadingCheck(
        "clock.backward", "time", "the order of the stamps with the order in which the readings were recorded"
    ),
    ReadingCheck(
        "clock.rate",
        "time",
        "how fast a device's stamps run with the recorder's clock (30 times at most) and another device's (0.3 s "
        "of difference over a log)",
    ),
    ReadingCheck("clock.apart", "time", "the time of the scans with the time of the odometry"),
    ReadingCheck("clock.none", "time", "stamps of readings with each other"),
    ReadingCheck("clock.rounded", "time", "stamps of readings with each other: one in ten may repeat"),
    ReadingCheck("clock.unit", "time", "the time between two scans with that of a laser: 1 ms to 20 s"),
    ReadingCheck("clock.begins_again", "time", "the order of the times with the order of the file, part by part"),
    ReadingCheck("clock.few_left", "time", "how many scans have a time of their own"),
)

ROBOT_CHECKS = (
    ReadingCheck("robots.several", "form", "the names before the topics and frames of odometry"),
    ReadingCheck(
        "robots.mixed",
        "agreement",
        "a scan, or the odometry, with those before it: it must not come back to an older place again and "
        "again, nor change its frame to and fro",
    ),
    ReadingCheck("robots.other_odometry", "form", "the robot of the odometry with the robot of the laser"),
    ReadingCheck(
        "speeds.type_guessed",
        "agreement",
        "the odometry of a ROS robot with the speeds that it was sent for 1.5 s, as a type that was guessed",
    ),
    ReadingCheck("battery.malformed", "form", "the charge of the battery: a share from 0 to 1"),
)

MOUNTING_CHECKS = (
    ReadingCheck("mount.unknown", "form", "the frame of the scans with the transforms of the log"),
    ReadingCheck("mount.too_far", "limits", "the place of the laser on the robot: 5 m from its middle at most"),
    ReadingCheck("mount.not_level", "limits", "the plane of the laser with the floor's: 20° at most"),
)

AGREEMENT_CHECKS = (
    ReadingCheck("agreement.mirrored", "agreement", "the sense of the turns by wheels and by scans"),
    ReadingCheck(
        "agreement.turn_scale",
        "agreement",
        "the size of the turns by wheels and by scans: a quarter of difference at most",
    ),
    ReadingCheck(
        "agreement.way_scale", "agreement", "the length of the ways by wheels and by scans: 5 % of difference at most"
    ),
    ReadingCheck(
        "agreement.mount", "agreement", "the direction of the ways by wheels and by scans: 8° of difference at most"
    ),
    ReadingCheck(
        "agreement.late", "agreement", "the times of the turns by wheels and by scans: 0.15 s of difference at most"
    ),
    ReadingCheck(
        "agreement.early", "agreement", "the times of the turns by wheels and by scans: 0.15 s of difference at most"
    ),
    ReadingCheck(
        "agreement.differ",
        "agreement",
        "each move by wheels with that by scans, where nothing above explains a difference",
    ),
    ReadingCheck("agreement.no_fit", "agreement", "scans of a moving robot with each other: one in five fits"),
    ReadingCheck("agreement.wheels_stand", "agreement", "wheels that stand for 1.5 s with scans that move"),
    ReadingCheck("agreement.wheels_spin", "agreement", "wheels that roll for 1.5 s with scans that stand"),
)

PICTURE_CHECKS = (
    ReadingCheck(
        "picture.malformed",
        "form",
        "shape, kind of numbers and stamp of a picture: height x width x 3 bytes, a finite stamp",
    ),
    ReadingCheck("picture.late", "time", "the stamp of a picture with the time at which it came: 0.3 s at most"),
    ReadingCheck(
        "picture.future", "time", "the stamp of a picture with the time at which it came: 0.1 s ahead at most"
    ),
    ReadingCheck(
        "camera.two_settings", "agreement", "one camera for all pictures with two cameras, each for a part of them"
    ),
    ReadingCheck("camera.odd_part", "agreement", "one camera for all pictures with another one for a few of them"),
    ReadingCheck(
        "camera.focal_undecided", "agreement", "focal lengths that fit the pictures about as well as the best"
    ),
    ReadingCheck(
        "camera.one_tilt", "agreement", "tilts of the board in the pictures with each other: 3 degrees at least"
    ),
    ReadingCheck(
        "camera.off_centre", "agreement", "middle of the lens with the picture's: 15 % of a side away at most"
    ),
    ReadingCheck("board.unequal_squares", "agreement", "height of the squares with their width, from all pictures"),
    ReadingCheck(
        "board.bent",
        "agreement",
        "heights of the board's corners with a plane, from all pictures: 0.15 % of its diagonal at most",
    ),
    ReadingCheck("board.other_count", "form", "inner corners of the board in a picture with those entered"),
    ReadingCheck("board.use_other", "form", "inner corners of the board in most pictures with those entered"),
    ReadingCheck("board.inverted", "form", "a board in the picture with one in its negative"),
    ReadingCheck(
        "board.separate_squares", "form", "squares that stand apart with squares that touch at their corners"
    ),
)

SOUND_CHECKS = (
    ReadingCheck(
        "sound.malformed",
        "form",
        "shape, kind of numbers and stamp of a piece of sound: samples x channels, a finite stamp",
    ),
    ReadingCheck("sound.late", "time", "the end of a piece of sound with the time at which it came: 0.3 s at most"),
    ReadingCheck(
        "sound.future", "time", "the end of a piece of sound with the time at which it came: 0.1 s ahead at most"
    ),
    ReadingCheck(
        "sound.no_rate", "form", "the bytes per second of sound that says no rate with those of usual microphones"
    ),
    ReadingCheck("array.dead", "form", "level of a channel with that of no sound at all"),
    ReadingCheck("array.faint", "form", "level of a channel with the others'"),
    ReadingCheck("array.clipped", "limits", "samples at a channel's limit, in runs"),
    ReadingCheck("array.identical", "agreement", "channels with each other at the same moment"),
    ReadingCheck("array.line", "form", "places of the microphones: not all in a line"),
    ReadingCheck("array.inverted", "agreement", "the sign of a channel with the others'"),
    ReadingCheck(
        "array.foreign",
        "agreement",
        "what a channel shares with the others within the time that sound takes between them",
    ),
    ReadingCheck(
        "array.processed", "agreement", "the times and the noise of a channel with those of a sum of all microphones"
    ),
    ReadingCheck(
        "array.sharing",
        "agreement",
        "the noise that two channels share with what others do, where sound is shorter than their distance",
    ),
    ReadingCheck(
        "array.swapped",
        "agreement",
        "the times of all microphones with a plane wave, in the profile's order and with two exchanged",
    ),
    ReadingCheck(
        "array.late", "agreement", "the times of all microphones with a plane wave, and with one or two that are late"
    ),
    ReadingCheck("array.scale", "limits", "the times of all microphones with the array's size"),
    ReadingCheck("array.misfit", "agreement", "the times of all microphones with a plane wave"),
    ReadingCheck("sound.units", "form", "the loudest sample of a file with full scale: 8 times at most"),
)

FILE_CHECKS = (
    ReadingCheck("picture.unreadable", "form", "a file with the pictures that are read: its kind, its size, its end"),
    ReadingCheck("camera.malformed", "form", "a camera file with its form: size, matrix, distortion, finite numbers"),
    ReadingCheck("camera.other_model", "form", "the model that a camera file names with plumb_bob"),
    ReadingCheck(
        "camera.unnamed_model",
        "form",
        "four distortion numbers with the models that have four: plumb_bob and fisheye",
    ),
    ReadingCheck("camera.rational", "form", "distortion numbers from the sixth on with zero"),
    ReadingCheck("camera.binned", "limits", "principal point with the picture's middle"),
    ReadingCheck("laser.degrees", "form", "span of a scan's angles with a full turn"),
    ReadingCheck(
        "laser.other_form", "agreement", "camera's boards with the scans, as they are and in other units and senses"
    ),
    ReadingCheck("laser.mixed_units", "agreement", "the ranges of the scans of one place with each other: six times"),
    ReadingCheck(
        "laser.other_pairing", "agreement", "camera's boards with the scans of the same and of other pictures"
    ),
)

CHECKS: dict[str, ReadingCheck] = {
    check.code: check
    for table in (
        SCAN_CHECKS,
        ODOMETRY_CHECKS,
        RECORDED_ODOMETRY_CHECKS,
        CLOCK_CHECKS,
        ROBOT_CHECKS,
        MOUNTING_CHECKS,
        AGREEMENT_CHECKS,
        PICTURE_CHECKS,
        SOUND_CHECKS,
        FILE_CHECKS,
    )
    for check in table
}


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
        return fault(f"{kind}.late", sensor, age=f"{now - newest:.1f}", used=True)
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
