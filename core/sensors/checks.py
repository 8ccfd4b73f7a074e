"""Checks of readings: each has one code, one sentence that names cause and remedy, and one row of the docs.

The same table serves live drivers, replay and offline commands. A reading that cannot be true is not used; what was
found is a `Fault`, which `beckon robot check`, *Connect*, `--json` and the report of a log show with its code.
Checks that compare senses run where both are known (`core.pilot`, `core.pipelines`, `core.calibration`,
`core.perception.sound`); their rows stand here all the same.
"""

from __future__ import annotations

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
    sentence: str  # for people: the cause and the remedy; values stand in braces


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
        "scan.malformed",
        "form",
        "number of beams, step between beams, stamp: two beams at least, finite numbers",
        "A scan of {sensor} is malformed ({what}); it is left out. Check the driver of the laser.",
    ),
    ReadingCheck(
        "scan.late",
        "time",
        "the stamp of a scan's last beam with the time at which it came: 0.3 s at most",
        "Scans of {sensor} are {age} s late, so they do not steer the robot. Look for a slow link, a queue on the "
        "way or a clock that was set; stamp a scan when it is measured.",
    ),
    ReadingCheck(
        "scan.future",
        "time",
        "the stamp of a scan's first beam with the time at which it came: 0.1 s ahead at most",
        "Scans of {sensor} are stamped {lead} s in the future, so they do not steer the robot. Check the clock that "
        "the driver of the laser stamps them by.",
    ),
    ReadingCheck(
        "scan.units",
        "limits",
        "the ranges of a laser with what a laser can measure: from below 2 m, to 500 m at most",
        "The ranges of {sensor} are not in metres (from {nearest} to {farthest}); they are taken for {unit}. Let the "
        "driver publish metres.",
    ),
    ReadingCheck(
        "scan.no_return_mark",
        "limits",
        "how many beams end within 1 % of the longest range with how many end just before that",
        "{share} % of the beams of {sensor} end at {range} m: a mark for nothing there, not a wall. They are "
        "taken for that. Set the longest range of the driver below its mark.",
    ),
    ReadingCheck(
        "scan.step_zero",
        "form",
        "the step between the beams with the angles of the first and the last one",
        "Scans of {sensor} say a step of zero between their beams; it is taken from the angles of the first and the "
        "last one. Correct angle_increment in the driver.",
    ),
)

ODOMETRY_CHECKS = (
    ReadingCheck(
        "odometry.malformed",
        "form",
        "position, heading, speeds and stamp of the odometry: finite numbers",
        "A reading of the odometry is malformed ({what}); it is left out. Check the driver of the base.",
    ),
    ReadingCheck(
        "odometry.late",
        "time",
        "the stamp of the odometry with the time at which it came: 0.3 s at most",
        "The odometry is {age} s late, so no command is driven by it. Look for a slow link, a queue on the way or a "
        "clock that was set.",
    ),
    ReadingCheck(
        "odometry.future",
        "time",
        "the stamp of the odometry with the time at which it came: 0.1 s ahead at most",
        "The odometry is stamped {lead} s in the future, so no command is driven by it. Check the clock that the "
        "driver of the base stamps it by.",
    ),
)

RECORDED_ODOMETRY_CHECKS = (
    ReadingCheck(
        "odometry.no_heading",
        "form",
        "the orientation of the odometry: a quaternion of length 1",
        "The odometry of {sensor} has no heading (its quaternion is zero); {instead}. Let the base publish its "
        "orientation.",
    ),
    ReadingCheck(
        "odometry.stands",
        "agreement",
        "the way of the odometry's place with the way of its own speeds",
        "The place of {sensor} never moves although its speeds do; the speeds are used. Let the base publish where "
        "it is.",
    ),
    ReadingCheck(
        "odometry.too_fast",
        "limits",
        "speed by the odometry's places with that of any robot that maps rooms: 6 m/s",
        "The odometry of {sensor} moves at {speed} m/s, which no robot does: is it in centimetres or millimetres? It "
        "is not used; scans alone are.",
    ),
    ReadingCheck(
        "odometry.restarted",
        "limits",
        "each step of the odometry with what the base can do in that time",
        "The odometry of {sensor} jumps {count} times (first {at} s after its start), as when a base is restarted; "
        "it goes on from where it was.",
    ),
    ReadingCheck(
        "odometry.several",
        "form",
        "how many topics carry odometry",
        "Of several odometries {sensor} is used; {others} is not. Set log.odometry_topic to change that.",
    ),
    ReadingCheck(
        "odometry.unknown",
        "form",
        "frames that move with the usual names of odometry and robot",
        "Frames move in this log ({others}), but none is the odometry of the robot by its name; scans alone are "
        "used. Set log.odometry_frame and log.base_frame.",
    ),
)

