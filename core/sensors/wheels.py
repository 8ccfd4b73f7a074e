"""The wheels' encoders: how far the robot believes it has rolled."""

from __future__ import annotations

from core.geometry import Pose
from core.message import message


@message
class Wheels:
    """Odometry since the robot woke, so that a lost reading loses nothing."""

    odometry: Pose  # cumulative, in a frame of its own that drifts
    speed: float  # [m/s]
    turn_rate: float  # [rad/s]
    age: float = 0.0  # [s] over which the reading was carried on to its frame
    rate: float | None = None  # [Hz] at which readings come; None: with every frame
