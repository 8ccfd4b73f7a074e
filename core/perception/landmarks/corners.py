"""Corners in a laser scan: where two fitted lines meet (section 4.1)."""

import itertools
import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from core.message import Array, message
from core.perception.landmarks.lines import Line, LineSettings, Sweep, find_lines
from core.sensors import Laser, Scan
from core.setting import Meta

CornerKind = Literal["convex", "concave"]


@message
class Corner:
    """A corner of the room in the robot frame."""

    position: Array  # (2,) [m]
    covariance: Array  # (2, 2) [m²]
    kind: CornerKind  # convex: it points at the robot, as a pillar's does
    opening: float  # [rad] robot frame: bisector of the two walls, on the robot's side
    sector: float  # [rad] half the angle around the opening from where both walls are seen


@dataclass(frozen=True)
class CornerSettings(LineSettings):
    """Criteria of a corner.

    Watch:
        angle: corners in the scene; raise it where they come and go at bends of a wall
    """

    apart: int = 12  # [beams] gap between the two lines of a corner, at most
    reach: float = 0.25  # [m] distance from either line's end to the corner, at most
    trim: int = 1  # samples left out on both sides of the corner
    worst: float = 0.1  # [m] sd of a corner, at most
    agree: float = 0.03  # [m] difference of the two fits of a corner, at most, beyond 3 sd
    angle: Annotated[float, Meta("rad", 0.05, 1.5, "angle between the two lines, at least")] = math.radians(35)


def find_corners(
    scan: Scan, laser: Laser, points: Array, beams: Array, settings: CornerSettings | None = None
) -> tuple[Corner, ...]:
    """De-skewed points (M, 2) [m] of a scan and their beams (M,) → corners, robot frame, right to left."""
    settings = settings or CornerSettings()
    viewpoint = np.array([laser.mounting.x, laser.mounting.y])
    sweep = Sweep(points - viewpoint, beams, scan.angle_step, settings)
    lines = find_lines(sweep)
    corners: list[Corner] = []
    for before, after in itertools.pairwise(lines):
        near = beams[after.first] - beams[before.last] <= settings.apart + 1
        place = meet(before, after, settings) if near else None
        if place is not None:
            corner = _refine(sweep, before, after, place, viewpoint, settings)
            corners += [corner] if corner is not None else []
    return tuple(corners)


def meet(before: Line, after: Line, settings: CornerSettings) -> Array | None:
    """Two neighbouring lines → where they meet (2,); None if that is no corner."""
    cross = before.ux * after.uy - before.uy * after.ux
    if abs(cross) < math.sin(settings.angle):
        return None
    dx, dy = after.x - before.x, after.y - before.y
    along_before = (dx * after.uy - dy * after.ux) / cross
    along_after = (dx * before.uy - dy * before.ux) / cross
    if abs(along_before - before.end) > settings.reach or abs(along_after - after.begin) > settings.reach:
        return None
    return np.array([before.x + along_before * before.ux, before.y + along_before * before.uy])


def _refine(
    sweep: Sweep, before: Line, after: Line, place: Array, viewpoint: Array, settings: CornerSettings
) -> Corner | None:
    """A corner at about `place` → the corner, each wall fitted to the samples on its side of the corner's bearing."""
    x, y = place.tolist()
    samples = sweep.points[before.first : after.last + 1]
    cut = before.first + int(np.count_nonzero(x * samples[:, 1] < y * samples[:, 0]))
    first = sweep.fit_ranges(before.first, cut - 1 - settings.trim)
    second = sweep.fit_ranges(cut + settings.trim, after.last)
    if first is None or second is None:
        return None
    walls = np.array([first[0], second[0]])
    crossing = abs(float(np.linalg.det(walls))) / float(np.prod(np.linalg.norm(walls, axis=1)))
    if crossing < math.sin(settings.angle):
        return None
    inverse = np.linalg.inv(walls)
    corner = inverse @ np.ones(2)
    spread = np.diag([corner @ first[1] @ corner, corner @ second[1] @ corner])
    covariance = inverse @ spread @ inverse.T
    doubt = math.sqrt(float(np.trace(covariance)))
    if doubt > settings.worst or math.hypot(*(corner - place).tolist()) > settings.agree + 3 * doubt:
        return None
    x, y = corner.tolist()
    wall_x, wall_y = after.ux - before.ux, after.uy - before.uy
    convex = wall_x * x + wall_y * y > 0
    between = math.acos(max(-1.0, min(1.0, -before.ux * after.ux - before.uy * after.uy)))
    return Corner(
        position=corner + viewpoint,
        covariance=covariance,
        kind="convex" if convex else "concave",
        opening=math.atan2(-wall_y, -wall_x) if convex else math.atan2(wall_y, wall_x),
        sector=0.5 * (math.pi - between if convex else between),
    )
