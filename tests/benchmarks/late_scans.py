"""Scans that come late, or lie about their time: `python -m tests.benchmarks.late_scans [--every 1] [--wires …]`.

A robot is driven at a wall by a hand that presses again after every stop. It stands 2.5 m before it, drives from 3 s
on; from 4 s on its scans come late, or their stamps are no numbers, lie ahead or step back as well. The readings go
through the code of the drivers to the points of the gate's guard and through the gate itself, on simulated time:
`sim` straight into frames, `py` through Readings, `ros` as encoded messages through the bridge that foxglove,
rosbridge and zenoh share, `scip` through the clock of a Hokuyo. Told: contacts, and the time from the first lie to
zero.

`--wires foxglove,rosbridge,zenoh,serial+scip`: the whole drivers instead, in real time, against the emulators of
these robots on sockets and the gate in this process: 216 drives of 7 s, the last 36 of robots that lag as a whole,
odometry and all, by clocks that count from their start. `--part 2/4`: a quarter of them.
"""

import itertools
import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from core.gate import TICK_S, Gate, Limits, Setpoint
from core.geometry import Pose
from core.robots import Robot
from core.robots.connect import connect
from core.robots.injected_faults import Delay
from core.robots.nearness import NearField, show
from core.robots.readings import Readings
from core.robots.ros.bridge import RosSensors
from core.robots.ros.topics import LASER_SCAN, ODOMETRY, RosSettings, choose_topics
from core.robots.ros.typestore import TWIST, RobotTypes
from core.robots.scip import COUNTER_WRAP_MS, SensorTime
from core.sensors import Laser, Scan, SensorFrame, Wheels
from tests.benchmarks.command import print_row, run_command
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.ros_messages import PROFILE, RosMessageMaker
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.scip import PERIOD, STEPS, ScipEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

WALL_M, RADIUS_M = 2.5, 0.09
DRIVE_S, LIE_S, END_S = 3.0, 4.0, 14.0
LATE_S = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)
SPEEDS_M_S = (0.1, 0.3, 0.5)
BEARINGS = np.radians(np.arange(-180, 180))
LASER = Laser(beams=360, angle_min=-np.pi, angle_step=np.pi / 180)
TOPICS = {"/scan": LASER_SCAN, "/odom": ODOMETRY, "/cmd_vel": TWIST}
WIRE_LATE_S, WHOLE_LATE_S = (0.0, 0.3, 1.0, 2.0, 5.0), (1.0, 2.0, 5.0)
SETTLING_S, RUN_UP_S, BLIND_S, LYING_S = 1.0, 1.5, 1.5, 3.5  # [s]; contact is where it drove blind for BLIND_S
FAILSAFE_S = 0.5  # after which the wheels of an emulated robot stop without speeds
SCAN_TICKS = round(PROFILE.rate / 10)
LASER_STEPS = 768  # of a Hokuyo's turn, from its step 0 until the scan is sent
SENSORS_ALONE = "?image=none&camera_info=none&sound=none&battery=none"
LIES: dict[str, Callable[[float], float]] = {
    "honest": lambda stamp: stamp,
    "no number": lambda stamp: math.nan,
    "future": lambda stamp: stamp + 60.0,
    "backward": lambda stamp: stamp - 60.0,
}


OTHER_ROBOT_TOPICS = ("scan", "odometry", "both")  # what of another robot comes by the same name
WIRES_SHARED = ("py", "ros", "scip")  # drivers of robots that a wire leads to


class Driver(ABC):
    """A driver's code between what is sensed and a frame."""

    def __init__(self) -> None:
        self.now = 0.0  # [s]
        self.readings = Readings(lambda: self.now)

    def wheels(self, wheels: Wheels) -> None:
        self.readings.wheels(wheels.odometry, wheels.speed, wheels.turn_rate)

    @abstractmethod
    def scan(self, scan: Scan) -> None:
        """A scan arrives."""

    def frame(self) -> SensorFrame:
        return self.readings.frame()


class SimDriver(Driver):
    """No driver: what is sensed is the frame."""

    def __init__(self) -> None:
        super().__init__()
        self._scan: Scan | None = None
        self._wheels: Wheels | None = None

    def wheels(self, wheels: Wheels) -> None:
        self._wheels = wheels

    def scan(self, scan: Scan) -> None:
        self._scan = scan

    def frame(self) -> SensorFrame:
        scan, self._scan = self._scan, None
        return SensorFrame(stamp=self.now, wheels=self._wheels, scan=scan)


