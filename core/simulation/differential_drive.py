"""The simulated two-wheeled base: it answers speeds with some delay, and walls stop it.

Its wheels are encoders that slip and err, as the paper's or perfect ones.
"""

import math
from typing import NamedTuple

import numpy as np

from core.gate import ZERO, Twist
from core.geometry import Pose, arc
from core.sensors.wheels import Wheels
from core.simulation.world import World

TWIST_TIMEOUT_S = 0.5  # without a word from the driver, then the base stops by itself
SUBSTEP_S = 0.005
TOUCH_M = 0.002  # closer than this after a bump: still in contact
SPEED_SD_M_S, STEER_SD_RAD = 0.2, math.radians(1.0)  # of eq. 43
CREEP_SPEED = 1e-4  # [m/s], [rad/s] below which friction holds the base


class Move(NamedTuple):
    """The motion of the base in one substep."""

    forward: float  # [m]
    turn: float  # [rad]


STILL = Move(0.0, 0.0)


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
        if self._room > 0 and not (wanted.moves or self._speed.moves):
            return STILL
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


class PerfectWheels:
    """Odometry without any error."""

    def __init__(self) -> None:
        self._odometry = Pose()
        self._forward = self._turn = 0.0

    def roll(self, forward: float, turn: float) -> None:
        """The base moved on along an arc: `forward` [m], `turn` [rad]."""
        self._odometry = self._odometry @ arc(forward, turn)
        self._forward += forward
        self._turn += turn

    def read(self, elapsed: float) -> Wheels:
        """The reading, `elapsed` [s] after the former one."""
        speed, turn_rate = self._forward / elapsed, self._turn / elapsed
        self._forward = self._turn = 0.0
        return Wheels(odometry=self._odometry, speed=speed, turn_rate=turn_rate)


class EncoderWheels:
    """Two wheels that are not quite of the size and distance in the data sheet, that slip, and that count ticks.

    The size both wheels share is off by `scale_error`, their difference by `mismatch`, the wheelbase by
    `wheelbase_error` (standard deviations, relative, drawn once). Slip adds `slip` [m/√m] per wheel.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        wheelbase: float = 0.10,
        scale_error: float = 0.003,
        mismatch: float = 0.0002,
        wheelbase_error: float = 0.003,
        slip: float = 0.0007,
        tick: float = 0.00005,
    ) -> None:
        size, difference, base = rng.normal(size=3)
        common = 1 + scale_error * size
        self._gain = (common - mismatch * difference / 2, common + mismatch * difference / 2)
        self._true_wheelbase = wheelbase * (1 + wheelbase_error * base)
        self._wheelbase, self._slip, self._tick, self._rng = wheelbase, slip, tick, rng
        self._rolled = [0.0, 0.0]  # [m] left, right, as the rims turned
        self._counted = [0, 0]  # ticks
        self._odometry = Pose()

    def roll(self, forward: float, turn: float) -> None:
        """The base moved on along an arc: `forward` [m], `turn` [rad]."""
        half = turn * self._true_wheelbase / 2
        for wheel, distance in enumerate((forward - half, forward + half)):
            if distance:
                slipped = self._slip * math.sqrt(abs(distance)) * self._rng.normal()
                self._rolled[wheel] += self._gain[wheel] * distance + slipped

    def read(self, elapsed: float) -> Wheels:
        """The reading, `elapsed` [s] after the former one."""
        ticks = [math.floor(rolled / self._tick) for rolled in self._rolled]
        left, right = ((now - then) * self._tick for now, then in zip(ticks, self._counted, strict=True))
        self._counted = ticks
        forward, turn = (left + right) / 2, (right - left) / self._wheelbase
        self._odometry = self._odometry @ arc(forward, turn)
        return Wheels(odometry=self._odometry, speed=forward / elapsed, turn_rate=turn / elapsed)


class PaperWheels:
    """The paper's noise (eq. 43) of speed and of steering angle, drawn for every reading while the base moves."""

    def __init__(self, rng: np.random.Generator, *, wheelbase: float = 0.10, cruise: float = 0.1) -> None:
        self._rng, self._wheelbase, self._cruise = rng, wheelbase, cruise
        self._forward = self._turn = 0.0
        self._moved = False
        self._odometry = Pose()

    def roll(self, forward: float, turn: float) -> None:
        """The base moved on along an arc: `forward` [m], `turn` [rad]."""
        self._forward += forward
        self._turn += turn
        self._moved = self._moved or forward != 0.0 or turn != 0.0

    def read(self, elapsed: float) -> Wheels:
        """The reading, `elapsed` [s] after the former one. A steering error bends the path as at cruising speed."""
        speed, turn_rate = self._forward / elapsed, self._turn / elapsed
        if self._moved:
            speed += SPEED_SD_M_S * self._rng.normal()
            turn_rate += self._cruise * math.sin(STEER_SD_RAD * self._rng.normal()) / self._wheelbase
        self._odometry = self._odometry @ arc(speed * elapsed, turn_rate * elapsed)
        self._forward = self._turn = 0.0
        self._moved = False
        return Wheels(odometry=self._odometry, speed=speed, turn_rate=turn_rate)


SimulatedWheels = PerfectWheels | EncoderWheels | PaperWheels
