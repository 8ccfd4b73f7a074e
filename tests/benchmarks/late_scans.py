"""Scans that come late, or lie about their time: `python -m tests.benchmarks.late_scans [--every 1]`.

A robot is driven at a wall by a hand that presses again after every stop. It stands 2.5 m before it, drives from 3 s
on; from 4 s on its scans come late, or their stamps are no numbers, lie ahead or step back as well. The readings go
through the code of the drivers to the points of the gate's guard and through the gate itself, on simulated time:
`sim` straight into frames, `py` through Readings, `ros` as encoded messages through the bridge that foxglove,
rosbridge and zenoh share, `scip` through the clock of a Hokuyo. Told: contacts, and the time from the first lie to
zero.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from core.gate import TICK, Gate, Limits, Setpoint
from core.geometry import Pose
from core.robots.nearness import NearField
from core.robots.readings import Readings
from core.robots.ros.bridge import RosSensors
from core.robots.ros.topics import LASER_SCAN, ODOMETRY, RosSettings, choose_topics
from core.robots.ros.typestore import TWIST, RobotTypes
from core.robots.scip import WRAP, SensorTime
from core.sensors import Laser, Scan, SensorFrame, Wheels
from tests.emulators.ros_messages import RosMessageMaker

WALL_M, RADIUS_M = 2.5, 0.09
DRIVE_S, LIE_S, END_S = 3.0, 4.0, 14.0
LATE_S = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)
SPEEDS_M_S = (0.1, 0.3, 0.5)
BEARINGS = np.radians(np.arange(-180, 180))
LASER = Laser(beams=360, angle_min=-np.pi, angle_step=np.pi / 180)
TOPICS = {"/scan": LASER_SCAN, "/odom": ODOMETRY, "/cmd_vel": TWIST}
LIES: dict[str, Callable[[float], float]] = {
    "honest": lambda stamp: stamp,
    "no number": lambda stamp: math.nan,
    "future": lambda stamp: stamp + 60.0,
    "backward": lambda stamp: stamp - 60.0,
}


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
        self._sensors = RosSensors(types, choose_topics(TOPICS.items(), RosSettings.of({})))
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
        counter = round((scan.stamp + 100.0) * 1e3) % WRAP if math.isfinite(scan.stamp) else 0
        if self._time.plausible(counter):
            self.readings.scan(replace(scan, stamp=self._time.stamp(counter, self.now)))


DRIVERS: dict[str, type[Driver]] = {"sim": SimDriver, "py": OwnDriver, "ros": RosDriver, "scip": ScipDriver}


@dataclass
class Outcome:
    """How a drive went."""

    gap: float  # [m], the least between body and wall; less than 0: contact
    zero: float | None  # [s] from the first lie to standing; None: it goes on, rightly or not
    reason: str  # the gate's, at the end


def drive(
    driver: Driver, late: float, speed: float, lie: Callable[[float], float], *, always: bool = False
) -> Outcome:
    """Drive at the wall; `always`: late from the first scan on, stamps still from `LIE_S` on."""
    gate, field, rng = Gate(Limits(max_speed=0.5)), NearField((LASER,)), np.random.default_rng(1)
    gate.arm(1, "a stubborn hand", 0.0)
    waiting: deque[tuple[float, Scan]] = deque()
    x, press, gap, zero = 0.0, 1, math.inf, None
    for tick in range(round(END_S / TICK)):
        now = driver.now = TICK * tick
        lies = now >= LIE_S
        driver.wheels(Wheels(odometry=Pose(x), speed=gate.twist.v, turn_rate=0.0))
        if tick % 5 == 0:
            waiting.append((now + (late if lies or always else 0.0), scan_at(x, lie(now) if lies else now, rng)))
        while waiting and waiting[0][0] <= now:
            driver.scan(waiting.popleft()[1])
        near = field.see(driver.frame(), moving=gate.twist.moves)
        if near is not None:
            gate.see(near.points, now, near.field, near.age)
        elif field.untimely is not None:
            gate.see_untimely(field.untimely, now)
        gate.touch(False, now)
        gate.heartbeat(now)
        if now >= DRIVE_S and tick % 2 == 0:
            status = gate.status()
            press += status.need_neutral
            v = 0.0 if status.need_neutral else speed
            gate.accept(Setpoint(1, tick, "jog", press, v, 0.0, gate.nonce), now)
        x += gate.tick(now).v * TICK
        gap = min(gap, WALL_M - x - RADIUS_M)
        zero = None if gate.twist.moves or not lies else now - LIE_S if zero is None else zero
    return Outcome(gap, zero, gate.status().reason)


def scan_at(x: float, stamp: float, rng: np.random.Generator) -> Scan:
    """What the laser sees of the wall from there."""
    ahead = np.maximum(np.cos(BEARINGS), 0.05)
    ranges = np.where(np.cos(BEARINGS) > 0.05, max(WALL_M - x, 0.03) / ahead, 6.0) + rng.normal(0, 0.005, 360)
    return Scan(stamp=stamp, ranges=np.where(ranges < 5.6, ranges, np.inf), angle_min=-np.pi, angle_step=np.pi / 180)


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


def main() -> None:
    """Print the table, a row a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="take every n-th lateness")
    given = parser.parse_args()
    for row in table(LATE_S[:: given.every], SPEEDS_M_S):
        sys.stdout.write(json.dumps(row) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
