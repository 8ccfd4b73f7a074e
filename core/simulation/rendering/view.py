"""The view of a level pinhole camera, and what is cut out of it."""

import math
from dataclasses import dataclass

import numpy as np

from core.message import Array


@dataclass(frozen=True)
class PinholeView:
    """A level pinhole view: where each pixel looks, per metre ahead."""

    width: int
    height: int
    focal: float  # [pixel]
    cx: float
    cy: float

    @property
    def x(self) -> Array:
        """(W,): to the right."""
        return (np.arange(self.width) - self.cx) / self.focal

    @property
    def y(self) -> Array:
        """(H,): down."""
        return (np.arange(self.height) - self.cy) / self.focal

    def columns(self, low: float, high: float) -> slice:
        """The columns that look between `low` and `high`."""
        first = max(0, math.ceil(self.cx + self.focal * max(low, -9.0)))
        return slice(first, max(first, min(self.width, math.floor(self.cx + self.focal * min(high, 9.0)) + 1)))

    def rows(self, low: float, high: float) -> slice:
        """The rows that look between `low` and `high`."""
        first = max(0, math.ceil(self.cy + self.focal * max(low, -9.0)))
        return slice(first, max(first, min(self.height, math.floor(self.cy + self.focal * min(high, 9.0)) + 1)))


@dataclass(frozen=True)
class Eye:
    """The place and heading of the camera."""

    x: float  # [m]
    y: float  # [m]
    z: float  # [m] above the floor
    heading: float  # [rad]

    def sees(self, points: Array) -> Array:
        """Points (K, 2) [m] → ahead and to the right (K, 2) [m]."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return (points - (self.x, self.y)) @ np.array([[c, s], [s, -c]])


@dataclass(frozen=True)
class Patch:
    """An upright texture in neighbouring columns."""

    columns: slice
    depth: Array  # (C,) [m] ahead
    along: Array  # (C,) [m] from the texture's left
    bottom: float  # [m] above the floor
    top: float  # [m]
    texture: Array
    scale: float  # [pixel/m] of the texture
    gain: float = 1.0  # brightness


def plane(
    view: PinholeView, eye: Eye, drop: float, corner: tuple[float, float], scale: float, first_row: int = 0
) -> Array:
    """Matrix (3, 3): pixel of the view → pixel of the texture of a level plane `drop` [m] below the eye.

    The texture begins at `corner` [m] and has `scale` [pixel/m]; `first_row` of the view counts as row 0.
    """
    c, s = math.cos(eye.heading), math.sin(eye.heading)
    ray = np.array([[s, 0.0, c], [-c, 0.0, s], [0.0, 0.0, 0.0]]) * drop
    place = np.array([[0.0, eye.x - corner[0], 0.0], [0.0, eye.y - corner[1], 0.0], [0.0, 1.0, 0.0]])
    step = 1 / view.focal
    look = np.array([[step, 0.0, -view.cx * step], [0.0, step, (first_row - view.cy) * step], [0.0, 0.0, 1.0]])
    texel = np.array([[scale, 0.0, -0.5], [0.0, scale, -0.5], [0.0, 0.0, 1.0]])
    return texel @ (ray + place) @ look


def ahead_of(polygon: Array, near: float) -> Array:
    """The part (M, 2) of a convex polygon (K, 2) that lies at least `near` [m] ahead."""
    kept: list[Array] = []
    for point, following in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if point[0] >= near:
            kept.append(point)
        if (point[0] >= near) != (following[0] >= near):
            kept.append(point + (following - point) * (near - point[0]) / (following[0] - point[0]))
    return np.array(kept).reshape(-1, 2)
