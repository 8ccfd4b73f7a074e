"""The conformance suite: what every driver has to hold, tried on the robot itself (`beckon robot check`).

The robot runs behind the driver's own loop, as it does for the console, so that the same watchdog stops it.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import stat
import threading
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from core.errors import BadInput, Unavailable
from core.gate.twist import ZERO, Twist
from core.geometry import Pose, wrap
from core.message import message
from core.perception.sound.array_diagnostics import check
from core.robots import Profile
from core.robots.connect import connect
from core.robots.connection import ReadConnection
from core.robots.driver_session import DriverSession
from core.robots.frame_sender import resting_rate
from core.robots.process import TWIST_TIMEOUT_S
from core.robots.repeated_readings import RepeatedReadings
from core.robots.requests import SetListening, SpeedsType, SwitchSpeeds
from core.sensors import SensorFrame, Wheels
from core.sensors.checks import MAX_AGE_S, Fault, distinct
from core.sensors.microphones import MicrophoneArray, Sound, joined
from core.slam.motion import MotionSettings
from core.slam.odometry import Odometry
from core.slam.scan_matching.agreement import MoveAgreement
from core.slam.scan_matching.scan_odometry import ScanOdometrySettings

TEST_SPEED_M_S, TEST_DRIVE_S = 0.02, 1.0  # what the robot is asked to do
MOVING_SHARE = 0.3  # of the way that was asked for, from which it moves
STANDING_SPEED_M_S = 0.25 * TEST_SPEED_M_S  # below which it stands
SENSOR_START_S = 10.0  # in which every sensor has to deliver for the first time
MIN_MEASURING_S = 3.0  # at least
MIN_READINGS = 12  # of the slowest sensor that are waited for
MAX_MEASURING_S = 12.0  # of measuring
UNKNOWN_RATE_HZ = 4.0  # of a sensor whose rate is not known: how long it is measured
MIN_RATE_RATIO, MAX_RATE_RATIO = 0.8, 1.25  # times the rate of the profile that a sensor may have
FRAME_SHARE = 0.8  # of the frames that must come
MAX_STAMP_LEAD_S = 0.010  # by which a stamp may lead
PUNCTUAL_SHARE = 0.9  # of the readings that must be there within `MAX_AGE_S` of their stamps
MAX_STOPPING_S = 0.5  # from a request to a base that stands
LOST_WITHIN, BACK_WITHIN = 15.0, 30.0  # [s] after the link was cut, and after it was restored
AGREEMENT = "wheels over scans"
TURN_RAD, TURN_RAD_S = 0.7, 0.4  # of a drive on which wheels and scans are compared
AHEAD_M, AHEAD_M_S, NEAR_M = 0.4, 0.1, 0.7  # of the way ahead on that drive, where nothing is as near as that
MAX_SLOWNESS = 4.0  # times the time that a leg takes, for which it is waited
AFTER_S = 2.6  # of odometry after a turn, by which its lateness is known
SCANNED_DRIVE_S = 3.0  # of a drive that is measured by scans, which see no move below 8 mm
CLOSING_TIME_S = 2.0  # that threads and sockets may take to end


@message
class ConformanceCheck:
    """One line of the table."""

    name: str
    passed: bool
    figure: float | None = None
    unit: str = ""
    advice: str = ""  # what failed and what to do


class SkippedCheck(NamedTuple):
    """A check that could not be made."""

    name: str
    reason: str


@message
class ConformanceReport:
    """The result of an examination."""

    checks: tuple[ConformanceCheck, ...]
    not_checked: tuple[SkippedCheck, ...] = ()
    remarks: tuple[str, ...] = ()  # sentences of the devices: ambiguities, and what is missing
    faults: tuple[Fault, ...] = ()  # what the checks of the readings found
    agreement: MoveAgreement | None = None  # of wheels and scans; None: it has not both

    @property
    def passed(self) -> bool:
        """Return whether all that was checked is as it has to be."""
        return all(check.passed for check in self.checks)


class Interruption(NamedTuple):
    """How the link to the robot is cut, and restored."""

    cut: Callable[[], object]
    restore: Callable[[], object]


class SensorSeries(NamedTuple):
    """Readings of one sensor while it was watched."""

    name: str
    rate: float | None  # [Hz] of the profile; None: the robot does not say it
    entry: str  # of robot.toml that describes it
    stamps: list[float]  # [s] of its readings
    ages: list[float]  # [s] of its readings in the frames that carried them

    @property
    def measured(self) -> float:
        """[Hz] by its stamps; 0 of fewer than two readings."""
        lasted = max(self.stamps, default=0.0) - min(self.stamps, default=0.0)
        return (len(self.stamps) - 1) / lasted if lasted > 0 else 0.0


def check_robot(
    url: str,
    *,
    drive: bool = False,
    compare: bool = False,
    interruption: Interruption | None = None,
    say: Callable[[str], object] = lambda _: None,
) -> ConformanceReport:
    """Try everything on the robot. With `drive` it moves at 2 cm/s, twice for about a second.

    With `compare` it turns and goes a little way after that, for its wheels and its scans to be compared. `say` is
    given what goes on. Raises BadInput where the URL names no robot that can be checked.
    """
    before, began = Holdings.now(), time.monotonic()
    try:
        robot = connect(url)
    except Unavailable as trouble:
        return ConformanceReport(checks=(ConformanceCheck(name="connect", passed=False, advice=str(trouble)),))
    if robot.profile.kind == "LOG":
        robot.close()
        raise BadInput("A recording is not checked, it has no driver; give the URL of a robot or its robot.toml.")
    if SetListening in robot.requests:
        robot.ask(SetListening(on=True))
    suite = Suite(DriverSession(robot), say)
    suite.add("connect", True, time.monotonic() - began, "s")
    try:
        suite.check_streams()
        suite.check_driving(allowed=drive)
        suite.check_agreement(drive=drive and compare)
        suite.check_reconnecting(interruption, drive=drive)
        asks = ReadConnection in robot.requests
        found = [part.findings for part in robot.ask(ReadConnection()).parts] if asks else []
    finally:
        suite.session.close()
    suite.check_holdings(before, lambda: connect(url).close())
    return ConformanceReport(
        checks=tuple(suite.checks),
        not_checked=tuple(suite.not_checked),
        remarks=tuple(dict.fromkeys((*robot.profile.notices, *(remark for one in found for remark in one.remarks)))),
        faults=distinct([*(fault for one in found for fault in one.faults), *suite.contradictions]),
        agreement=suite.agreement,
    )


class Suite:
    """The checks of one robot, in their order."""

    def __init__(self, session: DriverSession, say: Callable[[str], object]) -> None:
        self.session, self._say = session, say
        self.checks: list[ConformanceCheck] = []
        self.not_checked: list[SkippedCheck] = []
        self._moved = False  # odometry has shown that it moves when asked to
        self._both, self._near = False, 0.0  # wheels and scans came; the least range [m] of the newest scan
        self._heading = self._turned = 0.0  # [rad] by the wheels, now and in all
        self._place: Pose | None = None  # by the scans; None: there are wheels, or no scans
        self._odometry = Odometry(session.profile.laser, MotionSettings(), ScanOdometrySettings())
        self._repeated = RepeatedReadings(session.profile)
        self._wheels: Wheels | None = None  # the newest
        self.contradictions: tuple[Fault, ...] = ()  # of wheels and scans
        self.agreement: MoveAgreement | None = None
        session.watch = self._watch

    def add(self, name: str, passed: bool, figure: float | None = None, unit: str = "", advice: str = "") -> None:
        """Write down one result; `advice` is for the case that it failed."""
        shown = "" if passed else advice
        self.checks.append(ConformanceCheck(name=name, passed=passed, figure=figure, unit=unit, advice=shown))

    def skip(self, reason: str, *names: str) -> None:
        """Write down that something is not checked."""
        self.not_checked += [SkippedCheck(name, reason) for name in names]

    # what comes

    def check_streams(self) -> None:
        """Rate of frames; rate, stamps and age of every sensor."""
        profile = self.session.profile
        missing = set(sensor_names(profile))

        def all_there(frame: SensorFrame) -> bool:
            missing.difference_update(one.name for one in series_of([frame], profile) if one.stamps)
            return not missing

        self._say(f"waiting for {', '.join(missing) or 'the first frame'}")
        self.session.frames(SENSOR_START_S, until=all_there)
        slowest = min((one.rate or UNKNOWN_RATE_HZ for one in series_of([], profile)), default=profile.rate)
        seconds = min(max(MIN_MEASURING_S, MIN_READINGS / slowest), MAX_MEASURING_S)
        self._say(f"measuring for {seconds:.0f} s")
        read, rate = self._measure(seconds)
        expected = resting_rate(profile.rate)
        if rate < FRAME_SHARE * expected or not all(map(self._keeps_rate, series_of(read, profile))):
            self._say("too few frames or readings came; measuring once more")  # the computer may have been busy
            read, rate = self._measure(seconds)
        self.add(
            "frames",
            rate >= FRAME_SHARE * expected,
            rate,
            "Hz",
            f"{expected:g} Hz are expected; this computer is too busy, or the driver keeps `drive` waiting.",
        )
        for series in series_of(read, profile):
            self._check_series(series)
        for array in profile.arrays[:1]:
            self._check_sound(array, read, seconds)
        if profile.drives and all(frame.wheels is None for frame in read):
            self.skip("The base sends no odometry.", "odometry")

    def _measure(self, seconds: float) -> tuple[list[SensorFrame], float]:
        """Frames of that time [s], and how many came in a second [Hz]."""
        began = time.monotonic()
        read = self.session.frames(seconds)
        return read, len(read) / (time.monotonic() - began)

    def _rate_of(self, one: SensorSeries) -> float:
        return min(one.rate or one.measured, self.session.profile.rate)

    def _keeps_rate(self, one: SensorSeries) -> bool:
        expected = self._rate_of(one)
        return MIN_RATE_RATIO * expected <= one.measured <= MAX_RATE_RATIO * expected and one.measured > 0

    def _check_series(self, one: SensorSeries) -> None:
        expected = self._rate_of(one)
        nothing = f"Nothing came within {SENSOR_START_S:g} s; is it switched on and connected?"
        other = (
            f"The profile says {expected:g} Hz; write rate = {one.measured:.3g} under [{one.entry}] of robot.toml."
        )
        self.add(f"{one.name} rate", self._keeps_rate(one), one.measured, "Hz", other if one.stamps else nothing)
        if len(one.stamps) < 2:
            self.skip("Too few readings came.", f"{one.name} stamps", f"{one.name} age")
            return
        disordered = int(np.count_nonzero(np.diff(one.stamps) <= 0))
        self.add(
            f"{one.name} stamps",
            disordered == 0,
            disordered,
            "out of order",
            "Every reading needs a later stamp than the one before; hand on each only once.",
        )
        self._check_ages(one)

    def _check_ages(self, one: SensorSeries) -> None:
        first, typical = min(one.ages), float(np.quantile(one.ages, PUNCTUAL_SHARE))
        passed = first >= -MAX_STAMP_LEAD_S and typical <= MAX_AGE_S
        ahead = (
            f"Stamps lie {-1000 * first:.0f} ms in the future; stamp every reading with readings.now() as it comes."
        )
        late = (
            f"Readings are {1000 * typical:.0f} ms old when they come, and nothing is driven by one older than "
            f"{1000 * MAX_AGE_S:.0f} ms; look for a slow link, a queue on the way or a clock that was set."
        )
        figure = typical if first >= -MAX_STAMP_LEAD_S else first
        self.add(f"{one.name} age", passed, 1000 * figure, "ms", late if first >= -MAX_STAMP_LEAD_S else ahead)

    def _check_sound(self, array: MicrophoneArray, read: Sequence[SensorFrame], seconds: float) -> None:
        share = sum(frame.sound.duration for frame in read if frame.sound is not None) / seconds
        advice = "of the sound comes; samples are lost on the way, or the rate of the array is another one."
        self.add(
            f"{array.name} sound",
            MIN_RATE_RATIO <= share <= MAX_RATE_RATIO,
            100 * share,
            "%",
            f"{100 * share:.0f} % {advice}",
        )
        heard: Sound | None = None
        for frame in read:
            heard = joined(heard, frame.sound, seconds)
        if heard is None or array.dimensions < 2 or not np.any(heard.samples):
            self.skip("Nothing was heard; speak while it is measured.", f"{array.name} channels")
            return
        try:
            faults = [one.sentence for one in check(heard, array) if one.serious]
        except BadInput as unfit:
            faults = [str(unfit)]
        self.add(f"{array.name} channels", not faults, advice=" ".join(faults))

    # what moves

    def check_driving(self, *, allowed: bool) -> None:
        """Speeds reach the base, a stop does, and silence is one."""
        names = ("drive", "stop", "silence")
        if not self.session.profile.drives:
            self.skip("The robot has no base.", *names)
        elif not allowed:
            self.skip("It moves the robot: ask for it with --drive.", *names)
        elif not any(frame.wheels for frame in self.session.frames(1.0, ZERO, until=has_odometry)):
            self._check_by_scans(names)
        else:
            self._check_drive()
            if self._moved:
                self._check_stop()
                self._check_silence()
            else:
                self.session.frames(MAX_STOPPING_S, ZERO)
                self.skip("The robot does not move.", "stop", "silence")

    def _check_by_scans(self, names: tuple[str, str, str]) -> None:
        """The same of a base without odometry, as far as scan matching sees it move."""
        if self._place is None:
            self.skip("The base sends no odometry, and no laser sees it move: watch the wheels.", *names)
            return
        ahead, slack, asked = Twist(TEST_SPEED_M_S, 0.0), MAX_STOPPING_S, TEST_SPEED_M_S * SCANNED_DRIVE_S
        driven = self._way_by_scans(SCANNED_DRIVE_S, ahead)
        driven += self._way_by_scans(slack, ZERO)
        self._moved = driven > MOVING_SHARE * asked
        advice = f"{100 * asked:g} cm were asked for (as scans see it): are the motors on, is the unit right?"
        self.add("drive", self._moved and driven < 2 * asked, 100 * driven, "cm", advice)
        if not self._moved:
            self.skip("The robot does not move.", *names[1:])
            return
        for name, twist, wait in (("stop", ZERO, slack), ("silence", None, TWIST_TIMEOUT_S + slack)):
            self.session.frames(TEST_DRIVE_S, ahead)
            self.session.frames(wait, twist)
            went_on = abs(self._way_by_scans(SCANNED_DRIVE_S / 2, twist))
            advice = f"By the scans the base goes on {1000 * wait:.0f} ms after the last request."
            self.add(name, went_on < asked / 4, 100 * went_on, "cm", advice)
        self.session.frames(MAX_STOPPING_S, ZERO)

    def _way_by_scans(self, seconds: float, twist: Twist | None) -> float:
        """Let that time pass → how far [m] ahead the scans saw it come."""
        before = self._place or Pose()
        self.session.frames(seconds, twist)
        return (before.inverse() @ (self._place or Pose())).x

    def _check_drive(self) -> None:
        asked, moved, guessed = TEST_SPEED_M_S * TEST_DRIVE_S, self._driven(), self._guessed_type()
        self._moved = moved > MOVING_SHARE * asked
        if guessed and abs(moved) <= MOVING_SHARE * asked:
            moved = self._try_other_type(guessed)
        elif guessed:
            self.add(f"speeds as {guessed}", True)
        passed = self._moved and moved < 2 * asked
        if moved < -MOVING_SHARE * asked:
            advice = "The odometry runs backwards; swap the sign of the motors or of the encoders."
        elif passed or self._moved:
            advice = f"Only {100 * asked:g} cm were asked for; check the unit of the speeds and of the odometry."
        else:
            advice = "The odometry did not answer; are the motors switched on, and do they turn at 2 cm/s at all?"
        self.add("drive", passed, 100 * moved, "cm", advice)

    def _driven(self) -> float:
        """Drive for a while → how far [m] by the odometry."""
        self._say(f"driving at {100 * TEST_SPEED_M_S:g} cm/s")
        read = [
            frame.wheels for frame in self.session.frames(TEST_DRIVE_S, Twist(TEST_SPEED_M_S, 0.0)) if frame.wheels
        ]
        return (read[0].odometry.inverse() @ read[-1].odometry).x if read else 0.0

    def _guessed_type(self) -> SpeedsType | None:
        """Return the type of the speeds where it is guessed; None: the robot says it, or it has none."""
        robot = self.session.robot
        if SwitchSpeeds not in robot.requests:
            return None
        parts = robot.ask(ReadConnection()).parts
        used = [one for part in parts for role in part.findings.roles for one in role.used if one.guessed]
        return next(("TwistStamped" if one.type.endswith("Stamped") else "Twist" for one in used), None)

    def _try_other_type(self, guessed: SpeedsType) -> float:
        """Drive once more, with speeds of the type that was not guessed → how far [m] by the odometry."""
        other: SpeedsType = "Twist" if guessed == "TwistStamped" else "TwistStamped"
        self.session.frames(MAX_STOPPING_S, ZERO)
        self.session.robot.ask(SwitchSpeeds(type=other))
        self._say(f"it did not move; speeds are sent as {other} instead of {guessed}")
        self.session.frames(MAX_STOPPING_S, ZERO)
        moved = self._driven()
        self._moved = moved > MOVING_SHARE * TEST_SPEED_M_S * TEST_DRIVE_S
        advice = f'It moves by {other}: write cmd_vel_type = "{other}" under [robot] of robot.toml.'
        neither = f"It moves neither by {guessed} nor by {other}; does anything on the robot listen to its topic?"
        self.add(f"speeds as {guessed}", False, advice=advice if self._moved else neither)
        return moved

    def _check_stop(self) -> None:
        self.session.ask(ZERO)
        lasted = self._until_it_stands(ZERO)
        self._add_stop(
            "stop", lasted, MAX_STOPPING_S, "The base goes on after a stop; does `drive` pass zero on at once?"
        )

    def _check_silence(self) -> None:
        self._say("driving once more, then saying nothing")
        self.session.frames(TEST_DRIVE_S / 2, Twist(TEST_SPEED_M_S, 0.0))
        lasted = self._until_it_stands(None)
        self._add_stop(
            "silence", lasted, TWIST_TIMEOUT_S + MAX_STOPPING_S, "The base goes on although nothing was asked of it."
        )
        self.session.frames(MAX_STOPPING_S, ZERO)

    def _until_it_stands(self, twist: Twist | None) -> float | None:
        """How long [s] after the newest request the odometry stands; None: it does not."""
        asked = self.session.asked_at
        self.session.drain()
        read = self.session.frames(2.0, twist, until=stands)
        return read[-1].sensed - asked if read and stands(read[-1]) else None

    def _add_stop(self, name: str, lasted: float | None, limit: float, advice: str) -> None:
        figure = None if lasted is None else 1000 * lasted
        self.add(name, lasted is not None and lasted <= limit, figure, "ms", advice)

    # what agrees

    def check_agreement(self, *, drive: bool) -> None:
        """Wheels and scans claim the same moves: those that were seen until now, and those of a drive for it."""
        if not self._both:
            self.skip("It takes a laser and odometry.", AGREEMENT)
            return
        if drive and self._moved:
            self._drive_about()
        self._odometry.agreement.finish()
        if self._repeated.faults:
            self.contradictions = self._repeated.faults
            self.add(AGREEMENT, False, advice=" ".join(one.sentence for one in self.contradictions))
            return
        self.agreement, faults = self._odometry.agreement.compared, self._odometry.faults
        if self._turned > 2 * TURN_RAD and self.agreement.turns == 0:
            self.skip("The wheels roll, the scans stand: put the robot on the floor, and check again.", AGREEMENT)
            return
        self.contradictions = faults
        found = self.agreement
        scales = (("turns", found.turn_scale, found.turn_sd), ("ways", found.way_scale, found.way_sd))
        known = [(name, scale, sd) for name, scale, sd in scales if scale is not None]
        advice = " ".join(one.sentence for one in faults)
        for name, scale, sd in known:
            self.add(f"{AGREEMENT}, {name}", not faults, scale, f"times ± {sd:.2f}", advice)
        if faults and not known:
            self.add(AGREEMENT, False, advice=advice)
        elif not known:
            moved = "hardly moved" if self.agreement.turns or self.agreement.ways else "not moved"
            self.skip(f"The robot has {moved}; let it with --drive, where 70 cm around it are free.", AGREEMENT)

    def _watch(self, frame: SensorFrame) -> None:
        """Follow the robot by its wheels and its scans."""
        self._wheels = frame.wheels or self._wheels
        seen = self._repeated.taken_out(self.session.profile.first_view(frame), self._wheels)
        if frame.wheels is not None:
            self._turned += abs(wrap(frame.wheels.odometry.heading - self._heading))
            self._heading = frame.wheels.odometry.heading
        if frame.wheels is not None and seen.scan is not None:
            self._both = True
            echoes = seen.scan.ranges[seen.scan.valid]
            self._near = float(echoes.min()) if len(echoes) else math.inf
        motion = self._odometry.update(seen)
        if motion.by_scans and motion.scanned is not None:
            self._place = (self._place or Pose()) @ motion.increment.pose

    def _drive_about(self) -> None:
        """Turn to both sides, and go ahead and back where nothing is near."""
        base = self.session.profile
        turn, speed = min(TURN_RAD_S, base.max_turn_rate), min(AHEAD_M_S, base.max_speed)
        self._say(f"turning by {math.degrees(TURN_RAD):.0f}° to both sides, to compare wheels and scans")
        for one in (turn, -turn, -turn, turn):
            self._drive_leg(Twist(0.0, one), TURN_RAD / turn)
        if self._near > NEAR_M:
            self._say(f"going {100 * AHEAD_M:g} cm ahead and back")
            for one in (speed, -speed):
                self._drive_leg(Twist(one, 0.0), AHEAD_M / speed)
        self.session.frames(AFTER_S, ZERO)

    def _drive_leg(self, twist: Twist, seconds: float) -> None:
        """Drive at a speed for so long by the robot's clock, which a slow computer may hold up, and stop."""
        began: list[float] = []

        def is_over(frame: SensorFrame) -> bool:
            began.append(frame.stamp)
            return frame.stamp - began[0] >= seconds

        self.session.frames(MAX_SLOWNESS * seconds, twist, until=is_over)
        self.session.frames(MAX_STOPPING_S, ZERO)

    # what is lost

    def check_reconnecting(self, interruption: Interruption | None, *, drive: bool) -> None:
        """The link is cut and restored: everything comes again, and nothing moves."""
        if interruption is None:
            self.skip("Someone has to pull the cable: ask for it with --interactive.", "reconnect")
            return
        interruption.cut()
        read = self.session.frames(LOST_WITHIN, until=lambda frame: frame.trouble or frame.notes)
        lost = bool(read and (read[-1].trouble or read[-1].notes))
        advice = "`run` has to return or raise OSError when the link is lost; a link that is silent for a second is."
        self.add("loss noticed", lost, advice=advice)
        interruption.restore()
        twist = Twist(TEST_SPEED_M_S, 0.0) if drive else None
        began = time.monotonic()
        missing = set(sensor_names(self.session.profile))

        def is_back(frame: SensorFrame) -> bool:
            missing.difference_update(one.name for one in series_of([frame], self.session.profile) if one.stamps)
            return not missing and not frame.trouble

        read = self.session.frames(BACK_WITHIN, twist, until=is_back)
        back = bool(read) and not missing and not read[-1].trouble
        silent = ", ".join(sorted(missing)) or "the robot"
        advice = f"{silent} did not come back within {BACK_WITHIN:g} s; `open` has to work again after `close`."
        self.add("reconnect", back, time.monotonic() - began, "s", advice)
        self._check_standing(twist)

    def _check_standing(self, twist: Twist | None) -> None:
        """Check that a twist that was asked for before, and still is, moves nothing after the link is back."""
        if not self._moved:
            self.skip("It was not seen to move.", "standing after reconnect")
            return
        before, read = self._place, self.session.frames(1.0, twist)
        fastest = max((abs(frame.wheels.speed) for frame in read if frame.wheels), default=0.0)
        if before is not None and self._place is not None:
            fastest = 0.5 * before.distance_to(self._place.x, self._place.y)  # of scans that jump by up to 8 mm
        advice = "The robot goes on by itself when the link is back; it has to stand until zero was asked for."
        self.add("standing after reconnect", fastest < STANDING_SPEED_M_S, 100 * fastest, "cm/s", advice)
        self.session.frames(MAX_STOPPING_S, ZERO)

    # what is left

    def check_holdings(self, before: Holdings, again: Callable[[], object]) -> None:
        """No thread and no socket is left. `again` opens the robot and closes it."""
        left = left_behind(before, again)
        advice = f"Left behind: {', '.join(left)}; let go of them in `close`."
        self.add("close", not left, len(left), "left", advice)


