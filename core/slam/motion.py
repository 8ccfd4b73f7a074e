"""The motion model: increments and their covariances (eq. 18-23)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np

from core.geometry import Pose, rotation
from core.message import Array
from core.sensors import Wheels
from core.setting import Meta, Section

STILL_MOTION = 1e-7  # [m] and [rad]: below, the wheels stand
UNKNOWN_SD_M = 0.09  # from which a move is looked for wherever it may have led


@dataclass(frozen=True)
class MotionSettings(Section):
    """Noise of the odometry.

    `encoder`: slip, and the sizes of wheels and wheelbase, which no data sheet gives exactly. `paper`: the control
    noise Q (eq. 43) of speed and steering angle, drawn again with every control step.

    Watch:
        model: the pose's ellipse while driving, and NIS
        wheelbase: heading by the wheels after turning around ten times
        wheel_sd: the pose's ellipse, and NIS (raise it where that stays above 1)
        way_sd: the pose's ellipse along the way
        side_sd: the pose's ellipse across the way; raise it for a robot that skids
        speed_sd: the pose's ellipse with `model` paper
        steer_sd: the pose's ellipse with `model` paper
    """

    cruise: float = 0.1  # [m/s] speed at which the steering angle's error bends the path (section 6)
    step: float = 0.025  # [s] time between control updates (section 6)
    model: Annotated[Literal["encoder", "paper"], Meta(meaning="noise of real wheels, or Q of eq. 43")] = "encoder"
    wheelbase: Annotated[float, Meta("m", 0.02, 5, "distance between the wheels (section 6)")] = 0.10
    wheel_sd: Annotated[float, Meta("m/√m", 1e-5, 0.5, "error of either wheel for itself")] = 0.0015
    way_sd: Annotated[float, Meta("m/√m", 0, 0.5, "error of both wheels together")] = 0.004
    side_sd: Annotated[float, Meta("m/√m", 0, 0.5, "error sideways")] = 0.001
    speed_sd: Annotated[float, Meta("m/s", 1e-4, 5, "error of the speed (eq. 43)")] = 0.2
    steer_sd: Annotated[float, Meta("rad", 1e-5, 0.8, "error of the steering angle (eq. 43)")] = math.radians(1)


@dataclass(frozen=True)
class Increment:
    """A move seen from where it began, with its covariance (3, 3) of x, y, heading in that robot frame."""

    pose: Pose = field(default_factory=Pose)
    covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def then(self, further: Increment) -> Increment:
        """This move and a further one → both as one."""
        turned = rotation(self.pose.heading)
        ahead = turned @ (further.pose.x, further.pose.y)
        carry = np.array([[1.0, 0.0, -ahead[1]], [0.0, 1.0, ahead[0]], [0.0, 0.0, 1.0]])
        onto = np.eye(3)
        onto[:2, :2] = turned
        covariance = carry @ self.covariance @ carry.T + onto @ further.covariance @ onto.T
        return Increment(self.pose @ further.pose, covariance)

    @property
    def still(self) -> bool:
        """True if nothing has moved."""
        return not self.is_unknown and math.hypot(self.pose.x, self.pose.y) + abs(self.pose.heading) < STILL_MOTION

    @property
    def is_unknown(self) -> bool:
        """True where the wheels do not say how far it led: its covariance does."""
        return float(self.covariance[0, 0]) > UNKNOWN_SD_M**2


def widened(move: Increment, place_sd: float, heading_sd: float) -> Increment:
    """A move that led elsewhere by some `place_sd` [m] and `heading_sd` [rad]."""
    return Increment(move.pose, move.covariance + np.diag([place_sd, place_sd, heading_sd]) ** 2)


@dataclass(frozen=True)
class Motion:
    """The robot's move since the frame before, computed once for everything that needs it."""

    increment: Increment = field(default_factory=Increment)
    wheels: Wheels | None = None  # at the frame's stamp; without odometry the scans stand in for them
    by_scans: bool = False  # the increment is a scan match, not the wheels' word
    restarted: bool = False  # the base was: what it rolled meanwhile nobody knows
    scanned: float | None = None  # [s] the time of the pose, where that is the newest scan's and not the frame's


