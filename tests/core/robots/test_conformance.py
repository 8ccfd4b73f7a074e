"""The conformance suite over all schemes. A new driver is one row of `SUBJECTS`."""

import math
import socket
import sys
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Protocol, cast

import numpy as np
import pytest

from core.errors import BadInput
from core.gate import ZERO, Twist
from core.geometry import Pose, arc
from core.robots.conformance import (
    MAX_STOPPING_S,
    ConformanceReport,
    Holdings,
    Interruption,
    SensorSeries,
    Suite,
    check_robot,
    left_behind,
    open_links,
)
from core.robots.connect import connect
from core.robots.driver_session import DriverSession
from core.robots.process import TWIST_TIMEOUT_S
from core.robots.ros.typestore import TWIST_STAMPED
from core.sensors import Scan, SensorFrame
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from tests.core.robots.links import loopback
from tests.emulators.camera import CameraEmulator
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.lds import LidarEmulator
from tests.emulators.microphones import PORT_NAME, MicrophonesEmulator
from tests.emulators.robot_process import scip
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.sound_card import sounddevice
from tests.emulators.srv1 import Srv1Emulator
from tests.emulators.toy_robot import ToyRobot
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

Speeds = list[tuple[float, float, float]]  # time.monotonic(), speeds that are zero when the robot shall stand

STOPS = 20, 100  # requests of which the slowest but one counts; the second in the campaign
BRIEF = {"MIN_MEASURING_S": 1.5, "TEST_DRIVE_S": 0.6, "MAX_MEASURING_S": 3.0}  # of an examination here
TRIES = 3  # examinations of a robot: other tests take the computer's time
FRAME_SHARE = 0.5  # of the frames: one interpreter does the work of driver, robot and world
GARBAGE = 200  # malformed messages
SLOW = Twist(0.02, 0.0)


class Emulator(Protocol):
    """The other end of the wire."""

    @property
    def url(self) -> str: ...

    def start(self) -> None: ...

    def stop(self) -> None: ...


@dataclass
class Emulated:
    """A robot on a wire, and what a test can do to it."""

    url: str
    restart: Interruption | None = None
    garble: Callable[[bytes], object] | None = None  # send these bytes to the driver
    applied: Callable[[], Speeds] | None = None  # every speed that came through the wire


@dataclass
class Subject:
    """A row of the table: a scheme and its emulator."""

    make: Callable[[], AbstractContextManager[Emulated]]
    stop_within: float = 0.030  # [s], 99 of 100 requests, from the request to zero on the wire
    lacks: tuple[str, ...] = field(default=())  # checks that say nothing about this robot


@contextmanager
def wired(emulator: Any, *parts: Any, heard: str = "heard") -> Generator[Emulated]:
    """An emulator with `start`, `stop`, `url`, `inject` and a list of what it heard, after the `parts` it needs."""
    for part in (emulator, *parts):
        part.start()
    yield Emulated(
        emulator.url,
        restart=Interruption(emulator.stop, emulator.start),
        garble=getattr(emulator, "inject", None),
        applied=(lambda: getattr(emulator, heard)) if hasattr(emulator, heard) else None,
    )
    for part in (*parts, emulator):
        part.stop()


@contextmanager
def without_wire(url: str) -> Generator[Emulated]:
    yield Emulated(url)


@contextmanager
def in_world(
    make: Callable[[World], Any], *, heard: str = "heard", failsafe: float | None = 0.5
) -> Generator[Emulated]:
    """An emulator of a robot in `sim:lab`."""
    world = World(failsafe=failsafe)
    with wired(make(world), world, heard=heard) as robot:
        yield robot


@contextmanager
def with_sound_card() -> Generator[Emulated]:
    """Microphones in `sim:lab`, behind the stand-in of the package sounddevice."""
    world = World(listening=True)
    card = MicrophonesEmulator(world)
    with wired(card, world) as robot, pytest.MonkeyPatch.context() as changed:
        changed.setitem(sys.modules, "sounddevice", sounddevice)
        changed.setenv(PORT_NAME, card.address)
        yield robot


@contextmanager
def srv1_with_laser() -> Generator[Emulated]:
    """The chapter's robot (figure 12): its base has no odometry, so that scans have to show whether it moves."""
    world = World(failsafe=None)
    base, laser = Srv1Emulator(world), scip(world)
    with wired(base, laser, world) as robot:
        yield replace(robot, url=f"{base.url}+{laser.url}")


