"""The wall on the right: what of the newest scans belongs to it, and the line that keeps its distance to it.

A ball a little larger than the distance rolls along what was seen, with that on its right: the line is where its
centre goes, moved back by what it is larger. So the line turns in inner corners, goes round outer ones, and does
not enter what is narrower than the ball; openings in the wall up to `gap` wide are passed by as if they were wall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from core.geometry import Pose
from core.message import Array, message
from core.setting import Meta, Section

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix


def rolled(here: Array, contact: Array, wall: Array, radius: tuple[float, float], steps: tuple[float, int]) -> Array:
    """From a contact (2,) [m] on along the wall (C, 2) [m] → the line (P, 2) [m].

    `here` (2,) gives the side of the contact; `radius` [m]: of the line, and what the ball is larger; `steps`: how
    long one is [m], and how many.
    """
    size = sum(radius)
    away = here - contact
    place, out = contact + size * away / max(float(np.hypot(*away)), 1e-6), away
    line: list[Array] = []
    for _ in range(steps[1]):
        for _ in range(3):  # pushed out by one point, it may touch another
            place, out = _touching(place, wall, size)
        line.append(place - radius[1] * out)
        place = place + steps[0] * np.array([out[1], -out[0]])
    return np.array(line)


def _touching(place: Array, wall: Array, radius: float) -> tuple[Array, Array]:
    """A ball's centre (2,) [m] → the same so that it touches the nearest point; the direction (2,) away from that."""
    gaps = np.hypot(*(wall - place).T)
    nearest = int(gaps.argmin())
    out = (place - wall[nearest]) / max(float(gaps[nearest]), 1e-6)
    return wall[nearest] + radius * out, out


NOTHING = np.empty((0, 2))
MIN_PLACE_GAP_M = 0.5  # between places at the walls that can be gone to
SECTOR_RAD = math.radians(2.0)  # of the sight, in which the newest scan replaces what was remembered
NEAR_END, WALL_AT_END = 0.35, 0.2  # [m] around the end of an opening, and to where its wall is seen there at least
RIGHT_SIDE_RAD = (math.radians(-170.0), math.radians(-5.0))  # bearings that count as the right-hand side


@dataclass(frozen=True)
class WallSettings(Section):
    """Criteria for a wall, and how far ahead it is followed.

    Watch:
        gap: doors that are entered (then raise it)
        seek: walls refused as too far (then raise it)
        lost_after: commands given up at a corner (then raise it)
    """

    cell: float = 0.03  # [m] points nearer together than this are averaged
    sight: float = 2.5  # [m] distance up to which points are used while following
    link: float = 0.65  # [m] what stands nearer to the wall than this belongs to it: no way leads in between
    aslant: float = 0.35  # [rad] angle to the wall's direction at which the far side of an opening may lie
    deep: float = 0.4  # [m] depth of an opening, at least: less is a recess, or the shadow of something
    smooth: float = 0.07  # [m] distance around a point over which the wall is averaged
    larger: float = 0.05  # [m] excess of the ball's radius over the distance to keep
    horizon: float = 1.0  # [m] length of the line ahead
    stride: float = 0.02  # [m] distance between the points of the line
    memory: float = 30.0  # [s] time for which what is out of sight counts
    least: float = 0.5  # [m] extent from which something is a wall at first: a person's legs are none
    near: float = 0.3  # [m] excess over the distance to keep to follow at once
    gap: Annotated[
        float, Meta("m", 0, 3, "width of openings that are passed by, at most", common=True, live=True)
    ] = 1.1
    seek: Annotated[
        float, Meta("m", 0.5, 20, "distance from which the robot drives to a wall", common=True, live=True)
    ] = 5.0
    lost_after: Annotated[float, Meta("s", 0.3, 30, "time without a wall until the command gives up")] = 2.0


@message
class WallLine:
    """The line to drive along a wall."""

    path: Array  # (P, 2) [m], world
    contact: Array  # (2,) [m], world: the nearest point of the wall
    gap: float | None  # [m] width of an opening that the line passes by, None: there is none