class OwnDriver(Driver):
    """A driver of one's own, that stamps by `readings.now()`."""

    def scan(self, scan: Scan) -> None:
        self.readings.scan(scan)


class RosDriver(Driver):
    """The bridge, whose robot has a clock of its own. ROS has whole numbers alone: no number is no time there."""

    def __init__(self) -> None:
        super().__init__()
        types = RobotTypes()
        for kind in TOPICS.values():
            types.borrow(kind)
        self._maker, self._bare = RosMessageMaker(1_700_000_000.0), RosMessageMaker(0.0)
        self._sensors = RosSensors(types, choose_topics(TOPICS.items(), RosSettings.of({})), lambda *_: None)
        self._sensors.attach(self.readings)

    def wheels(self, wheels: Wheels) -> None:
        self._sensors.take("/odom", self._maker.odometry(wheels, self.now))

    def scan(self, scan: Scan) -> None:
        if math.isfinite(scan.stamp):
            self._sensors.take("/scan", self._maker.scan(scan))
        else:
            self._sensors.take("/scan", self._bare.scan(replace(scan, stamp=0.0)))


class ScipDriver(Driver):
    """A laser's counter of milliseconds; the base is on a line of its own."""

    def __init__(self) -> None:
        super().__init__()
        self._time = SensorTime(-100.0, 0.0)

    def scan(self, scan: Scan) -> None:
        counter = round((scan.stamp + 100.0) * 1e3) % COUNTER_WRAP_MS if math.isfinite(scan.stamp) else 0
        if self._time.plausible(counter):
            self.readings.scan(replace(scan, stamp=self._time.stamp(counter, self.now)))


DRIVERS: dict[str, type[Driver]] = {"sim": SimDriver, "py": OwnDriver, "ros": RosDriver, "scip": ScipDriver}


@dataclass
class Outcome:
    """How a drive went."""

    gap: float  # [m], the least between body and wall; less than 0: contact
    zero: float | None  # [s] from the first lie to standing; None: it goes on, rightly or not
    reason: str  # the gate's, at the end


def see(gate: Gate, field: NearField, frame: SensorFrame, now: float) -> None:
    """Show the gate a frame, and that the console is alive."""
    show(gate, field, frame, now)
    gate.heartbeat(now)


def pressed_on(gate: Gate, tick: int, press: int, speed: float, now: float) -> int:
    """Hold the stick at `speed` [m/s], and press again after a stop → the number of the press."""
    status = gate.status()
    press += status.need_neutral
    gate.accept(Setpoint(1, tick, "jog", press, 0.0 if status.need_neutral else speed, 0.0, gate.nonce), now)
    return press


def drive(
    driver: Driver,
    late: float,
    speed: float,
    lie: Callable[[float], float],
    *,
    always: bool = False,
    stranger: str = "",
) -> Outcome:
    """Drive at the wall; `always`: late from the first scan on, stamps still from `LIE_S` on.

    `stranger`: one of `OTHER_ROBOT_TOPICS`; from then on those of a robot that stays where it is come in between.
    """
    gate, field, rng = Gate(Limits(max_speed=0.5)), NearField((LASER,)), np.random.default_rng(1)
    gate.arm(1, "a stubborn hand", 0.0)
    waiting = Delay[Scan]()
    x, press, gap, zero = 0.0, 1, math.inf, None
    for tick in range(round(END_S / TICK_S)):
        now = driver.now = TICK_S * tick
        lies = now >= LIE_S
        driver.wheels(Wheels(odometry=Pose(x), speed=gate.twist.v, turn_rate=0.0))
        if tick % 5 == 0:
            waiting.put(scan_at(x, lie(now) if lies else now, rng), now + (late if lies or always else 0.0))
        for scan in waiting.arrived(now):
            driver.scan(scan)
        if stranger in ("scan", "both") and lies and tick % 5 == 2:
            driver.scan(scan_at(0.0, now, rng))
        if stranger in ("odometry", "both") and lies:
            driver.wheels(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0))
        see(gate, field, driver.frame(), now)
        if now >= DRIVE_S and tick % 2 == 0:
            press = pressed_on(gate, tick, press, speed, now)
        x += gate.tick(now).v * TICK_S
        gap = min(gap, WALL_M - x - RADIUS_M)
        zero = None if gate.twist.moves or not lies else now - LIE_S if zero is None else zero
    return Outcome(gap, zero, gate.status().reason)


