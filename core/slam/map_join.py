"""Two saved maps of one building as one: where one lies in the other, shown before anything is joined, and the join.

Views of the newer map are searched for on the whole older one; each that is found somewhere says where its map would
lie. The answer that most of them share is believed when enough share it and no other comes near. Joined, the two hold
together by links between such views, as by any place that was recognised, and by all views laid on each other.
"""

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from msgspec import structs

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array
from core.sentences import Statement
from core.slam.loop_closure.loop_closer import LoopCloser
from core.slam.map.map_file import MapFacts, SavedClosure, SavedMap, checked
from core.slam.map.map_graph import MapGraph
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map_io import keep, restore
from core.slam.mapper import Mapper
from core.slam.relocalization.global_search import PoseFit, judge, search
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid, thinned
from core.slam.submap_manager import CARRIED, MapperSettings

MAX_SEARCHED_VIEWS, MAX_LINKED_VIEWS = 24, 120
MIN_AGREEING_VIEWS = 4
MIN_AGREEING_SHARE = 0.2  # of the views that were looked for: the maps may have little in common
MAX_RIVAL_SHARE = 0.6  # of the support of the best answer that another one may have
SAME_PLACE_M, SAME_HEADING_RAD = 0.4, math.radians(4.0)  # within which two views agree
MIN_LINK_SCORE, MAX_LINK_CONFLICT = 0.62, 0.08
LINK_SD_M, LINK_SD_RAD = 0.05, math.radians(0.6)
POINT_GRAIN_M, MISS_GRAIN_M = 0.1, 0.3
WALL_LOG_ODDS = 0.6

T = TypeVar("T")


@dataclass(frozen=True)
class ViewLink:
    """A view of the newer map that was found on the older one."""

    view: int
    pose: Pose  # in the world of the older map
    score: float


@dataclass(frozen=True)
class MapMatch:
    """The place of the newer map in the older one, and how sure that is."""

    pose: Pose  # older_from_newer
    agree: int  # views that were searched for and share it
    searched: int
    links: tuple[ViewLink, ...]
    overlap: float  # share of the newer map's walls within the older one's floor plan that lie at a wall there
    conflict: float  # share that lies in the middle of its free floor


def match_maps(older: SavedMap, newer: SavedMap, parts: MapperSettings) -> MapMatch:
    """Find where the newer map lies in the older one. Raises BadInput where nothing is sure enough."""
    pyramid = _finished(SearchPyramid.prepare(grid_of(older, parts)))
    if pyramid is None:
        raise BadInput(Statement("join.too_little"))
    poses, chosen = _poses(newer), _spread(newer.arrays["view_poses"], MAX_SEARCHED_VIEWS)
    views = _scan_views(newer, chosen)
    found = [
        (number, fit)
        for number, view in zip(chosen, views, strict=True)
        for fit in _finished(search(pyramid, view, MIN_LINK_SCORE))
        if fit.conflict <= 2 * MAX_LINK_CONFLICT
    ]
    best, support, rival = _shared(found, poses)
    share = max(MIN_AGREEING_VIEWS, MIN_AGREEING_SHARE * len(chosen))
    if best is None or support < share:
        raise BadInput(Statement("join.nothing_shared"))
    if rival > MAX_RIVAL_SHARE * support:
        raise BadInput(Statement("join.several"))
    rough = _mean(_links(pyramid, newer, poses, best), poses, best)
    links = _links(pyramid, newer, poses, rough)  # with those of the first answer it becomes exact
    if len(links) < MIN_AGREEING_VIEWS:
        raise BadInput(Statement("join.nothing_shared"))
    pose = _mean(links, poses, rough)
    overlap, conflict = _compared(pyramid, grid_of(newer, parts), pose)
    return MapMatch(pose, support, len(chosen), links, overlap, conflict)


def join_maps(older: SavedMap, newer: SavedMap, match: MapMatch, parts: MapperSettings) -> SavedMap:
    """Both maps as one, in the world of the older one, straightened. Raises BadInput where they do not suit.

    A saved map does not hold how its views were laid on each other. That is done again, with the other's views, too:
    else the wheels alone would bend both.
    """
    joined = checked(_together(older, newer, match), "joined")
    graph = MapGraph()
    restore(joined, graph, parts, None)
    closer = LoopCloser(graph, parts.matching, parts.closures)
    closer.settle()
    closer.finish()
    return keep(graph, parts.occupancy.resolution)


