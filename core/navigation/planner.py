"""The shortest comfortable way through the map: Dijkstra over 1 + 3·exp(-4d), d = free space around the body."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from core.errors import Refused
from core.geometry import Pose
from core.message import Array
from core.navigation.costmap import Costmap, survey
from core.sentences import Statement
from core.setting import Meta, Section
from core.slam.map.occupancy import OccupancyGrid


@dataclass(frozen=True)
class PlannerSettings(Section):
    """Costs and clearances of a path.

    Watch:
        guard: narrow doors that are refused, and halts by the guard (then raise it)
        comfort: distance of the path from walls
        unknown: paths through what was never seen (then raise it)
        reach: goals refused outside the map
    """

    stride: float = 0.1  # [m] spacing of the searched lattice; narrow gaps are searched on the map's own
    spacing: float = 0.05  # [m] distance between the points of a path
    tight: float = 6.0  # factor on the cost where there is less
    near: float = 3.0  # weight of exp(-falloff · d) in the cost
    falloff: float = 4.0  # [1/m] decay of that cost with the free space d
    occupied: float = 0.6  # log odds from which a cell is a wall
    margin: float = 3.0  # [m] distance beyond the straight line that is searched first
    escape: float = 0.3  # [m] distance around the robot in which it may leave a tight place
    wider: float = 0.6  # [m] further distance at which the robot stops where nearer there is no room
    guard: Annotated[
        float, Meta("m", 0.03, 0.5, "free space below which nothing is planned: the gate's guard stops at 0.03")
    ] = 0.035
    comfort: Annotated[float, Meta("m", 0.03, 1, "free space that is kept wherever possible", common=True)] = 0.06
    unknown: Annotated[float, Meta("", 1, 100, "factor on the cost where nothing has been seen yet")] = 2.0
    reach: Annotated[float, Meta("m", 1, 20, "distance of a goal outside the known map, at most", common=True)] = 10.0


PERSON_RADIUS_M = 0.35  # around a place that a person there may take up


def plan(
    grid: OccupancyGrid, seen: Array, start: Pose, goal: tuple[float, float], radius: float, settings: PlannerSettings
) -> Array:
    """Way from the robot to a goal: points (P, 2) [m], world, the first at the robot, the last at the goal.

    `seen` (M, 2) [m], world: the newest scan; `radius` [m] of the round footprint. Raises Refused with a sentence
    when the goal is too far, in a wall, or walled off.
    """
    ends = np.array([[start.x, start.y], goal])
    near = _window(grid, seen, ends, settings.margin, settings)
    check_goal(near, start, goal, radius, settings)
    return _find_way(grid, seen, near, ends[0], ends[1:], radius, settings)


def plan_beside(
    grid: OccupancyGrid,
    seen: Array,
    start: Pose,
    place: tuple[float, float],
    keep: float,
    radius: float,
    settings: PlannerSettings,
) -> Array:
    """Way (P, 2) [m], world, to where the robot can stand `keep` [m] from a place with nothing in between.

    The place itself may be taken by a person. Where the ring of that distance is not free, a wider one is
    tried. Raises Refused with a sentence when the place is too far away or there is nowhere to stand.
    """
    ends = np.array([[start.x, start.y], place])
    near = _window(grid, seen, ends, settings.margin + keep, settings)
    check_reach(near, start, place, settings)
    stands = stands_around(near, place, keep, radius + settings.guard, settings.wider)
    if not len(stands):
        raise Refused(Statement("way.no_place_to_stand", keep=f"{keep:g}"))
    return _find_way(grid, seen, near, ends[0], stands, radius, settings)


def stands_around(terrain: Costmap, place: tuple[float, float], keep: float, room: float, wider: float) -> Array:
    """Find places (K, 2) [m] where a body that needs `room` [m] can stand `keep` [m] from a place and see it.

    Where nothing is free at that distance, the next one that is free counts, up to `wider` [m] more.
    """
    around = np.linspace(-math.pi, math.pi, 48, endpoint=False)
    rays = np.column_stack((np.cos(around), np.sin(around)))
    for more in np.arange(0.0, wider + 1e-9, 0.1):
        stands = np.array(place) + (keep + more) * rays
        free = terrain.clearance_at(stands) >= room
        shares = np.linspace(min(1.0, PERSON_RADIUS_M / (keep + more)), 1.0, 12)[None, :, None]
        between = np.array(place) + (stands - place)[:, None] * shares
        seen = (terrain.clearance_at(between.reshape(-1, 2)) > 0).reshape(len(stands), -1).all(axis=1)
        if (free & seen).any():
            return stands[free & seen]
    return np.empty((0, 2))


def _window(grid: OccupancyGrid, seen: Array, ends: Array, margin: float, settings: PlannerSettings) -> Costmap:
    """The terrain around places (N, 2) [m]."""
    return survey(grid, seen, ends.min(axis=0) - margin, ends.max(axis=0) + margin, settings.occupied)


def _find_way(
    grid: OccupancyGrid,
    seen: Array,
    near: Costmap,
    start: Array,
    goals: Array,
    radius: float,
    settings: PlannerSettings,
) -> Array:
    """Way from `start` (2,) to the cheapest of `goals` (G, 2) [m], in the window or in the whole map."""
    way = _search(near, start, goals, radius, settings.stride, settings)
    if way is not None:
        return _resample(_pull_tight(near, way, radius, settings), settings.spacing)
    corners = np.vstack(
        (start, goals, grid.origin, grid.origin + np.array(grid.log_odds.shape[::-1]) * grid.resolution)
    )
    whole = _window(grid, seen, corners, 0.0, settings)
    for stride in (settings.stride, grid.resolution):
        way = _search(whole, start, goals, radius, stride, settings)
        if way is not None:
            return _resample(_pull_tight(whole, way, radius, settings), settings.spacing)
    raise Refused(Statement("way.no_way"))


def check_reach(terrain: Costmap, start: Pose, goal: tuple[float, float], settings: PlannerSettings) -> None:
    """Raises Refused for what lies far away and outside the map."""
    if start.distance_to(*goal) > settings.reach and not terrain.known_at(*goal):
        raise Refused(Statement("way.too_far", far=f"{start.distance_to(*goal):.1f}", reach=f"{settings.reach:g}"))


def check_goal(
    terrain: Costmap, start: Pose, goal: tuple[float, float], radius: float, settings: PlannerSettings
) -> None:
    """Raises Refused when the robot cannot stand at the goal, naming the nearest place where it can."""
    check_reach(terrain, start, goal, settings)
    needed = radius + settings.guard
    room = float(terrain.clearance_at(np.array([goal]))[0])
    if room >= needed:
        return
    code = "way.in_a_wall" if room < radius else "way.near_a_wall"
    values = {"needed": f"{needed:.2f}"} if room < radius else {"needed": f"{needed:.2f}", "room": f"{room:.2f}"}
    rows, columns = np.nonzero((terrain.clearance >= needed + 0.05) & terrain.known)
    free = terrain.places(rows, columns)
    if not len(free):
        raise Refused(Statement(f"{code}_everywhere", **values))
    x, y = free[np.hypot(*(free - goal).T).argmin()]
    raise Refused(Statement(code, x=f"{x:.2f}", y=f"{y:.2f}", **values))


def is_free(terrain: Costmap, path: Array, radius: float, settings: PlannerSettings) -> bool:
    """Return whether a path (P, 2) [m], world, still leads through free space."""
    at_robot = np.hypot(*(path - path[0]).T) < settings.escape
    return bool(((terrain.clearance_at(path) >= radius + settings.guard) | at_robot).all())


def _cost(terrain: Costmap, clearance: Array, known: Array, radius: float, settings: PlannerSettings) -> Array:
    """Return the cost of a metre in cells of that clearance [m]."""
    space = np.maximum(clearance - radius, 0.0)
    cost = 1 + settings.near * np.exp(-settings.falloff * space)
    cost = np.where(space < settings.comfort + 0.5 * terrain.resolution, cost * settings.tight, cost)
    return np.where(known, cost, cost * settings.unknown)


def _search(
    terrain: Costmap, start: Array, goals: Array, radius: float, stride: float, settings: PlannerSettings
) -> Array | None:
    """Dijkstra from the goals (G, 2) on a lattice of that stride [m]: points (P, 2) [m] to one of them, or None."""
    every = max(1, round(stride / terrain.resolution))
    clearance, known = terrain.clearance[::every, ::every], terrain.known[::every, ::every]
    rows, columns = np.indices(clearance.shape)
    places = terrain.places(rows.ravel() * every, columns.ravel() * every).reshape(*clearance.shape, 2)
    from_robot = np.hypot(*np.moveaxis(places - start, -1, 0))
    open_ = (clearance >= radius + settings.guard) | ((from_robot < settings.escape) & (clearance > 0.5 * radius))
    cost = _cost(terrain, clearance, known, radius, settings)
    node = np.full(clearance.shape, -1)
    node[open_] = np.arange(np.count_nonzero(open_))
    if not open_.any():
        return None
    from scipy.spatial import KDTree  # as in _predecessors

    gaps, nodes = (np.asarray(each) for each in KDTree(places[open_]).query(np.vstack((start, goals))))
    near = gaps <= 2 * stride
    if not near[0] or not near[1:].any():
        return None
    ends = {int(one): goal for one, goal, found in zip(nodes[:0:-1], goals[::-1], near[:0:-1], strict=True) if found}
    before = _predecessors(node, cost, list(ends))
    order = [int(nodes[0])]
    while before[order[-1]] >= 0:
        order.append(int(before[order[-1]]))
    if order[-1] not in ends:
        return None
    return np.vstack((start, places[open_][order], ends[order[-1]]))


def _predecessors(node: Array, cost: Array, goals: list[int]) -> Array:
    """(N,): the next node on the way to the nearest goal, negative where there is none."""
    froms: list[Array] = []
    tos: list[Array] = []
    prices: list[Array] = []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = (slice(None, -1 if down else None), slice(1, None) if right < 0 else slice(None, -1 if right else None))
        b = (slice(down, None), slice(None, -1) if right < 0 else slice(right, None))
        both = (node[a] >= 0) & (node[b] >= 0)
        froms.append(node[a][both])
        tos.append(node[b][both])
        prices.append(0.5 * math.hypot(down, right) * (cost[a] + cost[b])[both])
    count = int(node.max()) + 1
    from scipy.sparse import csr_matrix  # the pilot has them; readers of words do without these 36 MB
    from scipy.sparse.csgraph import dijkstra

    edges = csr_matrix((np.concatenate(prices), (np.concatenate(froms), np.concatenate(tos))), shape=(count, count))
    return dijkstra(edges, directed=False, indices=goals, return_predecessors=True, min_only=True)[1]


def _pull_tight(terrain: Costmap, way: Array, radius: float, settings: PlannerSettings) -> Array:
    """Replace stretches of the way (P, 2) by straight lines wherever these cost no more."""
    legs = np.hypot(*np.diff(way, axis=0).T)
    toll = np.concatenate(([0.0], np.cumsum(_price(terrain, way[:-1], way[1:], radius, settings) * legs)))
    kept = [0]
    while kept[-1] < len(way) - 1:
        here = kept[-1]
        ahead = np.arange(here + 1, len(way))
        lines = np.hypot(*(way[ahead] - way[here]).T)
        straight = _price(terrain, np.broadcast_to(way[here], (len(ahead), 2)), way[ahead], radius, settings) * lines
        good = ahead[straight <= (toll[ahead] - toll[here]) * 1.001 + 1e-9]
        kept.append(int(good.max()) if len(good) else here + 1)
    return way[kept]


def _price(terrain: Costmap, starts: Array, ends: Array, radius: float, settings: PlannerSettings) -> Array:
    """Mean cost per metre of straight lines, starts (N, 2) to ends (N, 2) [m] → (N,); inf through walls."""
    longest = float(np.hypot(*(ends - starts).T).max())
    share = np.linspace(0, 1, max(2, math.ceil(longest / terrain.resolution) + 1))
    points = starts[:, None] + (ends - starts)[:, None] * share[None, :, None]
    row, column = terrain.cells(points.reshape(-1, 2))
    clearance, known = terrain.clearance[row, column], terrain.known[row, column]
    cost = np.where(clearance > 0.5 * radius, _cost(terrain, clearance, known, radius, settings), np.inf)
    return cost.reshape(points.shape[:2]).mean(axis=1)


def _resample(way: Array, spacing: float) -> Array:
    """Way (P, 2) [m] → the same way (Q, 2) with points at most `spacing` [m] apart."""
    pieces = [
        np.linspace(a, b, max(2, math.ceil(float(np.hypot(*(b - a))) / spacing) + 1))[:-1] for a, b in pairwise(way)
    ]
    return np.vstack((*pieces, way[-1:]))