CLOCK_CHECKS = (
    ReadingCheck(
        "clock.set",
        "time",
        "steps of a device's stamps with the time that passed meanwhile for the recorder",
        "The clock of {sensor} was set by {jump} s while it recorded; its readings go on as they were recorded. Let "
        "clocks be set (NTP) before a recording begins.",
    ),
    ReadingCheck(
        "clock.recorder_set",
        "time",
        "steps of the recorder's time in the order of the file: 1 s back, 10 minutes ahead at most",
        "The recorder's clock was set by {jump} s in the middle; what follows is taken to come at once after what "
        "was before. Let clocks be set (NTP) before a recording begins.",
    ),
    ReadingCheck(
        "clock.differs",
        "time",
        "stamps of two devices with the times at which they were recorded: 1 s at most",
        "The stamps of {sensor} are {difference} those of {other}: two clocks. They are put on one by the times at "
        "which both were recorded, which is less exact. Synchronize the clocks (chrony, NTP).",
    ),
    ReadingCheck(
        "clock.apart",
        "time",
        "the time of the scans with the time of the odometry",
        "The scans and the odometry are of different times by their stamps ({scans} s and {odometry} s), and nothing "
        "in the file says how their clocks differ; the odometry is not used. Synchronize the clocks.",
    ),
    ReadingCheck(
        "clock.none",
        "time",
        "stamps of readings with each other",
        "The readings of {sensor} carry no times: they are taken in the order of the file, {rate} a second. "
        "Durations and speeds mean nothing.",
    ),
    ReadingCheck(
        "clock.rounded",
        "time",
        "stamps of readings with each other: one in ten may repeat",
        "{share} % of the stamps of {sensor} repeat the one before (rounded, or without a value): the readings are "
        "spread evenly, in the order of the file.",
    ),
    ReadingCheck(
        "clock.few_left",
        "time",
        "how many scans have a time of their own",
        "Only {kept} of {all} scans have a usable time, so the log cannot be used. Check what stamps the scans.",
    ),
)

ROBOT_CHECKS = (
    ReadingCheck(
        "robots.several",
        "form",
        "the names before the topics and frames of odometry",
        "There are several robots here ({robots}); only what belongs to {sensor} is used. Set log.scan_topic to "
        "choose another one.",
    ),
    ReadingCheck(
        "robots.mixed",
        "agreement",
        "a scan, or the odometry, with those before it: it must not come back to an older place again and again, "
        "nor change its frame to and fro",
        "Two robots, or two programs, send readings of {sensor} in turns under one name; none is used, and the robot "
        "does not drive. Give each robot a namespace or a ROS domain of its own, or end one program.",
    ),
    ReadingCheck(
        "robots.other_odometry",
        "form",
        "the robot of the odometry with the robot of the laser",
        "Only another robot than that of {sensor} has odometry here ({robots}), so none is used; scans alone are. "
        "Set log.odometry_topic if they are one robot.",
    ),
    ReadingCheck(
        "speeds.type_guessed",
        "agreement",
        "the odometry of a ROS robot with the speeds that it was sent for 1.5 s, as a type that was guessed",
        "The robot was asked to move, and its wheels have not. Speeds are sent as {sent}; this base may take "
        "{other}: {sensor} does not say it. Choose {other}.",
    ),
    ReadingCheck(
        "battery.malformed",
        "form",
        "the charge of the battery: a share from 0 to 1",
        "The charge of the battery is malformed ({what}); it is left out. Check the driver of the base.",
    ),
)

MOUNTING_CHECKS = (
    ReadingCheck(
        "mount.unknown",
        "form",
        "the frame of the scans with the transforms of the log",
        "The log does not say how {sensor} is mounted on the robot; it is taken to stand at the robot's origin and "
        "to look ahead. Set log.mounting_x, mounting_y and mounting_heading to change that.",
    ),
    ReadingCheck(
        "mount.not_level",
        "limits",
        "the plane of the laser with the floor's: 20° at most",
        "The plane of {sensor} is tilted by {tilt}° (it looks at the floor or is mounted on its side), so it does "
        "not show what is around the robot. Mount it level, or correct the transform of its frame; "
        "log.mounting_heading takes it for level all the same.",
    ),
)

