"""The wheels' encoders: how far the robot believes it has rolled."""

from __future__ import annotations

from dataclasses import replace

from core.geometry import Pose, arc, wrap
from core.message import message

MOVING_SPEED = 0.02  # [m/s], [rad/s] from which a robot moves noticeably


MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S = 5.0, 7.0  # of a base, with a margin
MAX_STEP_M, MAX_STEP_RAD = 0.5, 0.6  # by which a reading may jump beyond that
ORIGIN_M, ORIGIN_RAD = 0.02, 0.035  # within which a base is that has just started
AWAY_M, AWAY_RAD = 0.1, 0.17  # beyond which a base was before it started again
BOOT_S = 0.4  # without a reading, in which any base can start again
SWIFT_M_S, SWIFT_RAD_S = 1.5, 3.0  # of a base that was on its way to its origin, in less time


def is_restart(before: Pose, after: Pose, elapsed: float) -> bool:
    """Return whether a base was restarted between two readings of its odometry, `elapsed` seconds apart.

    No base comes so far or turns so much in that time, or it counts from its origin again after a silence, or sooner
    than a robot that maps rooms comes there. Seen from the base itself, so places as they were read.
    """
    turned = abs(wrap(after.heading - before.heading))
    way, elapsed = before.distance_to(after.x, after.y), max(elapsed, 0.0)
    if way > MAX_STEP_M + MAX_SPEED_M_S * elapsed or turned > MAX_STEP_RAD + MAX_TURN_RATE_RAD_S * elapsed:
        return True
    was_away = before.distance_to(0.0, 0.0) > AWAY_M or abs(wrap(before.heading)) > AWAY_RAD
    is_at_origin = after.distance_to(0.0, 0.0) < ORIGIN_M and abs(wrap(after.heading)) < ORIGIN_RAD
    is_too_soon = way > AWAY_M + SWIFT_M_S * elapsed or turned > AWAY_RAD + SWIFT_RAD_S * elapsed
    return was_away and is_at_origin and (elapsed > BOOT_S or is_too_soon)


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
        return max(abs(self.speed), abs(self.turn_rate)) > MOVING_SPEED

    def carried(self, seconds: float) -> Wheels:
        """The same `seconds` [s] later, if they went on as they were."""
        place = self.odometry @ arc(self.speed * seconds, self.turn_rate * seconds)
        return replace(self, odometry=place, age=self.age + seconds)

    @property
    def as_read(self) -> Pose:
        """The odometry as it was read, `age` before its frame."""
        return self.odometry @ arc(self.speed * self.age, self.turn_rate * self.age).inverse()
