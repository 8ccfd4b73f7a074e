"""The simulated robot behind its gate: whatever stands in the way, it does not touch it."""

import math
from dataclasses import replace

import pytest

from core.gate import TICK_S, Gate, Limits, Setpoint, TraceWriter, check
from core.robots.nearness import NearField, show
from core.robots.requests import PlaceThing
from core.sensors import SensorFrame
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

BLIND = SimulationSettings(camera=False)


class Drive:
    """A stubborn driver at a fixed speed, on simulated time."""

    def __init__(self, seed: int = 0, *, laser: bool = True) -> None:
        self.robot = SimulatedRobot("lab", seed=seed, settings=BLIND)
        self.trace = TraceWriter()
        self.gate = Gate(Limits(), trace=self.trace)
        self.laser = laser
        self.gate.arm(1, "stubborn", 0.0)
        self._near_field = NearField(self.robot.profile.lasers)
        self._tick = 0
        self._seq = 0
        self.touched = False
        self.frame = self.step(0.0, 0.0)

    def step(self, v: float, w: float) -> SensorFrame:
        frame = replace(self.robot.read(), nonce=self.gate.status().nonce)
        now = frame.stamp
        self.gate.heartbeat(now)
        self.touched |= frame.contact
        show(self.gate, self._near_field, frame if self.laser else replace(frame, scan=None), now)
        self._seq += 1
        self.gate.accept(Setpoint(1, self._seq, "goal", 1, v, w, frame.nonce), now)
        while self._tick * TICK_S <= now:
            self.gate.tick(self._tick * TICK_S)
            self._tick += 1
        self.robot.drive(self.gate.twist)
        self.frame = frame
        return frame

    def run(self, seconds: float, v: float, w: float = 0.0) -> None:
        for _ in range(round(seconds * 40)):
            self.step(v, w)

    def place(self, ahead: float, aside: float, size: float = 0.2) -> None:
        truth = self.frame.truth
        assert truth is not None
        c, s = math.cos(truth.heading), math.sin(truth.heading)
        x, y = truth.x + c * ahead - s * aside, truth.y + s * ahead + c * aside
        self.robot.ask(PlaceThing(what="box", x_m=x, y_m=y, size_m=size))


@pytest.mark.parametrize("aside", [0.0, 0.08, -0.15, 0.19])
@pytest.mark.parametrize("w", [0.0, 0.4])
def test_a_box_that_appears_half_a_metre_ahead_is_not_touched(aside: float, w: float) -> None:
    drive = Drive(seed=round(100 * abs(aside)))
    drive.run(1.5, 0.3, w)
    drive.place(0.5 + 0.1 + 0.09, aside)
    drive.run(4.0, 0.3, w)
    assert not drive.touched
    assert check(drive.trace.rows, drive.gate.limits) == []


def test_a_wall_is_not_touched_and_the_way_back_is_open() -> None:
    drive = Drive()
    drive.run(20.0, 0.3)
    assert not drive.touched
    status = drive.gate.status()
    assert (status.v, status.reason) == (0.0, "something is in the way")
    assert status.blocked_by is not None and status.blocked_by[0] > 0.08
    stood = drive.frame.truth
    drive.run(2.0, -0.2)
    assert stood is not None and drive.frame.truth is not None
    assert stood.distance_to(drive.frame.truth.x, drive.frame.truth.y) > 0.15


def test_in_free_space_it_is_not_held_up() -> None:
    drive = Drive()
    drive.run(10.0, 0.2, 0.6)
    held = [row for row in drive.trace.rows if row.reason and row.t_mono_ns > 1e9]
    assert held == []
    assert drive.gate.status().trips == 0


def test_a_laser_that_fails_stops_it_within_half_a_second() -> None:
    drive = Drive()
    drive.run(2.0, 0.2, 0.5)
    drive.laser = False
    failed = drive.frame.stamp
    drive.run(1.0, 0.2, 0.5)
    moving = [row.t_mono_ns * 1e-9 for row in drive.trace.rows if row.v]
    assert max(moving) < failed + 0.5


def test_a_wall_behind_that_was_seen_before_is_not_touched_either() -> None:
    drive = Drive()
    drive.run(20.0, 0.3)  # up to the wall
    drive.run(math.pi / 0.8, 0.0, 0.8)  # the back to it
    drive.run(1.5, 0.2)
    drive.run(8.0, -0.3)
    assert not drive.touched
    assert drive.gate.status().reason == "something is in the way"
    assert min(row.v for row in drive.trace.rows) >= -0.1 - 1e-9