AGREEMENT_CHECKS = (
    ReadingCheck(
        "agreement.mirrored",
        "agreement",
        "the sense of the turns by wheels and by scans",
        "Wheels and scans of {sensor} turn against each other: the scans are mirrored (the laser hangs upside down "
        "or counts clockwise), or the base counts its heading clockwise. Correct the mounting or the angles of the "
        "laser, or the sign of the base's heading.",
    ),
    ReadingCheck(
        "agreement.turn_scale",
        "agreement",
        "the size of the turns by wheels and by scans: a quarter of difference at most",
        "By the wheels the robot turns {times} times as far as the scans of {sensor} show. Correct the distance "
        "between the wheels in the driver of the base.",
    ),
    ReadingCheck(
        "agreement.way_scale",
        "agreement",
        "the length of the ways by wheels and by scans: 8 % of difference at most",
        "By the wheels the robot goes {times} times as far as the scans of {sensor} show (100: centimetres, 1000: "
        "millimetres, 39.4: inches). Correct the unit, or the radius of the wheels, in the driver of the base.",
    ),
    ReadingCheck(
        "agreement.mount",
        "agreement",
        "the direction of the ways by wheels and by scans: 8° of difference at most",
        "By the scans of {sensor} the robot drives {off}° to the left of where its wheels lead (180°: backwards): "
        "the laser is mounted otherwise than was said, or the base counts its way backwards. Correct its mounting: "
        "heading {heading} rad.",
    ),
    ReadingCheck(
        "agreement.late",
        "agreement",
        "the times of the turns by wheels and by scans: 0.15 s of difference at most",
        "Scans of {sensor} are stamped {late} s later than the odometry of the same turns. Stamp a scan when it is "
        "measured, or set the time offset of the laser to -{late} s.",
    ),
    ReadingCheck(
        "agreement.early",
        "agreement",
        "the times of the turns by wheels and by scans: 0.15 s of difference at most",
        "The odometry is stamped {late} s later than the scans of {sensor} of the same turns. Stamp the odometry "
        "when it is measured, or set the time offset of the laser to {late} s.",
    ),
    ReadingCheck(
        "agreement.wheels_stand",
        "agreement",
        "wheels that stand for 1.5 s with scans that move",
        "The wheels stand although the scans of {sensor} move ({at} s after the start, for {lasted} s): the odometry "
        "hung, or the robot was carried. The scans are followed. Check the driver of the base.",
    ),
    ReadingCheck(
        "agreement.wheels_spin",
        "agreement",
        "wheels that roll for 1.5 s with scans that stand",
        "The wheels roll although the scans of {sensor} stand ({at} s after the start, for {lasted} s): they spin, "
        "or the robot was lifted. The scans are followed. Check whether the robot is held by something.",
    ),
)

PICTURE_CHECKS = (
    ReadingCheck(
        "picture.malformed",
        "form",
        "shape, kind of numbers and stamp of a picture: height x width x 3 bytes, a finite stamp",
        "A picture of {sensor} is malformed ({what}); it is left out. Check the driver of the camera.",
    ),
    ReadingCheck(
        "picture.late",
        "time",
        "the stamp of a picture with the time at which it came: 0.3 s at most",
        "Pictures of {sensor} are {age} s late, so nobody is followed by them. Look for a slow link, a queue on the "
        "way or a clock that was set.",
    ),
    ReadingCheck(
        "picture.future",
        "time",
        "the stamp of a picture with the time at which it came: 0.1 s ahead at most",
        "Pictures of {sensor} are stamped {lead} s in the future, so nobody is followed by them. Check the clock "
        "that the driver of the camera stamps them by.",
    ),
    ReadingCheck(
        "camera.two_settings",
        "agreement",
        "one camera for all pictures with two cameras, each for a part of them",
        "The pictures are of two camera settings: {others} fit one ({camera}), {odd} another "
        "({odd_camera}); likely {cause}. Calibrate each setting by itself.",
    ),
    ReadingCheck(
        "camera.odd_part",
        "agreement",
        "one camera for all pictures with another one for a few of them",
        "{odd} fit another camera setting ({odd_camera}) than {others} ({camera}) and are left out; likely {cause}.",
    ),
    ReadingCheck(
        "camera.focal_undecided",
        "agreement",
        "focal lengths that fit the pictures about as well as the best",
        "The pictures do not decide the focal length: anything between {low} and {high} px fits them about "
        "as well. Tilt the board by 20 to 50 degrees, to several sides.",
    ),
    ReadingCheck(
        "board.unequal_squares",
        "agreement",
        "height of the squares with their width, from all pictures",
        "The board's squares are not square: {wide} mm wide and {high} mm high ({share} %), if the width "
        "is as entered. The camera was solved with that; measure both sides with a ruler and print the "
        "board at one scale.",
    ),
    ReadingCheck(
        "board.bent",
        "agreement",
        "heights of the board's corners with a plane, from all pictures: 0.15 % of its diagonal at most",
        "The board is bent, by {depth} mm from its lowest to its highest corner. The camera was solved with that; "
        "fix the board to something flat, and take the pictures again.",
    ),
    ReadingCheck(
        "board.other_count",
        "form",
        "inner corners of the board in a picture with those entered",
        "I see a board with {seen} inner corners, not {entered}: you may have counted {what}. This looks "
        "like {seen}, use it. Count the points where four squares meet.",
    ),
    ReadingCheck(
        "board.use_other",
        "form",
        "inner corners of the board in most pictures with those entered",
        "This looks like a {seen} board, not {entered}, in {count} of {all} pictures: use {seen}. You may have "
        "counted {what}; count the points where four squares meet.",
    ),
    ReadingCheck(
        "board.inverted",
        "form",
        "a board in the picture with one in its negative",
        "I see the board only in the negative of the picture: its squares are light on dark. Print dark "
        "squares on white, with a white rim around them.",
    ),
    ReadingCheck(
        "board.separate_squares",
        "form",
        "squares that stand apart with squares that touch at their corners",
        "This is not a chessboard: the squares stand apart, and those of a chessboard touch at their "
        "corners. Print a chessboard (beckon calibrate board).",
    ),
)

