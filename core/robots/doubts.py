"""Doubts about a robot file: sentences for the operator on what is possible and improbable in it.

What cannot be is refused where the file is read (`core/robots/robot_file.py`).
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from core.robots import Profile
from core.sensors.camera import lens_faults
from core.sentences import Statement

if TYPE_CHECKING:
    from core.robots.robot_file import RobotFile

MAX_WHEELS_WIDTH = 1.3  # of the footprint, that the wheels may stand apart
MIN_WHEELS_WIDTH = 0.2  # of the footprint
MAX_OUTSIDE_M = 0.15  # of a sensor from the rim of the footprint: it would touch before the robot does
MAX_SENSOR_HEIGHT_M = 3.0
MIN_LASER_HEIGHT_M = 0.01  # of a scanning plane above the floor
MAX_RADIUS_M, MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S = 1.5, 2.0, 2 * math.pi
MAX_FAILSAFE_S, MAX_TIME_OFFSET_S = 5.0, 0.3
MAX_PITCH_DEG = 75.0
RADIANS_STEPS_DEG = {2: 15, 3: 5}  # of angles that people write, by the decimals of their radians; 3: or more
MAX_RADIANS = 6.3  # a full turn
ANGLE_KEYS = ("heading_deg", "yaw_deg", "pitch_deg", "roll_deg")


def doubts(file: "RobotFile", profile: Profile) -> tuple[str, ...]:
    """Sentences about what of a robot file is improbable for the robot of this profile, merged from both."""
    return (*_of_body(file, profile), *_of_angles(file), *_of_sensors(file, profile), *_of_lenses(file, profile))


def _of_body(file: "RobotFile", profile: Profile) -> Iterator[str]:
    ratio = profile.wheelbase / (2 * profile.radius)
    if (file.radius or file.wheelbase) and not MIN_WHEELS_WIDTH <= ratio <= MAX_WHEELS_WIDTH:
        wide = f"{2 * profile.radius:g}"
        yield Statement("robot_file.wheels", wheelbase=f"{profile.wheelbase:g}", width=wide)
    for key, value, most, unit in (
        ("radius", file.radius, MAX_RADIUS_M, "m"),
        ("max_speed", file.max_speed, MAX_SPEED_M_S, "m/s"),
        ("max_turn_rate", file.max_turn_rate, MAX_TURN_RATE_RAD_S, "rad/s"),
        ("failsafe", file.failsafe, MAX_FAILSAFE_S, "s"),
    ):
        if value is not None and value > most:
            yield _much(key, value, most, unit)
    if file.cruise is not None and file.cruise > profile.max_speed:
        yield Statement("robot_file.cruise", cruise=f"{file.cruise:g}", most=f"{profile.max_speed:g}")


def _of_angles(file: "RobotFile") -> Iterator[str]:
    for kind, tables in (("lasers", file.lasers), ("cameras", file.cameras), ("microphones", file.microphones)):
        for sensor, table in tables.items():
            for key in ANGLE_KEYS:
                angle = getattr(table, key, 0.0)
                if angle and _is_radians(angle):
                    yield Statement(
                        "robot_file.radians",
                        key=f"{kind}.{sensor}.{key}",
                        angle=f"{angle:g}",
                        degrees=f"{math.degrees(angle):.0f}",
                    )


def _is_radians(angle: float) -> bool:
    """Return whether an angle [deg] is no round number of degrees, and as it is written one of radians."""
    written = f"{abs(angle):f}".rstrip("0").partition(".")[2]
    decimals = min(len(written), max(RADIANS_STEPS_DEG))
    if decimals not in RADIANS_STEPS_DEG or abs(angle) > MAX_RADIANS:
        return False
    step = math.radians(RADIANS_STEPS_DEG[decimals])
    return abs(math.remainder(angle, step)) < 0.6 * 10.0**-decimals


def _of_sensors(file: "RobotFile", profile: Profile) -> Iterator[str]:
    places = {one.name: (one.mounting.x, one.mounting.y, one.height) for one in (*profile.lasers, *profile.arrays)}
    places |= {one.name: tuple(one.mounting.translation.tolist()) for one in profile.cameras}
    for name in (*file.lasers, *file.cameras, *file.microphones):
        x, y, z = places[name]
        if (away := math.hypot(x, y)) > profile.radius + MAX_OUTSIDE_M:
            yield Statement("robot_file.outside", name=name, away=f"{away:.3g}", radius=f"{profile.radius:g}")
        if z > MAX_SENSOR_HEIGHT_M or (name in file.lasers and z < MIN_LASER_HEIGHT_M):
            yield Statement("robot_file.height", name=name, height=f"{z:g}")
    for name, laser in file.lasers.items():
        if abs(laser.time_offset) > MAX_TIME_OFFSET_S:
            yield _much(f"lasers.{name}.time_offset", laser.time_offset, MAX_TIME_OFFSET_S, "s")
    for name, camera in file.cameras.items():
        if abs(camera.pitch_deg) > MAX_PITCH_DEG:
            yield _much(f"cameras.{name}.pitch_deg", camera.pitch_deg, MAX_PITCH_DEG, "deg")
    for array in profile.arrays:
        widest = max((math.dist(a, b) for a in array.positions for b in array.positions), default=0.0)
        if array.name in file.microphones and widest > 2 * (profile.radius + MAX_OUTSIDE_M):
            yield Statement(
                "robot_file.wide_array", name=array.name, width=f"{widest:.3g}", robot=f"{2 * profile.radius:g}"
            )


def _of_lenses(file: "RobotFile", profile: Profile) -> Iterator[str]:
    for camera in profile.cameras:
        table = file.cameras.get(camera.name)
        if table is not None and table.calibration:
            yield from (one.statement for one in lens_faults(camera.name, camera.model))


def _much(key: str, value: float, most: float, unit: str) -> str:
    return Statement("robot_file.much", key=key, value=f"{value:g}", most=f"{most:.3g}", unit=unit)
