"""The simulated two-wheeled base: it answers speeds with some delay, and walls stop it."""

import math
from typing import NamedTuple

from core.gate import ZERO, Twist
from core.geometry import Pose, arc
from core.simulation.world import World

TWIST_TIMEOUT_S = 0.5  # without a word from the driver, then the base stops by itself
SUBSTEP_S = 0.005
TOUCH_M = 0.002  # closer than this after a bump: still in contact
CREEP_SPEED = 1e-4  # [m/s], [rad/s] below which friction holds the base


class Move(NamedTuple):
    """The motion of the base in one substep."""

    forward: float  # [m]
    turn: float  # [rad]


class DifferentialDrive:
    """The true pose of the body. Speeds follow the commanded ones with the time constant `response` [s]."""

    def __init__(
        self, world: World, *, radius: float, max_speed: float, max_turn_rate: float, response: float = 0.06
    ) -> None:
        self.world = world
        self.pose = Pose()
        self.contact = False
        self._radius, self._limits = radius, (max_speed, max_turn_rate)
        self._response = response
        self._speed = ZERO
        self._wanted, self._wanted_age = ZERO, math.inf
        self._room = 0.0  # [m] that is surely free around the body

    @property
    def turn_rate(self) -> float:
        """Turn rate [rad/s]."""
        return self._speed.w

    def drive(self, twist: Twist) -> None:
        """Set the speed that holds for TIMEOUT at most; a speed that is not finite counts as zero."""
        v, w = (twist.v, twist.w) if twist.is_finite() else (0.0, 0.0)
        top_v, top_w = self._limits
        self._wanted = Twist(max(-top_v, min(top_v, v)), max(-top_w, min(top_w, w)))
        self._wanted_age = 0.0

    def enter(self, world: World) -> None:
        """Go on in `world`: something around the robot was changed."""
        self.world = world
        self._room = 0.0

    def carry(self, pose: Pose) -> None:
        """Stand at `pose`, at rest: the robot was carried."""
        self.pose, self._speed = pose, ZERO
        self.contact, self._room = False, 0.0

    def advance(self, duration: float) -> list[Move]:
        """Live on for `duration` [s] → how the wheels rolled."""
        steps = max(1, round(duration / SUBSTEP_S))
        return [self._step(duration / steps) for _ in range(steps)]

    def _step(self, dt: float) -> Move:
        self._wanted_age += dt
        wanted = self._wanted if self._wanted_age <= TWIST_TIMEOUT_S else ZERO
        keep = math.exp(-dt / self._response) if self._response > 0 else 0.0
        self._speed = Twist(_towards(self._speed.v, wanted.v, keep), _towards(self._speed.w, wanted.w, keep))
        move = Move(self._speed.v * dt, self._speed.w * dt)
        share = self._way_free(self.pose @ arc(*move))
        if share < 1:
            self.contact = True
            self._speed = Twist(0.0, self._speed.w)
            move = Move(share * move.forward, move.turn)
        self.pose = self.pose @ arc(*move)
        return move

    def _way_free(self, pose: Pose) -> float:
        """Return the share of the way to `pose` that is free. Motion away from an obstacle is never barred."""
        moved = math.hypot(pose.x - self.pose.x, pose.y - self.pose.y)
        self._room -= moved
        if self._room > 0:
            return 1.0
        distance = self.world.distance(pose.x, pose.y)
        self._room = distance - self._radius - TOUCH_M
        if self._room > 0:
            self.contact = False
        if distance >= self._radius or moved == 0:
            return 1.0
        before = self.world.distance(self.pose.x, self.pose.y)
        return 1.0 if distance >= before else max(0.0, (before - self._radius) / (before - distance))


def _towards(speed: float, wanted: float, keep: float) -> float:
    new = wanted + (speed - wanted) * keep
    return wanted if abs(new - wanted) < CREEP_SPEED else new