SOUND_CHECKS = (
    ReadingCheck(
        "sound.malformed",
        "form",
        "shape, kind of numbers and stamp of a piece of sound: samples x channels, a finite stamp",
        "A piece of sound is malformed ({what}); it is left out. Check the driver of the microphones.",
    ),
    ReadingCheck(
        "sound.late",
        "time",
        "the end of a piece of sound with the time at which it came: 0.3 s at most",
        "The sound is {age} s late, so the robot does not turn to it. Look for a slow link, a queue on the way or a "
        "clock that was set.",
    ),
    ReadingCheck(
        "sound.future",
        "time",
        "the end of a piece of sound with the time at which it came: 0.1 s ahead at most",
        "The sound is stamped {lead} s in the future, so the robot does not turn to it. Check the clock that the "
        "driver of the microphones stamps it by.",
    ),
    ReadingCheck(
        "sound.no_rate",
        "form",
        "the bytes per second of sound that says no rate with those of usual microphones",
        "{sensor} says neither its sample rate nor its channels; {rate} Hz and {channels} of 16 bits are taken "
        "({why}). Record its AudioInfo, too, or set log.sound_rate and log.sound_channels.",
    ),
    ReadingCheck(
        "array.dead",
        "form",
        "level of a channel with that of no sound at all",
        "Channel {channels} is dead: it holds no sound. Is the microphone connected, the channel right?",
    ),
    ReadingCheck(
        "array.faint",
        "form",
        "level of a channel with the others'",
        "Channel {channels} is {times} times fainter than the others; is its microphone covered?",
    ),
    ReadingCheck(
        "array.clipped",
        "limits",
        "samples at a channel's limit, in runs",
        "Channel {channels} is clipped: {share} % at its limit. Lower the gain.",
    ),
    ReadingCheck(
        "array.identical",
        "agreement",
        "channels with each other at the same moment",
        "Channels {channels} are identical: one microphone is recorded more than once.",
    ),
    ReadingCheck(
        "array.line",
        "form",
        "places of the microphones: not all in a line",
        "All microphones lie in a line; a direction needs at least three that do not.",
    ),
    ReadingCheck(
        "array.inverted",
        "agreement",
        "the sign of a channel with the others'",
        "Channel {channels} has its wires crossed: it swings against all others.",
    ),
    ReadingCheck(
        "array.foreign",
        "agreement",
        "what a channel shares with the others within the time that sound takes between them",
        "Channel {channels} shares no sound with the others in time: a noisy, processed or playback channel, or "
        "another device's clock. Directions are not sure; name the microphones' own channels in the array "
        "profile.",
    ),
    ReadingCheck(
        "array.processed",
        "agreement",
        "the times and the noise of a channel with those of a sum of all microphones",
        "Channel {channels} seems to be processed, a sum of the microphones{also}: directions are not sure. Name "
        "the microphones' own channels in the array profile (a ReSpeaker's six-channel sound has them in channels"
        " 2 to 5).",
    ),
    ReadingCheck(
        "array.sharing",
        "agreement",
        "the noise that two channels share with what others do, where sound is shorter than their distance",
        "Channels {channels} share noise that the others do not: one holds sound of the other (cross-talk, or a "
        "processed channel), or their microphones sit closer than the profile says, so directions are not sure. "
        "Check cables, channels and positions_m of the array profile.",
    ),
    ReadingCheck(
        "array.swapped",
        "agreement",
        "the times of all microphones with a plane wave, in the profile's order and with two exchanged",
        "Channels {channels} seem to be exchanged{also}: no direction fits this order, so directions are not "
        "sure. Find the order with two utterances from known directions.",
    ),
    ReadingCheck(
        "array.late",
        "agreement",
        "the times of all microphones with a plane wave, and with one or two that are late",
        "Sound comes {late} ms late on channel {channels}, as it seems{also}: directions are not sure. Record all "
        "channels with one clock and one driver.",
    ),
    ReadingCheck(
        "array.scale",
        "limits",
        "the times of all microphones with the array's size",
        "Every voice seems to come from nearly straight above; are positions_m of the array profile in metres? "
        "Voices at the robot's side would fit an array {times} times smaller.",
    ),
    ReadingCheck(
        "array.misfit",
        "agreement",
        "the times of all microphones with a plane wave",
        "The microphones contradict each other: no direction explains their times, so directions are not sure. "
        "Likely some channels are late or in another order, or the profile is another board's.",
    ),
    ReadingCheck(
        "sound.units",
        "form",
        "the loudest sample of a file with full scale: 8 times at most",
        "The samples reach {peak} times full scale; they are taken for whole numbers of which {full} is full scale. "
        "Write fractions within ±1.",
    ),
)