SIGHT = ("rate", "stamps", "age")  # what a robot without laser and camera does not have
BASE = ("sound", "drive", "stop", "silence", "standing after reconnect")  # what a laser alone does not have
SUBJECTS = {
    "sim": Subject(lambda: without_wire("sim:lab"), lacks=("loss noticed", "reconnect", "standing after reconnect")),
    "foxglove": Subject(lambda: in_world(FoxgloveEmulator, heard="received"), lacks=("sound",)),
    "rosbridge": Subject(lambda: in_world(RosbridgeEmulator, heard="received"), lacks=("sound",)),
    "zenoh": Subject(lambda: in_world(ZenohEmulator, heard="received"), lacks=("sound",)),
    "serial": Subject(lambda: in_world(SerialRobot), lacks=(*SIGHT, "sound")),
    "srv1": Subject(
        lambda: in_world(Srv1Emulator, failsafe=None),
        stop_within=0.150,  # a picture is on its way
        lacks=BASE,  # it has no odometry
    ),
    "figure12": Subject(srv1_with_laser, stop_within=0.150, lacks=("sound",)),
    "scip": Subject(lambda: in_world(scip), lacks=BASE),
    "lds": Subject(lambda: in_world(lambda world: LidarEmulator(world, "ld19")), lacks=BASE),
    "camera": Subject(lambda: in_world(CameraEmulator), lacks=BASE),
    "audio": Subject(with_sound_card, lacks=(*SIGHT, *BASE[1:])),
    "py": Subject(lambda: wired(ToyRobot()), lacks=("sound",)),
}
CHECKS = (
    "connect",
    "frames",
    "rate",
    "stamps",
    "age",
    "sound",
    "drive",
    "stop",
    "silence",
    "loss noticed",
    "reconnect",
    "standing after reconnect",
    "close",
)


@pytest.fixture(scope="module", params=SUBJECTS)
def there(request: pytest.FixtureRequest) -> Iterator[tuple[Subject, Emulated]]:
    """Each subject, for all its tests."""
    subject = SUBJECTS[request.param]
    with subject.make() as robot:
        yield subject, robot


@pytest.fixture(scope="module")
def examined(there: tuple[Subject, Emulated]) -> tuple[Subject, ConformanceReport]:
    """As `beckon robot check --drive --interactive` does it; again, with more patience, where the computer was busy.

    One that goes on for good after a stop, or while nothing is asked of it, passes with no patience.
    """
    subject, robot = there
    with pytest.MonkeyPatch.context() as changed:
        for name, value in BRIEF.items():
            changed.setattr(f"core.robots.conformance.{name}", value)
        for tried in range(TRIES):
            changed.setattr("core.robots.conformance.FRAME_SHARE", FRAME_SHARE / 2**tried)
            changed.setattr("core.robots.conformance.MAX_STOPPING_S", MAX_STOPPING_S * 2**tried)
            report = check_robot(robot.url, drive=True, interruption=robot.restart)
            if report.passed:
                break
    return subject, report


@pytest.mark.parametrize("name", CHECKS)
def test_a_driver_holds(examined: tuple[Subject, ConformanceReport], name: str) -> None:
    subject, report = examined
    if name in subject.lacks:
        pytest.skip("This robot has no such thing.")
    mine = [check for check in report.checks if check.name == name or check.name.endswith(f" {name}")]
    assert mine, report.not_checked
    assert [(check.name, check.figure, check.advice) for check in mine if not check.passed] == []


@pytest.fixture(scope="module")
def session(there: tuple[Subject, Emulated]) -> Iterator[DriverSession]:
    """On the subject's wire, after its examination."""
    subject, robot = there
    if "reconnect" in subject.lacks:
        pytest.skip("This robot has no wire.")
    session = DriverSession(connect(robot.url))
    yield session
    session.close()


@pytest.fixture
def wire(there: tuple[Subject, Emulated], session: DriverSession) -> tuple[Subject, Emulated, DriverSession]:
    """A session that may drive, of a robot that stands."""
    session.frames(0.3, ZERO)
    return *there, session


def speeds(robot: Emulated) -> Speeds:
    if robot.applied is None:
        pytest.skip("This robot has no base.")
    return robot.applied()


def until(true: Callable[[], object], seconds: float = 100.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.001)


def moves(robot: Emulated) -> bool:
    heard = speeds(robot)
    return bool(heard) and any(heard[-1][1:])


