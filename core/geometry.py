"""The plane and the space: poses, transforms, lines.

Metres, radians, counter-clockwise; x forward, y left, z up. Chains read so that the ends touch:
`world_from_laser = world_from_robot @ robot_from_laser`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from core.message import Array, message


def wrap(angle: float) -> float:
    """Angle [rad] → the same direction in [-π, π)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def wrap_all(angles: Array) -> Array:
    """Angles (...) [rad] → the same directions in [-π, π)."""
    return (angles + np.pi) % (2 * np.pi) - np.pi


def rotation(angle: float) -> Array:
    """Angle [rad] → rotation matrix (2, 2)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


@dataclass(frozen=True)
class Pose:
    """A place and a heading in the plane; also the transform `outer_from_inner` of the inner frame there."""

    x: float = 0.0  # [m]
    y: float = 0.0  # [m]
    heading: float = 0.0  # [rad], counter-clockwise from +x

    def __matmul__(self, inner: Pose) -> Pose:
        """`a_from_b @ b_from_c` → `a_from_c`."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose(
            self.x + c * inner.x - s * inner.y, self.y + s * inner.x + c * inner.y, wrap(self.heading + inner.heading)
        )

    def inverse(self) -> Pose:
        """`a_from_b` → `b_from_a`."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, wrap(-self.heading))

    def apply(self, points: Array) -> Array:
        """Points (N, 2) [m] in the inner frame → the same points (N, 2) in the outer frame."""
        return points @ rotation(self.heading).T + (self.x, self.y)

    def distance_to(self, x: float, y: float) -> float:
        """Distance [m] from this place to (x, y)."""
        return math.hypot(x - self.x, y - self.y)

    def bearing_to(self, x: float, y: float) -> float:
        """Bearing [rad] of (x, y) seen from here, 0 straight ahead."""
        return wrap(math.atan2(y - self.y, x - self.x) - self.heading)

    @property
    def vector(self) -> Array:
        """(x, y, heading) as an array (3,)."""
        return np.array([self.x, self.y, self.heading])


def rotation_of_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Angles [rad] about the fixed axes x, then y, then z, as in URDF → rotation (3, 3)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(angle), math.sin(angle)) for angle in (roll, pitch, yaw))
    about_x, about_y = (
        np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]),
        np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]),
    )
    return np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ about_y @ about_x


def turned_covariance(covariance: Array, heading: float) -> Array:
    """A covariance (3, 3) of x, y, heading in a frame that is turned by `heading` [rad] → in the outer axes."""
    onto = np.eye(3)
    onto[:2, :2] = rotation(heading)
    return onto @ covariance @ onto.T


LEVEL_SLOPE = -1e-6  # a ray must at least lean downwards

Vector = tuple[float, float, float]


def floor_point(origin: Vector, direction: Vector) -> tuple[float, float] | None:
    """Return the point where a ray meets the floor [m], or None when it does not."""
    if not all(math.isfinite(value) for value in (*origin, *direction)) or direction[2] > LEVEL_SLOPE:
        return None
    reach = -origin[2] / direction[2]
    return origin[0] + reach * direction[0], origin[1] + reach * direction[1]


def arc(forward: float, turn: float) -> Pose:
    """Arc of length `forward` [m] that turns by `turn` [rad] → where it ends, seen from its start."""
    if abs(turn) < 1e-9:
        return Pose(forward, 0.5 * forward * turn, turn)
    radius = forward / turn
    return Pose(radius * math.sin(turn), radius * (1 - math.cos(turn)), wrap(turn))


@message
class Ray:
    """A bearing from somewhere."""

    x: float  # [m] world: from where
    y: float  # [m]
    azimuth: float  # [rad] world
    sd: float  # [rad]

    def bearing_to(self, x: float, y: float) -> float:
        """Azimuth [rad] of a place [m], world, from where the ray begins."""
        return math.atan2(y - self.y, x - self.x)


@message
class Transform:
    """A rigid transform of space, `outer_from_inner`."""

    rotation: Array  # (3, 3)
    translation: Array  # (3,) [m]

    def __matmul__(self, inner: Transform) -> Transform:
        """`a_from_b @ b_from_c` → `a_from_c`."""
        return Transform(
            rotation=self.rotation @ inner.rotation, translation=self.rotation @ inner.translation + self.translation
        )

    def inverse(self) -> Transform:
        """`a_from_b` → `b_from_a`."""
        return Transform(rotation=self.rotation.T, translation=-self.rotation.T @ self.translation)

    def apply(self, points: Array) -> Array:
        """Points (N, 3) [m] in the inner frame → the same points (N, 3) in the outer frame."""
        return points @ self.rotation.T + self.translation

    @staticmethod
    def of_pose(pose: Pose, height: float = 0.0) -> Transform:
        """A pose in the plane, lifted to `height` [m] → the transform of space."""
        matrix = np.eye(3)
        matrix[:2, :2] = rotation(pose.heading)
        return Transform(rotation=matrix, translation=np.array([pose.x, pose.y, height]))


OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""(3, 3): a camera's axes (x right, y down, z forward) seen from the frame that carries it level."""