def left_behind(before: Holdings, again: Callable[[], object]) -> list[str]:
    """List the things that are left over after a while, in words.

    What a library sets up once for the whole process, as zenoh does, does not grow when it is done `again`.
    """
    left = _left_after_a_while(before)
    if left and not Holdings.now().threads_beyond(before):
        before = Holdings.now()
        again()
        left = _left_after_a_while(before)
    return left


def _left_after_a_while(before: Holdings) -> list[str]:
    gc.collect()  # what nobody holds any more is not left behind
    deadline = time.monotonic() + CLOSING_TIME_S
    while (left := Holdings.now().beyond(before)) and time.monotonic() < deadline:
        time.sleep(0.02)
    return left


class Holdings(NamedTuple):
    """Threads and descriptors of this process."""

    threads: list[threading.Thread]
    links: int  # open sockets, pipes and devices

    @classmethod
    def now(cls) -> Holdings:
        """Look."""
        own = [one for one in threading.enumerate() if not one.name.startswith("Dummy-")]  # others are a library's
        return cls(own, open_links())

    def beyond(self, before: Holdings) -> list[str]:
        """Threads and descriptors that are left over, in words."""
        more = [f"{self.links - before.links} sockets or devices"] if self.links > before.links else []
        return self.threads_beyond(before) + more

    def threads_beyond(self, before: Holdings) -> list[str]:
        """Threads that are left over, in words."""
        threads = [f"thread {one.name}" for one in self.threads if one not in before.threads]
        return threads[: max(len(self.threads) - len(before.threads), 0)]


