"""Loop closure: looks in spare moments for places seen before, and corrects the pose graph by them."""

from collections import deque
from collections.abc import Generator

import numpy as np

from core.geometry import Pose, wrap, wrap_all
from core.slam.loop_closure.place_recognition import RecognizedPlace, recognise
from core.slam.map.closure import ClosureSettings, Constraint, LoopClosure, agreeing, agreement, departure
from core.slam.map.keyframe import Keyframe
from core.slam.map.map_graph import MapGraph
from core.slam.map.pose_graph import Equations, GraphEdge, Marginals, edge_errors, solve
from core.slam.scan_matching.field_matching import ScanMatchingSettings
from core.slam.scan_matching.point_to_line import WallPoints, align

PLACE_VIEWS = 14  # views that make a place
AROUND_REACH_M = 5.0  # from its base
MAX_PLACES = 8  # that are kept ready
MAX_SUBMAPS = 3  # submaps that one view is searched in
SUPPORT_SPAN = 80  # views to either side whose links may support a new one
MAX_WITNESSES = 30  # of them, at most
MAX_WAITING_VIEWS = 60  # views that wait to be looked at; the oldest are left to the second look
NEIGHBOUR_DISTANCE_M = 2.5  # to views that a view is laid on finely …
METRES_PER_RADIAN = 0.5  # … a radian between them counted as so many metres
MAX_NEIGHBOURS = 12  # of them
MIN_ALIGNMENTS, MIN_ALIGNMENTS_SHARE = 300, 0.02  # after which the map is straightened: alignments, and share of all
EDGES_PER_PIECE = 3000  # on which a piece of work takes as long as a small one more
MAX_READY_VIEWS = 200  # views whose walls are kept ready
MOVED_M, MOVED_RAD = 0.2, np.deg2rad(3.0)  # of a submap against a view: reason to search again
BENT_M = 0.04  # and …
BENT_RAD = np.deg2rad(0.4)  # … of a link that the map does not follow yet: reason to straighten it