FILE_CHECKS = (
    ReadingCheck(
        "picture.unreadable",
        "form",
        "a file with the pictures that are read: its kind, its size, its end",
        "{sensor} cannot be read as a picture: {what}. JPEG, PNG, BMP, WebP and PGM are read; save or copy it again.",
    ),
    ReadingCheck(
        "camera.malformed",
        "form",
        "a camera file with its form: size, matrix, distortion, finite numbers",
        "{sensor} cannot be used as a camera file: {what}. Export it again, or calibrate the camera with Beckon.",
    ),
    ReadingCheck(
        "camera.other_model",
        "form",
        "the model that a camera file names with plumb_bob",
        "The file is for the camera model '{model}', whose numbers mean something else; Beckon reads "
        "plumb_bob (k1 k2 p1 p2 k3). Calibrate the camera with Beckon, or export it as plumb_bob.",
    ),
    ReadingCheck(
        "camera.unnamed_model",
        "form",
        "four distortion numbers with the models that have four: plumb_bob and fisheye",
        "The file holds four distortion numbers and does not name their model: plumb_bob (k1 k2 p1 p2) and "
        "fisheye (k1 k2 k3 k4) both have four. Write distortion_model: plumb_bob if that is what they are.",
    ),
    ReadingCheck(
        "camera.rational",
        "form",
        "distortion numbers from the sixth on with zero",
        "The file holds distortion beyond k1 k2 p1 p2 k3 (the rational model's k4 k5 k6 or more), which "
        "Beckon does not read. Calibrate the camera with Beckon, or export it as plumb_bob.",
    ),
    ReadingCheck(
        "camera.binned",
        "limits",
        "principal point with the picture's middle",
        "The camera matrix is for pictures about {times} times smaller than {width}x{height}, the size in "
        "the file: binned or scaled. Write the size of the pictures that the matrix is for.",
    ),
    ReadingCheck(
        "laser.degrees",
        "form",
        "span of a scan's angles with a full turn",
        "{sensor}: the angles run from {first} to {last}, more than a full turn in radians: they are degrees, "
        "or counted twice. Convert them, or name the column angle_deg.",
    ),
    ReadingCheck(
        "laser.other_form",
        "agreement",
        "camera's boards with the scans, as they are and in other units and senses",
        "The scans do not show the boards that the camera sees: {seen} of {count} poses fit, but {fits} if "
        "{what}. Check unit and angles of the scans: metres, radians, counter-clockwise, 0 ahead.",
    ),
    ReadingCheck(
        "laser.other_pairing",
        "agreement",
        "camera's boards with the scans of the same and of other pictures",
        "The scans seem to belong to other pictures: {seen} of {count} poses fit, but {fits} if every "
        "picture goes with the scan {what}. Give picture and scan of a pose the same number.",
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
