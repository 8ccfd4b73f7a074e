"""Zones of the map: those that the robot keeps out of, and those in which it drives slowly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from core.gate import Twist
from core.geometry import Pose
from core.message import Array
from core.slam.map.occupancy import OccupancyGrid, grown

ZoneKind = Literal["keep_out", "slow"]
KEPT_OUT_LOG_ODDS = 20.0  # of a cell that is planned around, however free it was seen
FLOOR_LOG_ODDS = -0.3  # up to which a cell is known to be free
REACTION_S = 0.25  # [s] until a stop reaches the wheels
BRAKING_M_S2 = 1.0  # [m/s²]
SLOW_MARGIN_M = 0.2  # before a slow zone, by which the place may be off
CAP_STEP_M_S = 0.05  # in which the speed falls on the way to one
MAX_RING_SHARE = 1.01  # of its convex hull, that a ring encloses which goes round once


@dataclass(frozen=True, kw_only=True, eq=False)
class MapZone:
    """A polygon of the map."""

    name: str
    kind: ZoneKind
    points: Array  # (N, 2) [m], world: its corners, N ≥ 3
    max_speed: float | None = None  # [m/s] of a slow one

    def depth(self, x: float, y: float) -> float:
        """How far (x, y) [m] lies inside [m]; < 0: so far outside."""
        corners = self.points.astype(np.float32).reshape(-1, 1, 2)
        return float(cv2.pointPolygonTest(corners, (float(x), float(y)), measureDist=True))


@dataclass(frozen=True)
class KeepOuts:
    """Zones that no wheel enters."""

    zones: tuple[MapZone, ...] = ()

    def around(self, x: float, y: float, radius: float = 0.0) -> MapZone | None:
        """The zone that a round body of `radius` [m] at (x, y) [m], world, touches."""
        return next((zone for zone in self.zones if zone.depth(x, y) > -radius), None)

    def left_by(self, pose: Pose) -> KeepOuts:
        """Those in which the robot does not stand: it may leave the one in which it does."""
        left = tuple(zone for zone in self.zones if zone.depth(pose.x, pose.y) <= 0.0)
        return self if len(left) == len(self.zones) else KeepOuts(left)

    def ahead(self, pose: Pose, twist: Twist, radius: float) -> MapZone | None:
        """The zone that a body of `radius` [m] would touch before it stands, if it drove on like this; not the one
        in which it stands.
        """
        if twist.v == 0.0 or not self.zones:
            return None
        way = stopping_way(twist.v)
        end = pose @ Pose(math.copysign(way, twist.v), 0.0, 0.0)
        for zone in self.left_by(pose).zones:
            if zone.depth(end.x, end.y) > max(-radius, zone.depth(pose.x, pose.y)):  # deeper than it is now
                return zone
        return None

    def on(self, grid: OccupancyGrid) -> OccupancyGrid:
        """The grid with these zones as walls, grown to hold all of them."""
        if not self.zones:
            return grid
        low = np.min([zone.points.min(axis=0) for zone in self.zones], axis=0) - grid.resolution
        high = np.max([zone.points.max(axis=0) for zone in self.zones], axis=0) + grid.resolution
        wide = grown(grid, low, high)
        log_odds = wide.log_odds.copy()
        for zone in self.zones:
            log_odds[cells_in(zone.points, wide)] = KEPT_OUT_LOG_ODDS
        return OccupancyGrid(
            revision=wide.revision, resolution=wide.resolution, origin=wide.origin, log_odds=log_odds
        )


@dataclass(frozen=True)
class SlowZones:
    """Zones in which the robot drives slowly."""

    zones: tuple[MapZone, ...] = ()

    def cap(self, pose: Pose | None, radius: float, largest: float) -> float | None:
        """The speed [m/s] that is allowed to a body of `radius` [m] here; the lowest wins. None: any up to `largest`.

        It falls with the way to a zone, whose own is reached `SLOW_MARGIN_M` before the body enters it: by the way
        alone, for a limit that went with the speed would be lifted once it was kept to. Without a `pose` the
        robot may be in any zone.
        """
        caps = [
            zone.max_speed if pose is None else _slowing(-zone.depth(pose.x, pose.y) - radius, zone.max_speed)
            for zone in self.zones
            if zone.max_speed is not None
        ]
        least = min(caps, default=largest)
        return least if least < largest else None


def roomiest_spot(points: Array, grid: OccupancyGrid) -> tuple[float, float] | None:
    """The spot (x, y) [m] within a polygon (N, 2), world, with most free floor around; None where there is none."""
    floor = np.pad(cells_in(points, grid) & (grid.log_odds < FLOOR_LOG_ODDS), 1).astype(np.uint8)
    gap = cv2.distanceTransform(floor, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    if not gap.any():
        return None
    row, column = np.unravel_index(int(gap.argmax()), gap.shape)
    x, y = grid.origin + (np.array([column, row]) + 0.5) * grid.resolution
    return float(x), float(y)


def stopping_way(speed: float) -> float:
    """How far [m] the robot drives on at `speed` [m/s] until it stands."""
    return abs(speed) * REACTION_S + speed * speed / (2 * BRAKING_M_S2)


def _slowing(gap: float, speed: float) -> float:
    """The speed [m/s], in steps, from which the robot can slow down to `speed` before a zone `gap` [m] away."""
    way = max(0.0, gap - SLOW_MARGIN_M) + stopping_way(speed)  # in which the fastest could stop
    fastest = BRAKING_M_S2 * (math.sqrt(REACTION_S**2 + 2 * way / BRAKING_M_S2) - REACTION_S)
    return max(speed, math.floor(fastest / CAP_STEP_M_S) * CAP_STEP_M_S)


def enclosed_area(points: Array) -> float:
    """The area [m²] within a ring of corners (N, 2) [m]; what it goes round twice counts twice."""
    x, y = (points - points.mean(0)).T
    return 0.5 * abs(float(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))))


def crosses_itself(points: Array) -> bool:
    """Return whether two sides of a ring of corners (N, 2) cross, or it goes round twice; sides may touch.

    Within such a ring some floor would belong to no side of it.
    """
    begins, ends = points, np.roll(points, -1, axis=0)
    along = ends - begins

    def side(corners: Array) -> Array:
        """On which side (N, N) of the line through each side, a row, each corner lies."""
        away = corners[None] - begins[:, None]
        return np.sign(np.round(along[:, None, 0] * away[..., 1] - along[:, None, 1] * away[..., 0], 9))

    parted = side(begins) * side(ends) < 0
    hull = cv2.convexHull(points.astype(np.float32)).reshape(-1, 2).astype(float)
    return bool((parted & parted.T).any()) or enclosed_area(points) > MAX_RING_SHARE * enclosed_area(hull)


def cells_in(points: Array, grid: OccupancyGrid) -> Array:
    """Mask (rows, columns) of the cells of a grid that a polygon (N, 2) [m], world, touches."""
    mask = np.zeros(grid.log_odds.shape, np.uint8)
    corners = np.rint((points - grid.origin) / grid.resolution - 0.5).astype(np.int32)
    cv2.fillPoly(mask, [corners.reshape(-1, 1, 2)], 1)
    return mask.astype(bool)