def scan_at(x: float, stamp: float, rng: np.random.Generator) -> Scan:
    """What the laser sees of the wall from there."""
    ahead = np.maximum(np.cos(BEARINGS), 0.05)
    ranges = np.where(np.cos(BEARINGS) > 0.05, max(WALL_M - x, 0.03) / ahead, 6.0) + rng.normal(0, 0.005, 360)
    return Scan(stamp=stamp, ranges=np.where(ranges < 5.6, ranges, np.inf), angle_min=-np.pi, angle_step=np.pi / 180)


class WallWorld(World):
    """A robot before a wall, in real time. Its scans come late, and lie, as soon as it is told to."""

    def __init__(self, wall: float) -> None:
        """`wall` [m] from the robot's middle."""
        super().__init__()
        self.late, self.lie = 0.0, LIES["honest"]
        self.whole = False  # the odometry is as late as the scans
        self.stranger = ""  # what of another robot, which stays where this one began, comes by the same name
        self.gap = wall - RADIUS_M  # [m], the least until now
        self.stood_since: float | None = None  # time.monotonic(); None: it moves
        self._wall, self._x = wall, 0.0

    def start(self) -> None:
        self._over.clear()
        self._thread = threading.Thread(target=self._roll, name="wall", daemon=True)
        self._thread.start()

    def _roll(self) -> None:
        period, rng = 1 / PROFILE.rate, np.random.default_rng(1)
        waiting, rolled = Delay[Scan](), Delay[Wheels]()
        self._began = time.monotonic()
        for tick in itertools.count():
            stamp = tick * period
            if self._over.wait(max(0.0, self.instant(stamp) - time.monotonic())):
                return
            with self._lock:
                speed = self._wanted.v if time.monotonic() - self._wanted_at < FAILSAFE_S else 0.0
            self._x += speed * period
            self.gap = min(self.gap, self._wall - self._x - RADIUS_M)
            self.stood_since = None if speed else self.stood_since or time.monotonic()
            late = self.late if self.whole else 0.0
            rolled.put(Wheels(odometry=Pose(self._x), speed=speed, turn_rate=0.0), stamp + late)
            if self.stranger in ("odometry", "both"):
                rolled.put(Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), stamp)
            if tick % SCAN_TICKS == 0:
                seen = scan_at(WALL_M - self._wall + self._x, self.lie(stamp), rng)
                waiting.put(seen, stamp + self.late)
            if tick % SCAN_TICKS == SCAN_TICKS // 2 and self.stranger in ("scan", "both"):
                waiting.put(scan_at(WALL_M - self._wall, stamp, rng), stamp)
            for value, callbacks in (
                *((wheels, self.on_wheels) for wheels in rolled.arrived(stamp)),
                *((seen, self.on_scan) for seen in waiting.arrived(stamp)),
            ):
                for take in callbacks:
                    take(value)  # type: ignore[arg-type]


EMULATORS: dict[str, Callable[[WallWorld], Any]] = {
    "foxglove": FoxgloveEmulator,
    "rosbridge": RosbridgeEmulator,
    "zenoh": ZenohEmulator,
    "serial": SerialRobot,
}


def emulators_of(wires: str, world: WallWorld) -> list[Any]:
    """The emulators of a robot, `foxglove` or `serial+scip`, with the world behind them."""
    made: list[Any] = []
    for kind in wires.split("+"):
        if kind == "scip":
            sensor = ScipEmulator()
            turn = PERIOD * LASER_STEPS / STEPS  # from its first beam until a scan is there
            world.on_scan.append(
                lambda scan, sensor=sensor, turn=turn: sensor.show_scan(scan, world.instant(scan.stamp) - turn)
            )
            made.append(sensor)
        else:
            made.append(EMULATORS[kind](world))
            made[-1].simulates = False
    return made


