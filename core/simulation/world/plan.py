"""A floor plan with everything in it. World frame: where the robot wakes, x its first heading.

Its walls lie between rectangles of free and solid floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.simulation.world.held_board import HeldBoard
from core.simulation.world.objects import Solid, Thing
from core.simulation.world.ray_casting import Surfaces, distances

BODY_HEIGHT_M = 0.2  # what hangs higher than the robot is not in its way


@dataclass(frozen=True)
class Rect:
    """A rectangle along the axes."""

    x0: float  # [m]
    y0: float  # [m]
    x1: float  # [m]
    y1: float  # [m]

    def contains(self, x: float, y: float) -> bool:
        """Return whether (x, y) lies inside or on the border."""
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1


def outline(free: Sequence[Rect], solid: Sequence[Rect] = ()) -> Array:
    """Free floor (the union of `free` without `solid`) → its walls (W, 4): x0 y0 x1 y1 [m], free floor on the left.

    Collinear neighbours come as one wall, so every wall ends at a corner.
    """
    rects = [*free, *solid]
    xs = np.unique([edge for r in rects for edge in (r.x0, r.x1)])
    ys = np.unique([edge for r in rects for edge in (r.y0, r.y1)])
    cells = np.zeros((len(xs) + 1, len(ys) + 1), dtype=np.int8)  # with a solid margin all around
    for r in free:
        cells[_span(xs, r.x0, r.x1), _span(ys, r.y0, r.y1)] = 1
    for r in solid:
        cells[_span(xs, r.x0, r.x1), _span(ys, r.y0, r.y1)] = 0
    walls: list[tuple[float, float, float, float]] = []
    for step, x in zip(np.diff(cells, axis=0), xs, strict=True):  # walls across x, looking along y
        for low, high, side in _runs(step[1:-1]):
            a, b = ys[low], ys[high]
            walls.append((x, b, x, a) if side > 0 else (x, a, x, b))
    for step, y in zip(np.diff(cells, axis=1).T, ys, strict=True):
        for low, high, side in _runs(step[1:-1]):
            a, b = xs[low], xs[high]
            walls.append((a, y, b, y) if side > 0 else (b, y, a, y))
    return np.array(walls)


def _span(edges: Array, low: float, high: float) -> slice:
    return slice(int(np.searchsorted(edges, low)) + 1, int(np.searchsorted(edges, high)) + 1)


def _runs(sides: Array) -> list[tuple[int, int, int]]:
    """Find runs (first, past the last, side) where a line of cells goes from solid to free (+1) or back (-1)."""
    bounds = np.flatnonzero(np.diff(sides, prepend=0, append=0))
    return [(int(low), int(high), int(sides[low])) for low, high in pairwise(bounds) if sides[low] != 0]


@dataclass(frozen=True)
class Dressing:
    """Something flat on the wall nearest to (x, y): it is seen, but not in the way."""

    what: str  # "door" | "poster" | "board" | "window" | "sign"
    x: float  # [m] of its middle
    y: float  # [m]
    width: float  # [m]
    bottom: float  # [m]
    top: float  # [m]


@dataclass(frozen=True)
class Zone:
    """Walls whose middle lies in `area` are painted so."""

    area: Rect
    paint: str


@message
class World:
    """Walls, what hangs on them, and what stands between them. Changing it makes a new one."""

    name: str
    walls: Array  # (W, 4): x0 y0 x1 y1 [m], free floor on the left
    height: float = 2.7  # [m] of the ceiling
    zones: tuple[Zone, ...] = ()  # the last one that fits counts
    dressings: tuple[Dressing, ...] = ()
    things: tuple[Thing, ...] = ()
    board: HeldBoard | None = None
    glass: tuple[Rect, ...] = ()  # walls whose middle lies within let the laser through

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """The parts of all things."""
        return tuple(solid for thing in self.things for solid in thing.solids)

    @cached_property
    def bounds(self) -> Rect:
        """The smallest rectangle around all walls."""
        xs, ys = self.walls[:, 0::2], self.walls[:, 1::2]
        return Rect(float(xs.min()), float(ys.min()), float(xs.max()), float(ys.max()))

    def surfaces(self, height: float) -> Surfaces:
        """Return the surfaces that a ray at `height` [m] can hit."""
        solids = [solid for solid in self.solids if solid.stands_at(height)]
        return _surfaces(self.walls, solids, None if self.board is None else self.board.cut(height))

    def laser_surfaces(self, height: float) -> Surfaces:
        """Return the surfaces that a laser at `height` [m] sees: all but glass, behind which is nothing."""
        seen = self.surfaces(height)
        if not self.glass:
            return seen
        middle = 0.5 * (self.walls[:, :2] + self.walls[:, 2:])
        clear = np.array([any(area.contains(x, y) for area in self.glass) for x, y in middle.tolist()])
        return Surfaces(faces=np.vstack((self.walls[~clear], seen.faces[len(self.walls) :])), posts=seen.posts)

    @cached_property
    def obstacles(self) -> Surfaces:
        """The surfaces that the robot's body can run into."""
        solids = [solid for solid in self.solids if solid.bottom < BODY_HEIGHT_M]
        return _surfaces(self.walls, solids, None if self.board is None else self.board.footprint(BODY_HEIGHT_M))

    def distance(self, x: float, y: float) -> float:
        """Distance [m] from (x, y) to the nearest obstacle's surface."""
        return float(distances(np.array([x, y]), self.obstacles).min())

    def inside(self, x: float, y: float) -> bool:
        """Return whether (x, y) is free floor: within the walls and outside every thing."""
        blocks = (s for s in self.solids if s.bottom < BODY_HEIGHT_M)
        return _winding(self.walls, x, y) != 0 and not any(_covers(solid, x, y) for solid in blocks)

    def clearance(self, x: float, y: float) -> float:
        """Distance [m] from (x, y) to the nearest obstacle; negative off the free floor."""
        distance = abs(self.distance(x, y))
        return distance if self.inside(x, y) else -distance

    def free(self, x: float, y: float, radius: float) -> bool:
        """Return whether a round body of `radius` [m] fits at (x, y)."""
        return self.clearance(x, y) >= radius

    def upright(self, x: float, y: float, radius: float, height: float) -> bool:
        """Return whether a person of that radius and height [m] can stand at (x, y), clear of things and tables."""
        solids = [solid for solid in self.solids if solid.bottom < height]
        gap = float(distances(np.array([x, y]), _surfaces(self.walls, solids, None)).min())
        return gap >= radius and _winding(self.walls, x, y) != 0 and not any(_covers(s, x, y) for s in solids)

    def open_air(self, points: Array) -> bool:
        """Return whether points (K, 3) [m] lie within the walls and outside every thing."""
        reach = float(np.hypot(*(points[:, :2] - points[0, :2]).T).max())
        near = [s for s in self.solids if _gap(s, points[0, 0], points[0, 1]) < reach]
        for x, y, z in points.tolist():
            if _winding(self.walls, x, y) == 0 or any(s.stands_at(z) and _covers(s, x, y) for s in near):
                return False
        return True

    def with_thing(self, thing: Thing) -> World:
        """The same world with `thing` in it; one of the same id is moved."""
        return replace(self, things=(*(t for t in self.things if t.id != thing.id), thing))

    def with_board(self, board: HeldBoard | None) -> World:
        """The same world with this board in it, or with none."""
        return replace(self, board=board)

    def without(self, name: str) -> World:
        """The same world without what was placed as `name`; BadInput when there is no such thing."""
        if not any(t.id == name and not t.fixed for t in self.things):
            placed = ", ".join(sorted(t.id for t in self.things if not t.fixed)) or "nothing"
            raise BadInput(f"Nothing of that id was placed here; placed so far: {placed}.")
        return replace(self, things=tuple(t for t in self.things if t.id != name))


def _surfaces(walls: Array, solids: list[Solid], board: Array | None) -> Surfaces:
    posts = [(*solid.centre, solid.radius) for solid in solids if solid.radius > 0]
    faces = np.vstack(
        [walls, *(solid.faces for solid in solids if solid.radius == 0), *(() if board is None else (board,))]
    )
    return Surfaces(faces=faces, posts=np.array(posts).reshape(-1, 3))


def _winding(faces: Array, x: float, y: float) -> int:
    x0, y0, x1, y1 = faces.T
    left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
    up = (y0 <= y) & (y1 > y) & (left > 0)
    down = (y0 > y) & (y1 <= y) & (left < 0)
    return int(up.sum()) - int(down.sum())


def _gap(solid: Solid, x: float, y: float) -> float:
    """Distance [m] from (x, y) to the circle around a solid."""
    extent = solid.radius or float(np.hypot(*(solid.corners - solid.centre).T).max())
    return float(np.hypot(*(solid.centre - (x, y)))) - extent


def _covers(solid: Solid, x: float, y: float) -> bool:
    if solid.radius > 0:
        return bool(np.hypot(*(solid.centre - (x, y))) <= solid.radius)
    return _winding(solid.faces, x, y) != 0
