"""The wheels' encoders: how far the robot believes it has rolled."""

from __future__ import annotations

from dataclasses import replace

from core.geometry import Pose, arc
from core.message import message

MOVING = 0.02  # [m/s], [rad/s] from which a robot moves noticeably


@message
class Wheels:
    """Odometry since the robot woke, so that a lost reading loses nothing."""

    odometry: Pose  # cumulative, in a frame of its own that drifts
    speed: float  # [m/s]
    turn_rate: float  # [rad/s]
    age: float = 0.0  # [s] over which the reading was carried on to its frame
    rate: float | None = None  # [Hz] at which readings come; None: with every frame

    @property
    def moves(self) -> bool:
        """True while the robot moves noticeably."""
        return max(abs(self.speed), abs(self.turn_rate)) > MOVING

    def carried(self, seconds: float) -> Wheels:
        """The same `seconds` [s] later, if they went on as they were."""
        place = self.odometry @ arc(self.speed * seconds, self.turn_rate * seconds)
        return replace(self, odometry=place, age=self.age + seconds)

    @property
    def as_read(self) -> Pose:
        """The odometry as it was read, `age` before its frame."""
        return self.odometry @ arc(self.speed * self.age, self.turn_rate * self.age).inverse()