class RightWall:
    """Gathers what was seen of the wall, newest first, and knows which part of it is being followed."""

    def __init__(self, settings: WallSettings) -> None:
        self._settings = settings
        self._cells = NOTHING  # (C, 2) [m], world: seen now
        self._past = np.empty((0, 3))  # x, y [m], world, until [s]: out of sight
        self._bridges: list[tuple[Array, Array, float]] = []  # from, to [m], world, until [s]
        self._contact: Array | None = None

    def see(self, pose: Pose, points: Array, stamp: float) -> None:
        """Take in a scan (M, 2) [m], robot frame."""
        settings = self._settings
        until = np.full((len(self._cells), 1), stamp + settings.memory)
        past = np.vstack((np.hstack((self._cells, until)), self._past))
        everything = _averaged(pose.apply(points), settings.cell)
        self._cells = everything[np.hypot(*(everything - (pose.x, pose.y)).T) < settings.sight]
        seen = np.unique(_sectors(points))
        local = pose.inverse().apply(past[:, :2])
        kept = ~np.isin(_sectors(local), seen) & (past[:, 2] > stamp) & (np.hypot(*local.T) < settings.sight)
        self._past = past[kept]
        self._bridges = [
            (a, b, end)
            for a, b, end in self._bridges
            if end > stamp and pose.distance_to(*(0.5 * (a + b))) < settings.sight
        ]
        for a, b in _openings(pose, np.vstack((everything, self._past[:, :2])), settings):
            if all(math.dist(b, known) > 0.3 for _, known, _ in self._bridges):
                self._bridges.append((a, b, stamp + settings.memory))

    def line(self, pose: Pose, distance: float) -> WallLine | None:
        """The line `distance` [m] from the wall from where the robot is, or None where there is no wall."""
        cells = np.vstack((self._cells, self._past[:, :2], *(_between(a, b) for a, b, _ in self._bridges)))
        wall = self._followed(pose, cells)
        if wall is None or self._contact is None:
            return None
        settings = self._settings
        path = rolled(
            np.array([pose.x, pose.y]),
            self._contact,
            wall,
            (distance, settings.larger),
            (settings.stride, math.ceil(settings.horizon / settings.stride)),
        )
        passing = [
            math.dist(a, b) for a, b, _ in self._bridges if np.hypot(*(path - 0.5 * (a + b)).T).min() < 2 * distance
        ]
        return WallLine(path=path, contact=self._contact, gap=max(passing, default=None))

    def _followed(self, pose: Pose, cells: Array) -> Array | None:
        """The cells (C, 2) [m] of the wall that is being followed; notes where it is nearest."""
        if not len(cells):
            return None
        away = np.hypot(*(cells - (pose.x, pose.y)).T)
        if self._contact is None:
            begins = _on_the_right(pose, cells) & _wide(cells, self._settings.least)
            if not begins.any():
                return None
            start = int(np.where(begins, away, np.inf).argmin())
        else:
            start = int(np.hypot(*(cells - self._contact).T).argmin())
            if math.dist(cells[start], self._contact) > self._settings.link:
                return None
        along = _lengths(cells, start, self._settings.link)
        self._contact = cells[int(np.where(along < 1.5, away, np.inf).argmin())]
        return _smoothed(cells[along < self._settings.sight + 1.0], self._settings.smooth)


def walls_on_the_right(pose: Pose, points: Array, settings: WallSettings) -> Array:
    """Scan (M, 2) [m], robot frame → points (K, 2) [m], world, of walls on the right, nearest first, spread out."""
    cells = _averaged(pose.apply(points[np.hypot(*points.T) < settings.seek]), settings.cell)
    if not len(cells):
        return NOTHING
    rest = cells[_on_the_right(pose, cells) & _wide(cells, settings.least)]
    rest = rest[np.hypot(*(rest - (pose.x, pose.y)).T).argsort(kind="stable")]
    spread = []
    while len(rest):
        spread.append(rest[0])
        rest = rest[np.hypot(*(rest - rest[0]).T) >= MIN_PLACE_GAP_M]
    return np.array(spread).reshape(-1, 2)


def _on_the_right(pose: Pose, cells: Array) -> Array:
    local = pose.inverse().apply(cells)
    bearing = np.arctan2(local[:, 1], local[:, 0])
    return (bearing > RIGHT_SIDE_RAD[0]) & (bearing < RIGHT_SIDE_RAD[1])


