"""From the robot to its camera and back: where standers and rectangles are, seen from each."""

import math
from collections.abc import Sequence

import numpy as np

from core.geometry import Pose, Ray
from core.message import Array
from core.perception.people.detector import Rectangle
from core.perception.people.legs import LegCluster
from core.perception.people.parts import PeopleSettings
from core.sensors import Camera

CAMERA_SD_M = 0.03  # across, of where a rectangle's axis is
CAMERA_FLOOR_RAD = 0.012
LEGS_BESIDE_M = 0.25  # of legs to the axis of the rectangle that they belong to
DISTANCE_FACTORS = (0.94, 1.0, 1.06)  # times a distance that is looked at


def eye(pose: Pose, camera: Camera) -> Pose:
    """Position of the camera in the world, with the robot's heading."""
    x, y = pose.apply(camera.mounting.translation[None, :2])[0]
    return Pose(float(x), float(y), pose.heading)


def axis(camera: Camera) -> float:
    """Azimuth [rad] of the camera's axis, robot frame."""
    ahead = camera.mounting.rotation[:, 2]
    return math.atan2(float(ahead[1]), float(ahead[0]))


def off_axis(bearing: float, camera: Camera) -> float:
    """Angle [rad] between a bearing in the robot's frame and the camera's axis, to either side."""
    return abs(math.remainder(bearing - axis(camera), math.tau))


def from_eye(stander: LegCluster, camera: Camera) -> tuple[float, float]:
    """Distance [m] and bearing [rad] of a stander from the camera, robot frame."""
    x, y = (stander.place - camera.mounting.translation[:2]).tolist()
    return math.hypot(x, y), math.atan2(y, x)


def stands_at(stander: LegCluster, other: Rectangle, camera: Camera) -> bool:
    """Return whether these legs belong to that rectangle."""
    far, angle = from_eye(stander, camera)
    return far * abs(math.sin(angle - other.bearing)) < 0.2 and abs(far - other.distance) < 0.15 * other.distance


def legs_of(
    rectangle: Rectangle, standers: Sequence[LegCluster], camera: Camera, settings: PeopleSettings
) -> LegCluster | None:
    """The legs that belong to a rectangle: in its direction, at about its distance."""
    best: LegCluster | None = None
    least = math.inf
    for one in standers:
        far, angle = from_eye(one, camera)
        aside = far * abs(math.sin(angle - rectangle.bearing))
        apart = abs(far - rectangle.distance) / (settings.near_floor + settings.near_laser * rectangle.distance)
        if aside < LEGS_BESIDE_M and apart < 1.0 and aside + apart * 0.2 < least:
            best, least = one, aside + apart * 0.2
    return best


def on_legs(rectangle: Rectangle, stander: LegCluster | None, settings: PeopleSettings) -> bool:
    """Return whether feet alone are a person: sure ones with something on them, or any with two legs."""
    sure = rectangle.value >= settings.threshold_of_feet
    return stander is not None and (sure or stander.legs == 2)


def ray_of(rectangle: Rectangle, eye: Pose, pose: Pose) -> Ray:
    """A rectangle as a bearing in the world, from the camera at `eye`."""
    floor = CAMERA_FLOOR_RAD if rectangle.bearing_sd is None else rectangle.bearing_sd
    sd = math.hypot(floor, CAMERA_SD_M / max(rectangle.distance, 0.1))
    return Ray(x=eye.x, y=eye.y, azimuth=pose.heading + rectangle.bearing, sd=sd)


def in_world(stander: LegCluster, pose: Pose) -> tuple[Array, Array]:
    """Position of legs in the world (2,) [m], and its covariance (2, 2)."""
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    turn = np.array([[c, -s], [s, c]])
    return pose.apply(stander.place[None])[0], turn @ stander.covariance @ turn.T


def around(distances: list[float]) -> list[float]:
    """Distances [m] and their neighbours, none twice."""
    kept: list[float] = []
    for distance in sorted(far * factor for far in distances for factor in DISTANCE_FACTORS):
        if distance > 0.4 and (not kept or distance > 1.03 * kept[-1]):
            kept.append(distance)
    return kept