class LoopCloser:
    """Works piece by piece on a map graph."""

    def __init__(self, graph: MapGraph, matching: ScanMatchingSettings, settings: ClosureSettings) -> None:
        self._graph, self._matching, self.settings = graph, matching, settings
        self._waiting: deque[int] = deque()  # views to be looked at
        self._looked: dict[int, int] = {}  # view → bends of the map when it was looked at
        self._again, self._bends = list(range(len(graph.views))), graph.bends  # views for a second look, newest last
        self._tried: dict[tuple[int, int], Pose] = {}  # view, submap → where in it the view was searched
        self._places: dict[tuple[int, int, int], RecognizedPlace] = {}
        self._ready: dict[int, WallPoints] = {}
        self._next_view = 0  # to be laid on those next to it
        self._fresh = 0  # alignments since the map was straightened
        self._crooked = False  # loop closures have changed since the map was straightened
        self._labour: Generator[None, None, None] | None = None
        self._due = 0  # small pieces of work; negative: so many were done ahead
        self._size = 1  # of a piece of the present labour, in small ones
        self._stamp = 0.0

    def look_at(self, view: int, stamp: float) -> None:
        """Queue a new view, to look for its place when there is time."""
        self._stamp = stamp
        self._waiting.append(view)
        if len(self._waiting) > MAX_WAITING_VIEWS:
            self._again.append(self._waiting.popleft())

    def work(self, pieces: int) -> int:
        """Do so many small pieces of work; returns how many were left over because there was nothing to do.

        A piece on a large graph counts as several; what it takes beyond these is missing from the next ones.
        """
        self._due += pieces
        while self._due > 0:
            if self._labour is None:
                self._labour, self._size = self._next_labour(), 1
                if self._labour is None:
                    left, self._due = self._due, 0
                    return left
            try:
                next(self._labour)
            except StopIteration:
                self._labour = None
            self._due -= self._size
        return 0

    def finish(self) -> None:
        """Do all the work that is left, and lay every view on those that have come to lie next to it."""
        self._do_all()
        self._next_view = 0
        self._do_all()

    def settle(self) -> None:
        """Straighten the map once, by the links that it has; nothing is searched for."""
        self._crooked = True
        while self._crooked:
            for _ in self._straighten():
                pass

    def _do_all(self) -> None:
        while not self.work(1000) or self._fresh:
            self._crooked |= self._labour is None and self._fresh > 0

    def believe(self, loop_closure: int, holds: bool) -> bool:
        """Undo a loop closure, or redo it → whether there is one of that number that can be."""
        for each in self._graph.loop_closures:
            if each.id == loop_closure and each.shown is not None and each.undone is holds:
                each.state = "accepted" if holds and each.accepted else "undone" if not holds else "doubtful"
                self._crooked = True
                return True
        return False

    def _next_labour(self) -> Generator[None, None, None] | None:
        if self._crooked:
            return self._straighten()
        if self._waiting:
            return self._look(self._waiting.popleft())
        again = self._second_look()
        return self._next_alignment() if again is None else self._look(again)

    def _next_alignment(self) -> Generator[None, None, None] | None:
        """Once a loop is closed: lay the next view on those next to it; straighten the map when there were some."""
        if self._next_view < len(self._graph.views) and any(
            loop_closure.holds and not loop_closure.next_door for loop_closure in self._graph.loop_closures
        ):
            self._next_view += 1
            return self._align(self._next_view - 1)
        self._crooked |= self._is_worth_it(1)
        return self._straighten() if self._crooked else None

    def _is_worth_it(self, least: int) -> bool:
        return self._fresh >= max(least, MIN_ALIGNMENTS_SHARE * len(self._graph.aligned))

    def _align(self, number: int) -> Generator[None, None, None]:
        """Lay a view on the older ones next to it, finely."""
        graph, poses = self._graph, self._graph.pose_array()
        gaps = np.hypot(*(poses[:number, :2] - poses[number, :2]).T)
        gaps += METRES_PER_RADIAN * np.abs(wrap_all(poses[:number, 2] - poses[number, 2]))
        near = np.flatnonzero(gaps < NEIGHBOUR_DISTANCE_M)
        near = near[graph.connected(near, np.array(number))]
        for other in near[np.argsort(gaps[near], kind="stable")][:MAX_NEIGHBOURS].tolist():
            if (other, number) in graph.aligned:
                continue
            found = align(self._walls(other), self._walls(number), graph.poses[other].inverse() @ graph.poses[number])
            if found is not None:
                graph.aligned[other, number] = GraphEdge(other, number, *found, doubted=True)
                self._fresh += 1
            yield
        self._crooked |= self._is_worth_it(MIN_ALIGNMENTS)

    def _walls(self, number: int) -> WallPoints:
        """The walls of a view, the latest kept ready."""
        if number not in self._ready:
            if len(self._ready) >= MAX_READY_VIEWS:
                del self._ready[next(iter(self._ready))]
            self._ready[number] = WallPoints(self._graph.views[number])
        return self._ready[number]

    def _second_look(self) -> int | None:
        """The newest view that was looked at on an older map and has found nothing since."""
        bends = self._graph.bends
        if bends != self._bends:
            self._again, self._bends = list(range(len(self._graph.views))), bends
        while self._again and self._looked.get(self._again[-1], -1) >= bends:
            self._again.pop()
        return self._again[-1] if self._again else None

    def _look(self, number: int) -> Generator[None, None, None]:
        """Search one view in the submaps around it."""
        self._looked[number] = self._graph.bends
        view = self._graph.views[number]
        bases = self._bases(view)
        ways = self._graph.ways_from(number, self._longest) if bases else None
        yield
        for base in bases:
            place = self._place(base)
            yield
            guess = self._graph.poses[base.id].inverse() @ self._graph.poses[number]
            self._tried[number, base.submap] = (
                self._graph.world_from(base.submap).inverse() @ self._graph.poses[number]
            )
            reach = self._reach(0.0 if ways is None else float(ways[base.id]))
            link = yield from recognise(view, place, guess, reach, self._matching, self.settings, self._stamp)
            if link is not None:
                self._consider(link)
                yield

    def _bases(self, view: Keyframe) -> list[Keyframe]:
        """The nearest view of each of at most MAX_SUBMAPS submaps around; none where a link is known or undone."""
        graph, poses = self._graph, self._graph.pose_array()
        gaps = np.hypot(*(poses[:, :2] - poses[view.id, :2]).T)
        around = np.flatnonzero(gaps < self.settings.near)
        nearest: dict[int, Keyframe] = {}  # of every submap, the nearest submap first
        for number in around[np.argsort(gaps[around], kind="stable")].tolist():
            nearest.setdefault(graph.views[number].submap, graph.views[number])
        bases: list[Keyframe] = []
        for submap, base in nearest.items():
            loop_closure = None if submap == view.submap else graph.closure_between(submap, view.submap)
            known = loop_closure is not None and (
                loop_closure.undone or any(view.id in (link.a, link.b) for link in loop_closure.links)
            )
            if submap != view.submap and not known and self._is_untried(view, submap):
                bases.append(base)
        return bases[:MAX_SUBMAPS]

    def _is_untried(self, view: Keyframe, submap: int) -> bool:
        place = self._graph.world_from(submap).inverse() @ self._graph.poses[view.id]
        before = self._tried.get((view.id, submap))
        return before is None or (
            before.distance_to(place.x, place.y) > MOVED_M or abs(wrap(before.heading - place.heading)) > MOVED_RAD
        )

    @property
    def _longest(self) -> float:
        """Way [m] from which on the reach grows no more."""
        settings = self.settings
        place = (settings.widest - settings.reach) / max(settings.reach_per_way, 1e-6)
        return max(place, (settings.widest_angle - settings.angle) / max(settings.angle_per_way, 1e-6))

    def _reach(self, way: float) -> tuple[float, float]:
        """Return the search window [m], [rad] after a way [m] between the two."""
        settings = self.settings
        reach = min(settings.reach + settings.reach_per_way * way, settings.widest)
        return reach, min(settings.angle + settings.angle_per_way * way, settings.widest_angle)

    def _place(self, base: Keyframe) -> RecognizedPlace:
        graph, submap = self._graph, self._graph.submaps[base.submap]
        key = (base.id, graph.revision, len(submap.views))
        if key not in self._places:
            back = graph.poses[base.id].inverse()
            placed = [(back @ graph.poses[view.id], view) for view in submap.views]
            placed.sort(key=lambda each: each[0].distance_to(0.0, 0.0))
            around = [each for each in placed[:PLACE_VIEWS] if each[0].distance_to(0.0, 0.0) < AROUND_REACH_M]
            if len(self._places) >= MAX_PLACES:
                del self._places[next(iter(self._places))]
            self._places[key] = RecognizedPlace.of(base, around)
        return self._places[key]

    def _consider(self, link: Constraint) -> None:
        """Accept a match that passed its own checks if it agrees with the other links."""
        graph, link = self._graph, link.forwards()
        loop_closure = graph.loop_closure(graph.views[link.a].submap, graph.views[link.b].submap)
        loop_closure.links.append(link)
        if loop_closure.next_door:
            follows_the_way = departure(link, self._graph.way(link.a, link.b)) < self.settings.agree
            group = [link] if follows_the_way else []
        elif loop_closure.holds and any(
            agreement(link, other, graph.way)[0] < self.settings.agree for other in loop_closure.accepted
        ):
            group = [link]
        else:
            group = agreeing(link, self._others(link), graph.way, self.settings)
            if loop_closure.holds and sum(member in loop_closure.links for member in group) > len(
                loop_closure.accepted
            ):
                loop_closure.accepted = []
            elif loop_closure.holds:
                group = []
        for member in group:
            self._accept(member)

    def _others(self, link: Constraint) -> list[Constraint]:
        """Links near this one at both ends, in loop closures that were not undone."""
        around = [
            other
            for loop_closure in self._graph.loop_closures
            if not loop_closure.undone
            for other in loop_closure.links
            if other is not link and abs(other.a - link.a) < SUPPORT_SPAN and abs(other.b - link.b) < SUPPORT_SPAN
        ]
        return around[-MAX_WITNESSES:]

    def _accept(self, link: Constraint) -> None:
        graph = self._graph
        loop_closure = graph.loop_closure(graph.views[link.a].submap, graph.views[link.b].submap)
        if link in loop_closure.accepted:
            return
        loop_closure.accepted.append(link)
        loop_closure.shown = loop_closure.shown or link
        new, loop_closure.state = loop_closure.state != "accepted", "accepted"
        off = edge_errors(graph.pose_array()[[link.a, link.b]], np.array([0]), np.array([1]), link.move.vector[None])[
            0
        ]
        self._crooked |= new or bool(np.hypot(off[0], off[1]) > BENT_M or abs(off[2]) > BENT_RAD)

    def _straighten(self) -> Generator[None, None, None]:
        """Solve the graph; what the map would not bend to is no longer accepted, and then once more."""
        graph, self._crooked, self._fresh = self._graph, False, 0
        links, start, revision = graph.links(), graph.pose_array(), graph.revision
        edges = graph.edges(links)
        self._size += len(edges) // EDGES_PER_PIECE
        yield
        solution = yield from solve(start, edges, self.settings.doubt)
        left = dict(zip(links, solution.squared[len(solution.squared) - len(links) :].tolist(), strict=True))
        for loop_closure in graph.loop_closures:
            if loop_closure.holds:
                self._sift(loop_closure, left)
        yield
        poses = graph.bent(solution.poses)
        edges = graph.edges(graph.links(), poses)
        yield
        equations = Equations(edges, len(poses))
        system = equations.at(poses)[0]
        yield
        marginals = Marginals(equations.order, system)
        yield
        if graph.revision != revision:  # it was turned meanwhile
            self._crooked = True
            return
        graph.revise(solution.poses, marginals)

    def _sift(self, loop_closure: LoopClosure, left: dict[Constraint, float]) -> None:
        """Drop accepted links that contradict the rest; without any left, the loop closure is doubtful."""
        good = [link for link in loop_closure.accepted if left.get(link, 0.0) < self.settings.contradiction]
        if len(good) < len(loop_closure.accepted):
            loop_closure.accepted = good
            self._crooked = True
        if not good:
            loop_closure.state = "doubtful"
