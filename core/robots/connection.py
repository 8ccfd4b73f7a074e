"""The connection to a robot, to be shown and confirmed: its parts, its topics, its sensors and their mountings."""

import math
from collections.abc import Sequence
from typing import Any, Literal, get_args

import msgspec
import numpy as np

from core.geometry import OPTICAL, Pose, Transform
from core.robots import Profile
from core.robots.device import Equipment, Findings
from core.robots.requests import RobotRequest
from core.robots.robot_file import CameraTable, LaserTable, RobotFile
from core.sensors import Camera, Laser
from core.sensors.microphones import MicrophoneArray

Origin = Literal["robot", "file", "assumed"]
"""Whence a figure is known: the robot or its driver says it, the robot file does, or nobody."""

LimitName = Literal["radius", "wheelbase", "cruise", "max_speed", "max_turn_rate"]
DECIMAL_DIGITS = 5


class FoundPart(msgspec.Struct, frozen=True, kw_only=True):
    """A device of the robot, by the name of its part of the URL, and its sensors by their names on this robot."""

    name: str
    up: bool  # its link
    drives: bool
    lasers: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    microphones: tuple[str, ...] = ()
    findings: Findings = Findings()


class FoundSensor(msgspec.Struct, frozen=True, kw_only=True):
    """A sensor that stands upright on the robot, and its mounting."""

    name: str
    x_m: float
    y_m: float
    heading_rad: float
    height_m: float
    mounting: Origin


class FoundLaser(FoundSensor, frozen=True, kw_only=True):
    """A laser and its mounting."""

    beams: int
    range_max_m: float
    rate_hz: float | None  # None: the robot does not say it
    time_offset_s: float  # that is configured


class FoundCamera(msgspec.Struct, frozen=True, kw_only=True):
    """A camera and its mounting; its angles as in a robot file."""

    name: str
    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    pitch_rad: float
    roll_rad: float
    mounting: Origin
    width: int
    height: int
    rate_hz: float | None  # None: the robot does not say it


class FoundMicrophones(FoundSensor, frozen=True, kw_only=True):
    """A microphone array and its mounting."""

    microphones: int


class FoundLimit(msgspec.Struct, frozen=True, kw_only=True):
    """A figure of the body or a limit of speed."""

    name: LimitName
    value: float  # [m], [m/s] or [rad/s]
    origin: Origin


class FoundRobot(msgspec.Struct, frozen=True, kw_only=True):
    """All that was found of a robot."""

    url: str
    name: str
    failsafe: str  # what the base does by itself when nobody speaks to it, a sentence; "": not known
    odometry: bool
    limits: tuple[FoundLimit, ...]
    parts: tuple[FoundPart, ...]
    lasers: tuple[FoundLaser, ...]
    cameras: tuple[FoundCamera, ...]
    microphones: tuple[FoundMicrophones, ...]


class ReadConnection(RobotRequest[FoundRobot], frozen=True, tag="connection"):
    """Ask a live robot what was found."""


class ReadRobotFile(RobotRequest[RobotFile], frozen=True, tag="robot_file"):
    """Ask a live robot for the robot file that it was made by, its URL filled in and its paths absolute."""


def describe(
    profile: Profile,
    parts: tuple[FoundPart, ...] = (),
    equipment: Sequence[Equipment] = (),
    file: RobotFile | None = None,
) -> FoundRobot:
    """The profile and what its devices found → all of it, each figure with its origin."""
    file = file or RobotFile()
    placed = {name for part in parts for name in part.findings.placed}
    base = next((one.base for one in equipment if one.base is not None), None)

    def origin(name: str) -> Origin:
        if getattr(file, name) is not None:
            return "file"
        return "assumed" if equipment and getattr(base, name, None) is None else "robot"

    def mounted(sensor: Laser | Camera, table: LaserTable | CameraTable | None) -> Origin:
        if table is not None and table.x is not None:
            return "file"
        at = sensor.mounting
        turned = isinstance(at, Pose) and any((at.x, at.y, at.heading))
        return "robot" if not parts or sensor.name in placed or turned else "assumed"

    def array_origin(name: str) -> Origin:
        return "file" if name in file.microphones else "assumed" if parts else "robot"

    return FoundRobot(
        url=profile.url,
        name=profile.name,
        failsafe=profile.failsafe,
        odometry=profile.odometry,
        limits=tuple(
            FoundLimit(name=name, value=getattr(profile, name), origin=origin(name)) for name in get_args(LimitName)
        ),
        parts=parts or (_whole(profile),),
        lasers=tuple(_laser(one, mounted(one, file.lasers.get(one.name))) for one in profile.lasers),
        cameras=tuple(_camera(one, mounted(one, file.cameras.get(one.name))) for one in profile.cameras),
        microphones=tuple(
            FoundMicrophones(**_mounted(one, array_origin(one.name)), microphones=len(one.positions))
            for one in profile.arrays
        ),
    )


def _whole(profile: Profile) -> FoundPart:
    return FoundPart(
        name=profile.url,
        up=True,
        drives=profile.drives,
        lasers=tuple(one.name for one in profile.lasers),
        cameras=tuple(one.name for one in profile.cameras),
        microphones=tuple(one.name for one in profile.arrays),
    )


def _mounted(sensor: Laser | MicrophoneArray, origin: Origin) -> dict[str, Any]:
    """The fields of a FoundSensor."""
    at = sensor.mounting
    place = {"x_m": _short(at.x), "y_m": _short(at.y), "heading_rad": _short(at.heading)}
    return {**place, "name": sensor.name, "height_m": round(sensor.height, DECIMAL_DIGITS), "mounting": origin}


def _laser(laser: Laser, origin: Origin) -> FoundLaser:
    return FoundLaser(
        **_mounted(laser, origin),
        beams=laser.beams,
        range_max_m=laser.range_max,
        rate_hz=None if laser.rate is None else round(laser.rate, 2),
        time_offset_s=laser.time_offset,
    )


def _camera(camera: Camera, origin: Origin) -> FoundCamera:
    x, y, z = (_short(value) for value in camera.mounting.translation.tolist())
    yaw, pitch, roll = angles_of(camera.mounting)
    return FoundCamera(
        name=camera.name,
        x_m=x,
        y_m=y,
        z_m=z,
        yaw_rad=yaw,
        pitch_rad=pitch,
        roll_rad=roll,
        mounting=origin,
        width=camera.model.width,
        height=camera.model.height,
        rate_hz=None if camera.rate is None else round(camera.rate, 2),
    )


def _short(value: float) -> float:
    return round(value, DECIMAL_DIGITS) + 0.0


def angles_of(mounting: Transform) -> tuple[float, float, float]:
    """robot_from_camera → its yaw, pitch and roll [rad]; the inverse of `robot_file.mounting_of`."""
    turned = mounting.rotation @ np.asarray(OPTICAL).T
    yaw = math.atan2(turned[1, 0], turned[0, 0])
    pitch = math.asin(min(1.0, max(-1.0, -turned[2, 0])))
    roll = math.atan2(turned[2, 1], turned[2, 2])
    return _short(yaw), _short(pitch), _short(roll)
