"""Direction of arrival of a sound, and its uncertainty."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.geometry import rotation, wrap
from core.message import Array, message
from core.perception.sound.plane_wave import PlaneWaveFit

MAX_AZIMUTH_SD_RAD = math.pi / math.sqrt(3)  # the standard deviation of an azimuth of which nothing is known
AHEAD_RAD = 0.15  # to either side of straight ahead, or behind, that counts as that in words


@message
class Direction:
    """A direction in the array frame, for a source that is far compared with the array's size."""

    stamp: float  # [s] when it was heard
    towards: Array  # (3,) unit vector towards the source
    covariance: (
        Array  # (2, 2) [rad²] on the sphere: along (counter-clockwise, up); azimuth counts times cos(elevation)
    )
    strength: float  # 0..1, how much of the sound came from there
    mirror: Array | None = None  # (3,) the direction that a flat array cannot tell from `towards`; None: it can
    fit: PlaneWaveFit | None = None  # of the microphones' times; None: not known

    @property
    def azimuth(self) -> float:
        """[rad] counter-clockwise from +x."""
        return math.atan2(self.towards[1], self.towards[0])

    @property
    def elevation(self) -> float:
        """[rad] above the array's level. With a level flat array it may as well be below: see `ambiguity`."""
        return math.asin(min(1.0, max(-1.0, self.towards[2])))

    @property
    def azimuth_sd(self) -> float:
        """Standard deviation of the azimuth [rad]."""
        level = math.hypot(self.towards[0], self.towards[1])
        return min(MAX_AZIMUTH_SD_RAD, math.sqrt(self.covariance[0, 0]) / max(level, 1e-6))

    @property
    def elevation_sd(self) -> float:
        """Standard deviation of the elevation [rad]."""
        return min(MAX_AZIMUTH_SD_RAD, math.sqrt(self.covariance[1, 1]))

    @property
    def misfit(self) -> float:
        """The part of the microphones' times that no plane wave explains, of what is expected; 0: not known."""
        return 0.0 if self.fit is None else self.fit.misfit

    @property
    def ambiguity(self) -> str:
        """The ambiguity of a flat array, in words for a person who looks along +x; '' where both directions agree."""
        if self.mirror is None:
            return ""
        other = replace(self, towards=self.mirror)
        if abs(wrap(other.azimuth - self.azimuth)) > self.azimuth_sd:
            return f"The array is flat: the sound may as well come from {in_words(other.azimuth)}."
        if abs(other.elevation - self.elevation) > self.elevation_sd:
            above, below = (f"{math.degrees(one.elevation):.0f}°".replace("-", "−") for one in (self, other))
            return f"The array is flat: the elevation is {above} or {below}."
        return ""

    def turned(self, angle: float) -> Direction:
        """The same seen from a frame in which the array's is turned by `angle` [rad], counter-clockwise."""
        turn = np.eye(3)
        turn[:2, :2] = rotation(angle)
        mirror = None if self.mirror is None else turn @ self.mirror
        return replace(self, towards=turn @ self.towards, mirror=mirror)

    def angle_to(self, towards: Array) -> float:
        """Angle [rad] between this and another unit vector (3,)."""
        return math.atan2(float(np.linalg.norm(np.cross(self.towards, towards))), float(self.towards @ towards))


def side(azimuth: float) -> Literal["left", "right"]:
    """Name the side of an azimuth [rad] for a person who looks along +x."""
    return "left" if wrap(azimuth) > 0 else "right"


def in_words(azimuth: float) -> str:
    """An azimuth [rad] as people say it: "31° to the right", "straight ahead"."""
    away = abs(wrap(azimuth))
    if away < AHEAD_RAD:
        return "straight ahead"
    return "behind" if away > math.pi - AHEAD_RAD else f"{math.degrees(away):.0f}° to the {side(azimuth)}"


def unit(azimuth: float, elevation: float = 0.0) -> Array:
    """Azimuth and elevation [rad] → unit vector (3,)."""
    level = math.cos(elevation)
    return np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])


def tangents(towards: Array) -> Array:
    """Unit vector (3,) → the directions (2, 3) counter-clockwise and up at that place of the sphere."""
    level = math.hypot(towards[0], towards[1])
    left = np.array([-towards[1], towards[0], 0.0]) / level if level > 1e-9 else np.array([0.0, 1.0, 0.0])
    return np.stack((left, np.cross(towards, left)))


def sphere(count: int) -> Array:
    """`count` unit vectors (count, 3), evenly over the sphere (Fibonacci's spiral)."""
    if count < 1:
        raise BadInput("A grid of directions needs at least one.")
    step = np.arange(count) + 0.5
    height = 1 - 2 * step / count
    turn = math.pi * (1 + math.sqrt(5)) * step
    level = np.sqrt(1 - height**2)
    return np.column_stack((level * np.cos(turn), level * np.sin(turn), height))