def _wide(cells: Array, least: float) -> Array:
    """(C,) whether each cell belongs to something of at least that extent [m]: a table's leg is no wall."""
    from scipy.sparse.csgraph import connected_components  # late, as in the planner

    count, part = connected_components(_graph(cells, 0.15), directed=False)
    wide = np.array([float(np.hypot(*np.ptp(cells[part == one], axis=0))) for one in range(count)])
    return wide[part] >= least


def _averaged(points: Array, cell: float) -> Array:
    """Points (M, 2) [m] → the mean (C, 2) of those in each square of a lattice."""
    if not len(points):
        return NOTHING
    _, which, count = np.unique(np.floor(points / cell), axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    return np.column_stack([np.bincount(which, points[:, axis]) / count for axis in (0, 1)])


def _smoothed(cells: Array, around: float) -> Array:
    """Every point (C, 2) [m] → the mean of those near it: a line of noisy points is farther than its nearest one."""
    near = np.hypot(*(cells[:, None] - cells[None]).transpose(2, 0, 1)) <= around
    return near @ cells / near.sum(axis=1, keepdims=True)


def _sectors(points: Array) -> Array:
    return np.floor(np.arctan2(points[:, 1], points[:, 0]) / SECTOR_RAD)


def _graph(cells: Array, link: float) -> coo_matrix:
    apart = np.hypot(*(cells[:, None] - cells[None]).transpose(2, 0, 1))
    rows, columns = np.nonzero((apart < link) & (apart > 0))
    from scipy.sparse import coo_matrix

    return coo_matrix((apart[rows, columns], (rows, columns)), shape=apart.shape)


def _lengths(cells: Array, start: int, link: float) -> Array:
    """(C,) [m]: how far each cell is along the wall from one of them; inf: it is another wall."""
    from scipy.sparse.csgraph import dijkstra

    return dijkstra(_graph(cells, link).tocsr(), directed=False, indices=start)


def _between(a: Array, b: Array) -> Array:
    return a + np.linspace(0, 1, 2 + math.ceil(math.dist(a, b) / 0.03))[:, None] * (b - a)


def _goes_on(cells: Array, end: Array) -> bool:
    """Return whether a wall goes on at its end (2,) [m]; a table's leg does not."""
    gone = np.hypot(*(cells - end).T)
    return float(gone[gone < NEAR_END].max()) >= WALL_AT_END


def _openings(pose: Pose, cells: Array, settings: WallSettings) -> list[tuple[Array, Array]]:
    """Find openings of at most `gap` in the wall on the right: the two ends of each (2,) [m]."""
    local = pose.inverse().apply(cells)
    bearing, away = np.arctan2(local[:, 1], local[:, 0]), np.hypot(*local.T)
    order = np.argsort(bearing)
    order = order[bearing[order] < math.radians(60.0)]
    cells, away, bearing = cells[order], away[order], bearing[order]
    steps = np.hypot(*np.diff(cells, axis=0).T)
    found: list[tuple[Array, Array]] = []
    for last in np.flatnonzero((steps > 0.2) & (bearing[:-1] < 0) & (away[:-1] < settings.sight - 0.5)):
        end = cells[last]
        before = cells[: last + 1]
        wall = before[np.hypot(*(before - end).T) < NEAR_END]
        if len(wall) < 5 or not _goes_on(wall, end):
            continue
        along = (end - wall.mean(axis=0)) / math.dist(end, wall.mean(axis=0))
        beyond = cells[last + 1 :]
        across = beyond - end
        wide = np.hypot(*across.T)
        aside = np.arctan2(along[0] * across[:, 1] - along[1] * across[:, 0], across @ along)
        good = (wide > 0.2) & (wide < settings.gap) & (np.abs(aside) < settings.aslant)
        leftmost = np.flatnonzero(good)[np.argsort(-aside[good], kind="stable")]
        far = next((int(one) for one in leftmost if _goes_on(beyond, beyond[one])), None)
        if far is None:
            continue
        side = across[far] / wide[far]
        depths = across[:far] @ (side[1], -side[0])
        if not len(depths) or float(depths.max()) > settings.deep:
            found.append((end, beyond[far]))
    return found