def drive_wires(
    wires: str, late: float, speed: float, lie: Callable[[float], float], *, whole: bool = False, stranger: str = ""
) -> Outcome:
    """Drive at the wall over real sockets, in real time; it would be touched `BLIND_S` after the first lie.

    `whole`: the odometry is as late as the scans. `stranger`: see `drive`.
    """
    world = WallWorld(RADIUS_M + speed * (RUN_UP_S + BLIND_S))
    world.whole = whole
    parts = emulators_of(wires, world)
    for part in (*parts, world):
        part.start()
    try:
        robot = connect("+".join(part.url + (SENSORS_ALONE if "+" not in wires else "") for part in parts))
        try:
            return press(robot, world, late, speed, lie, stranger)
        finally:
            robot.close()
    finally:
        for part in (world, *parts):
            part.stop()


def press(
    robot: Robot, world: WallWorld, late: float, speed: float, lie: Callable[[float], float], stranger: str = ""
) -> Outcome:
    """Drive a robot by hand for as long as it takes, pressing again after every stop."""
    gate, field = Gate(Limits(max_speed=0.5)), NearField(robot.profile.lasers)
    start = time.monotonic()
    lies_from, pressed = math.inf, 1
    gate.arm(1, "a stubborn hand", 0.0)
    for tick in itertools.count():
        time.sleep(max(0.0, start + tick * TICK_S - time.monotonic()))
        now = time.monotonic() - start
        see(gate, field, robot.read(), now)
        if now >= SETTLING_S and tick % 2 == 0:
            pressed = pressed_on(gate, tick, pressed, speed, now)
        robot.drive(gate.tick(now))
        if lies_from == math.inf and now >= SETTLING_S + RUN_UP_S:
            lies_from, world.late, world.lie, world.stranger = time.monotonic(), late, lie, stranger
        if now >= SETTLING_S + RUN_UP_S + LYING_S:
            stood = world.stood_since
            zero = None if stood is None else max(stood - lies_from, 0.0)
            return Outcome(world.gap, zero, gate.status().reason)
    raise AssertionError


def wire_table(wires: Sequence[str], part: int = 1, parts: int = 1) -> Iterator[dict[str, object]]:
    """One row for each robot, lie, lateness and speed; of `parts` the one of that number."""
    lies = [name for name in LIES if name != "no number"]  # no wire carries one
    scans = [(*cell, False) for cell in itertools.product(wires, lies, WIRE_LATE_S, SPEEDS_M_S)]
    wholes = [(*cell, True) for cell in itertools.product(wires, ["honest"], WHOLE_LATE_S, SPEEDS_M_S)]
    for wire, stamps, late, speed, whole in (scans + wholes)[part - 1 :: parts]:
        found = drive_wires(wire, late, speed, LIES[stamps], whole=whole)
        yield {
            "wires": wire,
            "stamps": stamps,
            "late": "all" if whole else "scans",
            "late_s": late,
            "speed_m_s": speed,
            "contact": found.gap < 0,
            "gap_m": round(found.gap, 3),
            "zero_s": None if found.zero is None else round(found.zero, 2),
            "reason": found.reason,
        }


def table(late: Iterable[float], speeds: Iterable[float]) -> list[dict[str, object]]:
    """One row for each driver, lie and way of being late."""
    rows: list[dict[str, object]] = []
    cells = tuple(itertools.product(late, speeds))
    for (name, make), (lie, told), always in itertools.product(DRIVERS.items(), LIES.items(), (False, True)):
        found = [drive(make(), seconds, speed, told, always=always) for seconds, speed in cells]
        stopped = [one.zero for one in found if one.zero is not None]
        rows.append(
            {
                "driver": name,
                "stamps": lie,
                "late_from": "the start" if always else f"{LIE_S:g} s",
                "drives": len(found),
                "contacts": sum(one.gap < 0 for one in found),
                "least_gap_m": round(min(one.gap for one in found), 3),
                "slowest_zero_s": round(max(stopped), 2) if stopped else None,
            }
        )
    return rows


def main(
    *,
    every: int = 1,  # take every n-th lateness
    wires: str = "",  # robots on sockets, in real time: foxglove,serial+scip
    part: str = "1/1",  # of these: 2/4 is the second quarter
) -> None:
    number, parts = map(int, part.split("/"))
    robots = list(filter(None, wires.split(",")))
    for row in wire_table(robots, number, parts) if robots else table(LATE_S[::every], SPEEDS_M_S):
        print_row(row)


if __name__ == "__main__":
    run_command(main)