def open_links() -> int:
    """How many sockets, pipes and devices this process has open; 0 where that cannot be found out."""
    count = 0
    with contextlib.suppress(OSError):
        for descriptor in os.listdir("/dev/fd"):
            with contextlib.suppress(OSError):
                mode = os.fstat(int(descriptor)).st_mode
                count += not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)
    return count


def has_odometry(frame: SensorFrame) -> bool:
    """Return whether the wheels are known."""
    return frame.wheels is not None


def stands(frame: SensorFrame) -> bool:
    """Return whether the odometry says that the robot stands."""
    return frame.wheels is not None and abs(frame.wheels.speed) < STANDING_SPEED_M_S


def sensor_names(profile: Profile) -> list[str]:
    """The lasers and cameras of a robot."""
    return [one.name for one in series_of([], profile)]


def series_of(read: Sequence[SensorFrame], profile: Profile) -> list[SensorSeries]:
    """The readings of every laser and camera; one that names no sensor is the first one's."""
    scans = [(one.laser, one.stamp, frame.stamp - one.newest) for frame in read if (one := frame.scan) is not None]
    images = [(one.camera, one.stamp, frame.stamp - one.stamp) for frame in read if (one := frame.image) is not None]
    found: list[SensorSeries] = []
    for kind, sensors, readings in (("lasers", profile.lasers, scans), ("cameras", profile.cameras, images)):
        for number, sensor in enumerate(sensors):
            mine = [(stamp, age) for name, stamp, age in readings if name == sensor.name or not (name or number)]
            stamps, ages = [stamp for stamp, _ in mine], [age for _, age in mine]
            found.append(SensorSeries(sensor.name, sensor.rate, f"{kind}.{sensor.name}", stamps, ages))
    return found