def nth_slowest(values: list[float], share: float) -> float:
    """The value that this share of all does not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]


@pytest.mark.parametrize("stops", [STOPS[0], pytest.param(STOPS[1], marks=pytest.mark.campaign)])
def test_a_stop_is_on_the_wire_at_once(wire: tuple[Subject, Emulated, DriverSession], stops: int) -> None:
    subject, robot, session = wire
    over: list[float] = []
    for _ in range(TRIES):
        delays, machine = stop_delays(robot, session, stops)
        over.append(nth_slowest(delays, 1 - 1 / stops) - max(machine))
        if over[-1] <= subject.stop_within:
            break
    assert min(over) <= subject.stop_within, over


def stop_delays(robot: Emulated, session: DriverSession, stops: int) -> tuple[list[float], list[float]]:
    """[s] from each request to zero on the wire, and of a byte between two threads of this machine meanwhile."""
    chance, delays, machine = np.random.default_rng(1), list[float](), list[float]()
    with loopback() as measured:
        for _ in range(stops):
            session.frames(5.0, SLOW, until=lambda _: moves(robot))
            session.frames(float(chance.uniform(0.0, 0.05)))
            session.ask(ZERO)
            until(lambda: not moves(robot))
            delays.append(speeds(robot)[-1][0] - session.asked_at)
            machine.append(measured.delay())
    return delays, machine


def test_silence_is_zero_on_the_wire(wire: tuple[Subject, Emulated, DriverSession]) -> None:
    _, robot, session = wire
    session.ask(SLOW)
    until(lambda: moves(robot))
    until(lambda: not moves(robot))
    with loopback() as measured:
        late = TWIST_TIMEOUT_S + 0.3 + measured.delay()
    assert TWIST_TIMEOUT_S - 0.02 < speeds(robot)[-1][0] - session.asked_at < late


def test_after_a_restart_only_zero_comes_until_zero_was_asked_for(
    wire: tuple[Subject, Emulated, DriverSession],
) -> None:
    _, robot, session = wire
    session.frames(5.0, SLOW, until=lambda _: moves(robot))
    assert moves(robot) and robot.restart is not None
    robot.restart.cut()
    assert session.frames(15.0, SLOW, until=lambda frame: frame.trouble)[-1].trouble
    before = len(speeds(robot))
    robot.restart.restore()
    session.frames(20.0, SLOW, until=lambda frame: not frame.trouble)
    session.frames(0.5, SLOW)
    after = speeds(robot)[before:]
    assert after and not any(v or w for _, v, w in after)
    session.frames(0.2, ZERO)
    session.frames(5.0, SLOW, until=lambda _: moves(robot))
    assert moves(robot)


def test_malformed_bytes_move_nothing_and_end_nothing(wire: tuple[Subject, Emulated, DriverSession]) -> None:
    _, robot, session = wire
    if robot.garble is None:
        pytest.skip("The other end of this wire cannot be made to talk nonsense.")
    rng, before = np.random.default_rng(5), len(speeds(robot)) if robot.applied else 0
    start = session.frames(0.2, ZERO)[-1].wheels
    for _ in range(GARBAGE):
        robot.garble(rng.integers(0, 256, int(rng.integers(1, 300)), dtype=np.uint8).tobytes())
        session.frames(0.005, ZERO)
    assert not any(v or w for _, v, w in (speeds(robot)[before:] if robot.applied else []))
    robot.garble(b"\n")
    blind = not session.profile.lasers
    read = session.frames(20.0, ZERO, until=lambda frame: not frame.trouble and (blind or frame.scan is not None))
    assert read and not read[-1].trouble and (blind or read[-1].scan is not None)
    if start is not None and read[-1].wheels is not None:
        assert abs((start.odometry.inverse() @ read[-1].wheels.odometry).x) < 0.01


# The suite finds what is wrong: drivers with one fault each.

FAULTY = """
import threading, time
import numpy as np
from core.geometry import Pose
from core.robots.device import Base, Device, Equipment
from core.sensors import Camera, Image, Laser, Scan

FAULT = "{fault}"