def control_jacobian(forward: float, turn: float) -> Array:
    """Way and turn of a step → (3, 2): change of the increment with both (eq. 23, corrected and at the midpoint)."""
    c, s = math.cos(0.5 * turn), math.sin(0.5 * turn)
    return np.array([[c, -0.5 * forward * s], [s, 0.5 * forward * c], [0.0, 1.0]])


def rolled(pose: Pose, elapsed: float, settings: MotionSettings) -> Increment:
    """A move as the wheels report it over `elapsed` [s] → the move with its covariance; none while they stand."""
    if math.hypot(pose.x, pose.y) + abs(pose.heading) < STILL_MOTION:
        return Increment(pose)
    half = 0.5 * pose.heading
    forward = math.copysign(math.hypot(pose.x, pose.y), pose.x * math.cos(half) + pose.y * math.sin(half))
    noise = encoder_noise if settings.model == "encoder" else paper_noise
    jacobian = control_jacobian(forward, pose.heading)
    covariance = jacobian @ noise(forward, pose.heading, elapsed, settings) @ jacobian.T
    c, s = math.cos(half), math.sin(half)
    side = settings.side_sd**2 * abs(forward)
    covariance[:2, :2] += side * np.array([[s * s, -s * c], [-s * c, c * c]])
    return Increment(pose, covariance)


def encoder_noise(forward: float, turn: float, elapsed: float, settings: MotionSettings) -> Array:
    """Covariance (2, 2) of way [m] and turn [rad]: wheels that err each for itself and together."""
    half = 0.5 * settings.wheelbase
    left = settings.wheel_sd**2 * abs(forward - half * turn)
    right = settings.wheel_sd**2 * abs(forward + half * turn)
    cross = (right - left) / (2 * settings.wheelbase)
    common = settings.way_sd**2 * abs(forward)
    return np.array([[(left + right) / 4 + common, cross], [cross, (left + right) / settings.wheelbase**2]])


def paper_noise(forward: float, turn: float, elapsed: float, settings: MotionSettings) -> Array:
    """Covariance (2, 2) of way [m] and turn [rad] under the paper's Q (eq. 43), drawn again with every control step.

    An error of the steering angle turns a base of wheelbase L by V dt / L per radian, as in the car-like model.
    """
    steps = max(elapsed / settings.step, 1.0)
    turning = settings.cruise * settings.step * settings.steer_sd / settings.wheelbase
    return steps * np.diag([(settings.speed_sd * settings.step) ** 2, turning**2])


def steered(speed: float, steer: float, elapsed: float, settings: MotionSettings) -> Increment:
    """Car-like base of the paper's simulation: speed [m/s] and steering angle [rad] for `elapsed` [s] → the move.

    In the print (eq. 20) the steering angle and the change of heading are one symbol; here they are two.
    """
    c, s = math.cos(steer), math.sin(steer)
    way = speed * elapsed
    jacobian = steered_jacobian(speed, steer, elapsed, settings.wheelbase)
    noise = np.diag([settings.speed_sd**2, settings.steer_sd**2])
    return Increment(Pose(way * c, way * s, way * s / settings.wheelbase), jacobian @ noise @ jacobian.T)


def steered_jacobian(speed: float, steer: float, elapsed: float, wheelbase: float) -> Array:
    """(3, 2): change of the car-like move with speed and steering angle."""
    c, s = math.cos(steer), math.sin(steer)
    return elapsed * np.array([[c, -speed * s], [s, speed * c], [s / wheelbase, speed * c / wheelbase]])


class WheelTrack:
    """Cumulative odometry → moves between frames. Lost frames lose nothing."""

    def __init__(self, settings: MotionSettings | None = None) -> None:
        self.settings = settings or MotionSettings()
        self._last: tuple[float, Wheels] | None = None

    def step(self, stamp: float, wheels: Wheels | None) -> Increment:
        """The wheels at `stamp` [s] → the move since those before; none at first, or after a jump back in time."""
        if wheels is None:
            return Increment()
        last, self._last = self._last, (stamp, wheels)
        if last is None or stamp < last[0]:
            return Increment()
        return rolled(last[1].odometry.inverse() @ wheels.odometry, stamp - last[0], self.settings)
