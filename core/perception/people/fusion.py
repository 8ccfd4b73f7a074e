"""Locate a speaker from the laser's range, the camera's bearing and the microphones' bearing."""

import math
from typing import Literal

import numpy as np

from core.geometry import Ray, wrap
from core.message import Array, message

Sense = Literal["laser", "camera", "sound"]
GATE_CHI2 = 9.0  # chi-square, one degree of freedom: three standard deviations; what differs more is another's
UNKNOWN_SD_M = 5.0  # sd of a distance of which nothing is known


@message
class Fused:
    """Position of a person."""

    position: Array  # (2,) [m] world
    covariance: Array  # (2, 2) [m²]
    used: tuple[Sense, ...]


def fuse(start: tuple[Array, Array], rays: tuple[tuple[Sense, Ray], ...], first: Sense | None = "laser") -> Fused:
    """A place (2,) [m] and its covariance (2, 2), and bearings from several senses → the place by all of them.

    `first`: which sense the place is from; None: it is only a guess. A bearing that misses by more than GATE allows
    is left out. Extended Kalman corrections, one sense after the other.
    """
    position, covariance = (np.array(each, float) for each in start)
    used: list[Sense] = [] if first is None else [first]
    for sense, ray in rays:
        gap, slope = _gap(position, ray)
        spread = float(slope @ covariance @ slope) + ray.sd**2
        if gap**2 > GATE_CHI2 * spread:
            continue
        gain = covariance @ slope / spread
        position = position + gain * gap
        covariance = covariance - np.outer(gain, gain) * spread
        used.append(sense)
    return Fused(position=position, covariance=(covariance + covariance.T) / 2, used=tuple(used))


def along(ray: Ray, distance: float, sd: float = UNKNOWN_SD_M) -> tuple[Array, Array]:
    """A bearing and a distance [m] with its sd → the place (2,) and its covariance (2, 2): a long thin ellipse."""
    c, s = math.cos(ray.azimuth), math.sin(ray.azimuth)
    ahead, across = np.array([c, s]), np.array([-s, c])
    place = np.array([ray.x, ray.y]) + distance * ahead
    return place, sd**2 * np.outer(ahead, ahead) + (distance * ray.sd) ** 2 * np.outer(across, across)


def _gap(position: Array, ray: Ray) -> tuple[float, Array]:
    """Angle [rad] by which the ray misses a place, and its derivative by the place (2,) [rad/m]."""
    away = position - (ray.x, ray.y)
    square = max(float(away @ away), 1e-6)
    gap = wrap(ray.azimuth - math.atan2(away[1], away[0]))
    return gap, np.array([-away[1], away[0]]) / square