def grid_of(saved: SavedMap, parts: MapperSettings) -> OccupancyGrid:
    """The occupancy map of a saved map. Raises BadInput where it does not suit the settings."""
    return Mapper(parts, watched=False, saved=saved).grid


# the search


def _finished(work: Generator[None, None, T]) -> T:
    while True:
        try:
            next(work)
        except StopIteration as over:
            return over.value


def _poses(saved: SavedMap) -> list[Pose]:
    return [Pose(*row) for row in saved.arrays["view_poses"].tolist()]


def _spread(poses: Array, most: int) -> list[int]:
    chosen = [0]
    away = np.hypot(*(poses[:, :2] - poses[0, :2]).T)
    while len(chosen) < min(most, len(poses)) and away.max() > SAME_PLACE_M:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.hypot(*(poses[:, :2] - poses[chosen[-1], :2]).T))
    return chosen


def _scan_views(saved: SavedMap, numbers: Sequence[int]) -> list[ScanView]:
    """Views of a saved map as the search takes them."""
    arrays, ends = saved.arrays, np.cumsum(saved.arrays["view_beams"])
    views: list[ScanView] = []
    for number in numbers:
        part = slice(int(ends[number] - arrays["view_beams"][number]), int(ends[number]))
        beams, hits = arrays["beam_ends"][part].astype(float), arrays["beam_hits"][part].astype(bool)
        known = np.isfinite(beams).all(axis=1)
        views.append(
            ScanView(
                stamp=0.0,
                odometry=Pose(),
                start=arrays["view_eyes"][number],
                points=thinned(beams[known & hits], POINT_GRAIN_M),
                misses=thinned(beams[known & ~hits], MISS_GRAIN_M),
            )
        )
    return views


def _shared(found: Sequence[tuple[int, PoseFit]], poses: Sequence[Pose]) -> tuple[Pose | None, int, int]:
    """The answer that most views share, how many do, and how many share the next one that is another."""
    answers = [fit.pose @ poses[number].inverse() for number, fit in found]
    supports = [len({n for n, fit in found if _is_near(answer @ poses[n], fit.pose)}) for answer in answers]
    merits = [count + fit.score for count, (_, fit) in zip(supports, found, strict=True)]
    if not merits:
        return None, 0, 0
    best = int(np.argmax(merits))
    others = [
        count
        for count, answer, (number, _) in zip(supports, answers, found, strict=True)
        if not _is_near(answer @ poses[number], answers[best] @ poses[number], 2.0)
    ]
    return answers[best], supports[best], max(others, default=0)


def _is_near(one: Pose, other: Pose, times: float = 1.0) -> bool:
    turned = abs(wrap(one.heading - other.heading))
    return one.distance_to(other.x, other.y) < times * SAME_PLACE_M and turned < times * SAME_HEADING_RAD


def _links(pyramid: SearchPyramid, newer: SavedMap, poses: Sequence[Pose], pose: Pose) -> tuple[ViewLink, ...]:
    """The views of the newer map that fit where it is said to lie."""
    numbers = _spread(newer.arrays["view_poses"], MAX_LINKED_VIEWS)
    found: list[ViewLink] = []
    for number, view in zip(numbers, _scan_views(newer, numbers), strict=True):
        expected = pose @ poses[number]
        near = pyramid.field.search(view.points, expected, SAME_PLACE_M, SAME_HEADING_RAD, 0.1, math.radians(1.0))
        fit = judge(pyramid, view, near)
        if fit is None or fit.score < MIN_LINK_SCORE or fit.conflict > MAX_LINK_CONFLICT:
            continue
        if _is_near(fit.pose, expected, 1.5):
            found.append(ViewLink(number, fit.pose, fit.score))
    return tuple(found)


def _mean(links: Sequence[ViewLink], poses: Sequence[Pose], guess: Pose) -> Pose:
    """The answer that lies in the middle of those of the links: their median, which a wrong one does not bend."""
    if not links:
        return guess
    turns = [wrap(link.pose.heading - poses[link.view].heading - guess.heading) for link in links]
    heading = wrap(guess.heading + float(np.median(turns)))
    turned = [Pose(0.0, 0.0, heading) @ Pose(poses[link.view].x, poses[link.view].y, 0.0) for link in links]
    x = float(np.median([link.pose.x - at.x for link, at in zip(links, turned, strict=True)]))
    y = float(np.median([link.pose.y - at.y for link, at in zip(links, turned, strict=True)]))
    return Pose(x, y, heading)


