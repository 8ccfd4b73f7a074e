"""The simulated wheels: encoders that slip and err, as the paper's and as perfect ones."""

import math

import numpy as np

from core.geometry import Pose, arc
from core.sensors.wheels import Wheels

SPEED_SD_M_S, STEER_SD_RAD = 0.2, math.radians(1.0)  # of eq. 43


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