class Faulty(Device):
    def __init__(self, arguments=""):
        self.over, self.v = threading.Event(), 0.0

    def open(self):
        self.over.clear()
        return Equipment(name="faulty", base=Base(), lasers=(Laser(rate=20.0),))

    def run(self, readings):
        x, stamp = 0.0, 0.0
        while not self.over.wait(0.05):
            x += self.v * 0.05 * (-1 if FAULT == "drive" else 1)
            readings.wheels(Pose(x, 0.0, 0.0), self.v, 0.0)
            if FAULT == "no readings":
                continue
            stamp = readings.now() + (0.2 if FAULT == "age" else 0.0) if FAULT != "stamps" or not stamp else stamp
            readings.scan(Scan(stamp=stamp, ranges=np.ones(5), angle_min=0.0, angle_step=0.1))
            if FAULT == "rate":
                time.sleep(0.05)

    def drive(self, twist):
        if twist.v or FAULT != "stop":
            self.v = twist.v

    def close(self):
        self.over.set()
        if FAULT == "close":
            threading.Thread(target=time.sleep, args=(4.0,), daemon=True, name="forgotten").start()
"""


@pytest.mark.parametrize(
    ("fault", "failed", "advice"),
    [
        ("age", "laser age", " ms in the future"),
        ("stamps", "laser stamps", "later stamp"),
        ("rate", "laser rate", "under [lasers.laser] of robot.toml"),
        ("no readings", "laser rate", "switched on"),
        ("drive", "drive", "swap the sign"),
        ("stop", "stop", "goes on after a stop"),
        ("close", "close", "thread forgotten"),
        ("", "", ""),
    ],
)
def test_a_fault_of_a_driver_is_found_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str, failed: str, advice: str
) -> None:
    for name in ("SENSOR_START_S", "MIN_MEASURING_S", "TEST_DRIVE_S"):
        monkeypatch.setattr(f"core.robots.conformance.{name}", 0.8)
    monkeypatch.setattr("core.robots.conformance.FRAME_SHARE", 0.2)  # of a busy computer
    (tmp_path / "faulty_robot.py").write_text(FAULTY.replace("{fault}", fault))
    report = check_robot(f"py:{tmp_path}/faulty_robot.py:", drive=fault in ("drive", "stop"))
    bad = {check.name: check.advice for check in report.checks if not check.passed}
    assert report.passed is (not fault) and (failed in bad) is bool(fault)
    assert advice in bad.get(failed, "")


def test_what_a_library_keeps_once_for_the_whole_process_is_no_leak(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sockets are counted here: other tests' may still be closing."""
    kept: list[object] = []
    monkeypatch.setattr("core.robots.conformance.CLOSING_TIME_S", 0.1)
    monkeypatch.setattr("core.robots.conformance.open_links", lambda: len(kept))

    def leak() -> None:
        kept.append(object())

    for again, left in ((lambda: None, []), (leak, ["1 sockets or devices"])):
        before = Holdings.now()
        leak()
        assert left_behind(before, again) == left


def test_open_sockets_are_counted() -> None:
    before = open_links()
    held = [socket.socket() for _ in range(64)]
    assert open_links() > before + 32, "some of other tests may have closed meanwhile"
    for one in held:
        one.close()


def test_a_robot_that_is_not_there_is_one_failed_check() -> None:
    robot = ToyRobot()
    robot.start()
    robot.stop()
    report = check_robot(robot.url)
    (check,) = report.checks
    assert (check.name, check.passed) == ("connect", False) and "cannot be reached" in check.advice


def test_without_consent_nothing_is_asked_to_move() -> None:
    with wired(ToyRobot()) as robot:
        report = check_robot(robot.url)
        assert not any(v or w for _, v, w in speeds(robot))
    assert {one.name for one in report.not_checked} == {"drive", "stop", "silence", "wheels over scans", "reconnect"}


def test_a_recording_has_no_driver(tmp_path: Path) -> None:
    log = tmp_path / "walk.log"
    log.write_text("".join(f"FLASER 3 1.0 1.0 1.0 0 0 0 0 0 0 {t} host {t}\n" for t in (1.0, 1.1, 1.2)))
    with pytest.raises(BadInput, match="has no driver"):
        check_robot(f"log:{log}")


@pytest.mark.parametrize(("told", "passed"), [(None, True), (20.0, True), (10.0, False)])
def test_a_rate_that_the_robot_does_not_say_is_reported_and_never_failed(told: float | None, passed: bool) -> None:
    """Readings come at 20 Hz."""
    suite = Suite.__new__(Suite)
    suite.session = SimpleNamespace(profile=SimpleNamespace(rate=40.0))  # pyright: ignore
    suite.checks, suite.not_checked = [], []
    stamps = [0.05 * number for number in range(20)]
    suite._check_series(SensorSeries("laser", told, "lasers.laser", stamps, [0.0] * 20))  # pyright: ignore
    rate = suite.checks[0]
    assert (rate.name, rate.passed, rate.figure) == ("laser rate", passed, pytest.approx(20.0))


