"""A simulated robot behind its gate that obeys one command by its wheels' word alone: no map, much faster."""

from dataclasses import replace

import numpy as np

from core.commands.command import Action, Progress
from core.gate import TICK_S, ZERO, Gate, Limits, Setpoint, TraceWriter, Twist, check
from core.geometry import Pose
from core.navigation.control_context import ControlContext, SteeredBody
from core.perception.landmarks.deskew import deskew
from core.robots.nearness import NearField, show
from core.robots.requests import CarryRobot, ReadTruth
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.map.occupancy import OccupancyGrid

NO_MAP = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))


class BareDrive:
    """One robot set down somewhere; `drive` lets an action steer it for a frame."""

    def __init__(
        self,
        place: str,
        start: Pose,
        *,
        seed: int = 0,
        cruise: float = 0.1,
        settings: SimulationSettings | None = None,
    ) -> None:
        self.robot = SimulatedRobot(place, seed=seed, settings=settings or SimulationSettings(camera=False))
        self.trace = TraceWriter()
        self.gate = Gate(Limits(), trace=self.trace)
        self.gate.arm(1, "benchmark", 0.0)
        self._near_field = NearField(self.robot.profile.lasers)
        self.body = SteeredBody(cruise=cruise)
        self.contacts, self._touching = 0, False
        self._seq, self._tick = 0, 0
        self._points = np.empty((0, 2))  # world, as the wheels have it
        self.robot.ask(CarryRobot(x_m=start.x, y_m=start.y, heading_rad=start.heading))
        self.here = self._sense()
        while not len(self.here.scan_points):
            self.step(ZERO)

    @property
    def truth(self) -> Pose:
        told = self.robot.ask(ReadTruth())
        return Pose(told.x_m, told.y_m, told.heading_rad)

    @property
    def clearance(self) -> float:
        """Room [m] around the body in truth."""
        return float(self.robot.ask(ReadTruth()).clearance_m)

    def drive(self, action: Action) -> Progress:
        progress = action.drive(self.here)
        self.step(Twist(float(progress.twist.v), float(progress.twist.w)))
        return progress

    def step(self, twist: Twist) -> None:
        now, nonce = self.here.stamp, self.gate.status().nonce
        self._seq += 1
        self.gate.accept(Setpoint(1, self._seq, "goal", 1, twist.v, twist.w, nonce), now)
        end = now + 1 / self.robot.profile.rate
        while self._tick * TICK_S < end - 1e-9:
            self.gate.tick(self._tick * TICK_S)
            self._tick += 1
        self.robot.drive(self.gate.twist)
        self.here = self._sense()

    def faults(self) -> list[str]:
        """What the trace checker says."""
        return check(self.trace.rows, self.gate.limits)

    def _sense(self) -> ControlContext:
        frame = replace(self.robot.read(), nonce=self.gate.status().nonce)
        laser = self.robot.profile.laser
        assert frame.wheels is not None and laser is not None
        pose = frame.wheels.odometry
        self.gate.heartbeat(frame.stamp)
        show(self.gate, self._near_field, frame, frame.stamp)
        self.contacts += frame.contact and not self._touching
        self._touching = frame.contact
        if frame.scan is not None:
            self._points = pose.apply(deskew(frame.scan, laser, frame.wheels, frame.stamp)[0])
        return ControlContext(
            stamp=frame.stamp,
            pose=pose,
            speed=frame.wheels.speed,
            turn_rate=frame.wheels.turn_rate,
            body=self.body,
            grid=NO_MAP,
            scan_points=pose.inverse().apply(self._points),
        )
