"""Looks in spare moments for places that were seen before, and straightens the map where they were recognised."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator

import numpy as np

from core.geometry import Pose, wrap, wrap_all
from core.slam.floor.alignment import Walls, align
from core.slam.floor.atlas import Atlas
from core.slam.floor.closure import Bond, ClosureSettings, Link, agreement, departure, vouched
from core.slam.floor.keyframe import Keyframe
from core.slam.floor.matching import MatchingSettings
from core.slam.floor.pose_graph import Edge, edge_errors, solve
from core.slam.floor.recognition import Place, recognise

AROUND = 14  # views that make a place
AROUND_REACH = 5.0  # [m] from its base
PLACES = 8  # that are kept ready
ROOMS = 3  # submaps that one view is searched in
SPAN = 80  # views to either side whose links may vouch for a new one
WITNESSES = 30  # of them, at most
WAITING = 60  # views that wait to be looked at; the oldest are left to the second look
BESIDE = 2.5  # [m] to views that a view is laid on finely …
TURNED = 0.5  # … a radian between them counted as so many metres
NEIGHBOURS = 12  # of them
MANY, SHARE = 300, 0.02  # alignments after which the map is straightened, and share of all that they must be then
READY = 200  # views whose walls are kept ready
MOVED, MOVED_TURN = 0.2, np.deg2rad(3.0)  # [m], [rad] of a submap against a view: reason to search again
BENT = 0.04  # [m] and
BENT_TURN = np.deg2rad(0.4)  # [rad] of a link that the map does not follow yet: reason to straighten it


class Surveyor:
    """Works piece by piece on an atlas."""

    def __init__(self, atlas: Atlas, matching: MatchingSettings, settings: ClosureSettings) -> None:
        self._atlas, self._matching, self.settings = atlas, matching, settings
        self._waiting: deque[int] = deque()  # views to be looked at
        self._looked: dict[int, int] = {}  # view → bends of the atlas when it was looked at
        self._again, self._bends = list(range(len(atlas.views))), atlas.bends  # views for a second look, newest last
        self._tried: dict[tuple[int, int], Pose] = {}  # view, submap → where in it the view was searched
        self._places: dict[tuple[int, int, int], Place] = {}
        self._ready: dict[int, Walls] = {}
        self._next_view = 0  # to be laid on those beside it
        self._fresh = 0  # alignments since the map was straightened
        self._crooked = False  # bonds have changed since the map was straightened
        self._labour: Generator[None, None, None] | None = None
        self._stamp = 0.0

    def look_at(self, view: int, stamp: float) -> None:
        """A new view: look for its place when there is time."""
        self._stamp = stamp
        self._waiting.append(view)
        if len(self._waiting) > WAITING:
            self._again.append(self._waiting.popleft())

    def work(self, pieces: int) -> int:
        """Do so many small pieces of work; returns how many were left over because there was nothing to do."""
        for done in range(pieces):
            if self._labour is None:
                self._labour = self._next_labour()
                if self._labour is None:
                    return pieces - done
            try:
                next(self._labour)
            except StopIteration:
                self._labour = None
        return 0

    def finish(self) -> None:
        """Do all the work that is left, and lay every view on those that have come to lie beside it."""
        self._do_all()
        self._next_view = 0
        self._do_all()

    def _do_all(self) -> None:
        while not self.work(1000) or self._fresh:
            self._crooked |= self._labour is None and self._fresh > 0

    def believe(self, bond: int, holds: bool) -> bool:
        """Undo a bond, or redo it; returns whether there is one of that number that can be."""
        for each in self._atlas.bonds:
            if each.id == bond and each.shown is not None and each.undone is holds:
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
        """Once a loop is closed: lay the next view on those beside it; straighten the map when there were some."""
        if self._next_view < len(self._atlas.views) and any(
            bond.holds and not bond.next_door for bond in self._atlas.bonds
        ):
            self._next_view += 1
            return self._align(self._next_view - 1)
        self._crooked |= self._is_worth_it(1)
        return self._straighten() if self._crooked else None

    def _is_worth_it(self, least: int) -> bool:
        """Whether so many new alignments wait, and enough beside the rest: the whole map is solved for them."""
        return self._fresh >= max(least, SHARE * len(self._atlas.aligned))

    def _align(self, number: int) -> Generator[None, None, None]:
        """Lay a view on the older ones beside it, finely."""
        atlas, poses = self._atlas, self._atlas.pose_array()
        gaps = np.hypot(*(poses[:number, :2] - poses[number, :2]).T)
        gaps += TURNED * np.abs(wrap_all(poses[:number, 2] - poses[number, 2]))
        near = [other for other in np.argsort(gaps, kind="stable").tolist() if gaps[other] < BESIDE]
        for other in [each for each in near if atlas.connected(each, number)][:NEIGHBOURS]:
            if (other, number) in atlas.aligned:
                continue
            found = align(self._walls(other), self._walls(number), atlas.poses[other].inverse() @ atlas.poses[number])
            if found is not None:
                atlas.aligned[other, number] = Edge(other, number, *found, doubted=True)
                self._fresh += 1
            yield
        self._crooked |= self._is_worth_it(MANY)

    def _walls(self, number: int) -> Walls:
        """The walls of a view, the latest kept ready."""
        if number not in self._ready:
            if len(self._ready) >= READY:
                del self._ready[next(iter(self._ready))]
            self._ready[number] = Walls(self._atlas.views[number])
        return self._ready[number]

    def _second_look(self) -> int | None:
        """The newest view that was looked at on an older map and has found nothing since."""
        bends = self._atlas.bends
        if bends != self._bends:
            self._again, self._bends = list(range(len(self._atlas.views))), bends
        while self._again and self._looked.get(self._again[-1], -1) >= bends:
            self._again.pop()
        return self._again[-1] if self._again else None

    def _look(self, number: int) -> Generator[None, None, None]:
        """Search one view in the submaps around it."""
        self._looked[number] = self._atlas.bends
        view = self._atlas.views[number]
        bases = self._bases(view)
        ways = self._atlas.ways_from(number, self._longest) if bases else None
        yield
        for base in bases:
            place = self._place(base)
            yield
            guess = self._atlas.poses[base.id].inverse() @ self._atlas.poses[number]
            self._tried[number, base.submap] = (
                self._atlas.world_from(base.submap).inverse() @ self._atlas.poses[number]
            )
            reach = self._reach(0.0 if ways is None else float(ways[base.id]))
            link = yield from recognise(view, place, guess, reach, self._matching, self.settings, self._stamp)
            if link is not None:
                self._consider(link)
                yield

    def _bases(self, view: Keyframe) -> list[Keyframe]:
        """The nearest view of every other submap around, at most ROOMS; none where a link is known or undone."""
        atlas, poses = self._atlas, self._atlas.pose_array()
        gaps = np.hypot(*(poses[:, :2] - poses[view.id, :2]).T)
        around = np.flatnonzero(gaps < self.settings.near)
        nearest: dict[int, Keyframe] = {}  # of every submap, the nearest submap first
        for number in around[np.argsort(gaps[around], kind="stable")].tolist():
            nearest.setdefault(atlas.views[number].submap, atlas.views[number])
        bases: list[Keyframe] = []
        for submap, base in nearest.items():
            bond = None if submap == view.submap else atlas.bond_between(submap, view.submap)
            known = bond is not None and (bond.undone or any(view.id in (link.a, link.b) for link in bond.links))
            if submap != view.submap and not known and self._is_untried(view, submap):
                bases.append(base)
        return bases[:ROOMS]

    def _is_untried(self, view: Keyframe, submap: int) -> bool:
        """Whether the map has moved so much that a search that found nothing is worth another one."""
        place = self._atlas.world_from(submap).inverse() @ self._atlas.poses[view.id]
        before = self._tried.get((view.id, submap))
        return before is None or (
            before.distance_to(place.x, place.y) > MOVED or abs(wrap(before.heading - place.heading)) > MOVED_TURN
        )

    @property
    def _longest(self) -> float:
        """Way [m] from which on the reach grows no more."""
        settings = self.settings
        place = (settings.widest - settings.reach) / max(settings.reach_per_way, 1e-6)
        return max(place, (settings.widest_angle - settings.angle) / max(settings.angle_per_way, 1e-6))

    def _reach(self, way: float) -> tuple[float, float]:
        """How far around to search after a way [m] between the two."""
        settings = self.settings
        reach = min(settings.reach + settings.reach_per_way * way, settings.widest)
        return reach, min(settings.angle + settings.angle_per_way * way, settings.widest_angle)

    def _place(self, base: Keyframe) -> Place:
        """What was seen around a view, by the present map."""
        atlas, submap = self._atlas, self._atlas.submaps[base.submap]
        key = (base.id, atlas.revision, len(submap.views))
        if key not in self._places:
            back = atlas.poses[base.id].inverse()
            placed = [(back @ atlas.poses[view.id], view) for view in submap.views]
            placed.sort(key=lambda each: each[0].distance_to(0.0, 0.0))
            around = [each for each in placed[:AROUND] if each[0].distance_to(0.0, 0.0) < AROUND_REACH]
            if len(self._places) >= PLACES:
                del self._places[next(iter(self._places))]
            self._places[key] = Place.of(base, around)
        return self._places[key]

    def _consider(self, link: Link) -> None:
        """A match that passed its own checks: does it agree with what else is known?"""
        atlas, link = self._atlas, link.forwards()
        bond = atlas.bond(atlas.views[link.a].submap, atlas.views[link.b].submap)
        bond.links.append(link)
        if bond.next_door:
            group = [link] if self._follows_the_way(link) else []
        elif bond.holds and any(self._agree(link, other) for other in bond.accepted):
            group = [link]
        else:
            group = vouched(link, self._others(link), atlas.way, self.settings)
            if bond.holds and sum(member in bond.links for member in group) > len(bond.accepted):
                bond.accepted = []
            elif bond.holds:
                group = []
        for member in group:
            self._accept(member)

    def _others(self, link: Link) -> list[Link]:
        """Links near this one at both ends, in bonds that nobody has undone."""
        around = [
            other
            for bond in self._atlas.bonds
            if not bond.undone
            for other in bond.links
            if other is not link and abs(other.a - link.a) < SPAN and abs(other.b - link.b) < SPAN
        ]
        return around[-WITNESSES:]

    def _accept(self, link: Link) -> None:
        atlas = self._atlas
        bond = atlas.bond(atlas.views[link.a].submap, atlas.views[link.b].submap)
        if link in bond.accepted:
            return
        bond.accepted.append(link)
        bond.shown = bond.shown or link
        new, bond.state = bond.state != "accepted", "accepted"
        off = edge_errors(atlas.pose_array()[[link.a, link.b]], np.array([0]), np.array([1]), link.move.vector[None])[
            0
        ]
        self._crooked |= new or bool(np.hypot(off[0], off[1]) > BENT or abs(off[2]) > BENT_TURN)

    def _follows_the_way(self, link: Link) -> bool:
        return departure(link, self._atlas.way(link.a, link.b)) < self.settings.agree

    def _agree(self, one: Link, other: Link) -> bool:
        return agreement(one, other, self._atlas.way)[0] < self.settings.agree

    def _straighten(self) -> Generator[None, None, None]:
        """Solve the graph; what the map would not bend to is no longer accepted, and then once more."""
        atlas, self._crooked, self._fresh = self._atlas, False, 0
        links, start = atlas.links(), atlas.pose_array()
        solution = yield from solve(start, atlas.edges(links), self.settings.doubt)
        left = dict(zip(links, solution.squared[len(solution.squared) - len(links) :].tolist(), strict=True))
        for bond in atlas.bonds:
            if bond.holds:
                self._sift(bond, left)
        yield
        atlas.revise(solution.poses, len(start))

    def _sift(self, bond: Bond, left: dict[Link, float]) -> None:
        """Links that contradict the rest lose their say; with most of them gone, so does the bond."""
        good = [link for link in bond.accepted if left.get(link, 0.0) < self.settings.contradiction]
        if len(good) < len(bond.accepted):
            bond.accepted = good
            self._crooked = True
        if not good:
            bond.state = "doubtful"