def test_the_other_type_of_speeds_is_tried_where_the_guessed_one_moves_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("core.robots.ros.socket_link.LEARNING_TIMEOUT_S", 0.3)
    monkeypatch.setattr("core.robots.conformance.TEST_DRIVE_S", 1.0)
    world = World()
    emulator = RosbridgeEmulator(world, cmd_vel_type=TWIST_STAMPED, tells=False)
    world.on_image.clear()
    emulator.start()
    world.start()
    suite = Suite(DriverSession(connect(emulator.url)), lambda _: None)
    suite.check_driving(allowed=True)
    suite.session.close()
    world.stop()
    emulator.stop()
    found = {check.name: check for check in suite.checks}
    assert not found["speeds as Twist"].passed and (found["drive"].figure or 0.0) > 0.3
    assert 'cmd_vel_type = "TwistStamped"' in found["speeds as Twist"].advice


class SimulatedSession:
    """A session with the simulated robot, in its own time; its base may report other wheels than it has."""

    def __init__(self, turns: float = 1.0, *, lifted: bool = False, frozen: bool = False) -> None:
        self.robot = SimulatedRobot("lab", settings=SimulationSettings(camera=False))
        self.profile, self.watch = self.robot.profile, lambda frame: None
        self._turns, self._lifted, self._frozen, self._rolled = turns, lifted, frozen, Pose()
        self._held: Scan | None = None  # the first scan

    def frames(
        self, seconds: float, twist: Twist = ZERO, until: Callable[[SensorFrame], object] | None = None
    ) -> list[SensorFrame]:
        for _ in range(round(seconds * self.profile.rate)):
            self.robot.drive(ZERO if self._lifted else twist)
            frame = self.robot.read()
            assert frame.wheels is not None
            self._rolled = self._rolled @ arc(twist.v / self.profile.rate, twist.w / self.profile.rate)
            place = frame.wheels.odometry
            seen = self._rolled if self._lifted else Pose(place.x, place.y, self._turns * place.heading)
            frame = replace(frame, wheels=replace(frame.wheels, odometry=seen))
            self._held = self._held or frame.scan
            if self._frozen and frame.scan is not None and self._held is not None:
                frame = replace(frame, scan=replace(frame.scan, ranges=self._held.ranges))
            self.watch(frame)
            if until is not None and until(frame):
                break
        return []


@pytest.mark.parametrize(
    ("session", "drive", "found"),
    [
        ({}, False, "not moved"),
        pytest.param({}, True, "", marks=pytest.mark.campaign),
        ({"turns": 1.5}, True, "turns 1.5"),
        ({"lifted": True}, True, "on the floor"),
        ({"frozen": True}, True, "repeat"),
    ],
)
def test_wheels_and_scans_are_compared_on_a_drive_for_it(session: dict[str, Any], drive: bool, found: str) -> None:
    suite = Suite(cast(DriverSession, SimulatedSession(**session)), lambda _: None)
    suite.session.frames(1.0)
    suite._moved = True
    suite.check_agreement(drive=drive)
    told = [one.advice for one in suite.checks if not one.passed] + [one.reason for one in suite.not_checked]
    assert all(found.removeprefix("turns ") in one for one in told if found) and bool(told) is bool(found)
    assert ("agreement.turn_scale" in [one.code for one in suite.contradictions]) is found.startswith("turns")
    assert ("scan.frozen" in [one.code for one in suite.contradictions]) is session.get("frozen", False)
    if drive and not session.get("lifted") and not session.get("frozen"):
        assert suite.agreement is not None
        figures = {one.name: one.figure for one in suite.checks}
        assert figures["wheels over scans, turns"] == pytest.approx(session.get("turns", 1.0), abs=0.04)
        assert figures["wheels over scans, ways"] == pytest.approx(1.0, abs=0.15)


@pytest.mark.campaign
def test_scans_see_a_base_without_odometry_go_on_after_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = DriverSession.ask
    monkeypatch.setattr(DriverSession, "ask", lambda session, twist: asked(session, SLOW if twist == ZERO else twist))
    with srv1_with_laser() as robot:
        report = check_robot(robot.url, drive=True)
    passed = {check.name: check.passed for check in report.checks}
    assert passed["stop"] is False and passed["silence"] is True, report.checks