def _compared(pyramid: SearchPyramid, grid: OccupancyGrid, pose: Pose) -> tuple[float, float]:
    """Of the walls of a grid, laid there: the share at walls and the share in the middle of free floor."""
    cells = np.argwhere(grid.log_odds > WALL_LOG_ODDS)
    known = pyramid.known(pose.apply(grid.origin + (cells[:, ::-1] + 0.5) * grid.resolution))
    count = max(1, int((known != 0).sum()))
    return float((known > 0).sum() / count), float((known < 0).sum() / count)


# the join


def _together(older: SavedMap, newer: SavedMap, match: MapMatch) -> SavedMap:
    """All arrays of both, the newer one's numbers behind the older one's, and a loop closure for each pair linked."""
    one, two = older.arrays, newer.arrays
    views, rooms = len(one["view_poses"]), older.submaps
    poses = [match.pose @ pose for pose in _poses(newer)]
    moved = np.array([(pose.x, pose.y, pose.heading) for pose in poses])
    last = Pose(*one["view_poses"][-1].tolist()).inverse() @ poses[0]
    fresh = dict(two)
    fresh["view_poses"] = moved
    fresh["view_submaps"] = two["view_submaps"] + rooms
    fresh["tied_ends"] = two["tied_ends"] + views
    fresh["driven_moves"] = np.vstack((last.vector[None], two["driven_moves"]))
    fresh["driven_covariances"] = np.concatenate((CARRIED[None], two["driven_covariances"]))
    fresh["link_ends"] = two["link_ends"] + np.array([len(older.facts.closures), views, views], np.int64)
    arrays = {key: np.concatenate((one[key], fresh[key])) for key in one if not key.rsplit("_", 1)[-1].isdigit()}
    for source, first in ((older, 0), (newer, rooms)):
        for key, array in source.arrays.items():
            name, _, number = key.rpartition("_")
            if number.isdigit():
                arrays[f"{name}_{int(number) + first}"] = array
    behind = len(older.facts.closures)
    closures = [
        *older.facts.closures,
        *(
            structs.replace(one, id=one.id + behind, older=one.older + rooms, newer=one.newer + rooms)
            for one in newer.facts.closures
        ),
    ]
    closures += _link(arrays, match, (views, rooms), len(closures))
    landmarks = [*older.facts.landmarks, *newer.facts.landmarks]
    facts = MapFacts(older.facts.form, older.facts.resolution_m, landmarks, closures)
    return SavedMap(arrays=arrays, facts=facts)


def _link(arrays: dict[str, Array], match: MapMatch, behind: tuple[int, int], count: int) -> list[SavedClosure]:
    """Append the links to the arrays → their closures; `behind`: views and submaps of the older map."""
    views, _ = behind
    first = arrays["view_poses"][:views]
    rows: dict[tuple[int, int], list[tuple[int, int, Pose, float]]] = {}
    for link in match.links:
        nearest = int(np.argmin(np.hypot(first[:, 0] - link.pose.x, first[:, 1] - link.pose.y)))
        newer = views + link.view
        rooms = int(arrays["view_submaps"][nearest]), int(arrays["view_submaps"][newer])
        move = Pose(*first[nearest].tolist()).inverse() @ link.pose
        rows.setdefault(rooms, []).append((nearest, newer, move, link.score))
    closures: list[SavedClosure] = []
    covariance = np.diag([LINK_SD_M, LINK_SD_M, LINK_SD_RAD]) ** 2
    for (older, newer), links in rows.items():
        number = count + len(closures)
        closures.append(SavedClosure(number + 1, older, newer, False, "accepted", list(range(len(links))), 0))
        ends = np.array([(number, a, b) for a, b, _, _ in links], np.int64)
        arrays["link_ends"] = np.concatenate((arrays["link_ends"], ends))
        arrays["link_moves"] = np.vstack((arrays["link_moves"], [move.vector for _, _, move, _ in links]))
        arrays["link_covariances"] = np.concatenate((arrays["link_covariances"], [covariance] * len(links)))
        arrays["link_scores"] = np.vstack((arrays["link_scores"], [(score, 0.0) for *_, score in links]))
    return closures
