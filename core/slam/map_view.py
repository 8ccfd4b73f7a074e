"""The content of the submaps in the world's frame."""

from dataclasses import replace

import numpy as np

from core.geometry import Pose, rotation
from core.message import Array
from core.slam.estimate import Association, Landmark
from core.slam.map.closure import LoopClosure
from core.slam.map.map_graph import MapGraph
from core.slam.map.status import ClosureState, ClosureStatus, SubmapView
from core.slam.map.submap import Submap

SCANS_PER_DRAWING = 10  # scans after which a submap's extent is published again
WORDS: dict[ClosureState, str] = {
    "accepted": "I have been here before: {views} views agree.",
    "undone": "Undone by the operator.",
    "doubtful": "It contradicts the rest of the map, so the map does not bend to it.",
}
PER_SUBMAP = 10_000  # a landmark's number in the world: its own in the submap, and this for every submap before


class MapView:
    """Keeps the published submaps, closures and landmarks until they change."""

    def __init__(self, graph: MapGraph) -> None:
        self._graph = graph
        self._landmarks: dict[int, tuple[int, tuple[Landmark, ...], tuple[Landmark, ...]]] = {}
        self._submaps: tuple[tuple[int, ...], tuple[SubmapView, ...]] = (), ()
        self._closures: tuple[object, tuple[ClosureStatus, ...]] = None, ()
        self._all: tuple[Landmark, ...] = ()
        self._associations: tuple[Pose, tuple[Association, ...], tuple[Association, ...]] = (Pose(), (), ())

    def submaps(self, active: Submap) -> tuple[SubmapView, ...]:
        """The submaps and their places."""
        key = self._graph.revision, len(self._graph.submaps), active.id, -(-active.tile.revision // SCANS_PER_DRAWING)
        if key != self._submaps[0]:
            views = tuple(
                SubmapView(id=submap.id, pose=self._base(submap), extent=_extent(submap), active=submap is active)
                for submap in self._graph.submaps
            )
            self._submaps = key, views
        return self._submaps[1]

    def closures(self) -> tuple[ClosureStatus, ...]:
        """The places that were recognised, and what became of each."""
        shown = [
            loop_closure
            for loop_closure in self._graph.loop_closures
            if loop_closure.shown is not None and not loop_closure.next_door
        ]
        key = (
            self._graph.revision,
            tuple((loop_closure.id, loop_closure.state, len(loop_closure.accepted)) for loop_closure in shown),
        )
        if key != self._closures[0]:
            self._closures = key, tuple(self._closure(loop_closure) for loop_closure in shown)
        return self._closures[1]

    def _closure(self, loop_closure: LoopClosure) -> ClosureStatus:
        link = loop_closure.shown
        assert link is not None, "only closures that are shown have a status"
        here, there = self._graph.poses[link.b], self._graph.poses[link.a]
        return ClosureStatus(
            id=loop_closure.id,
            stamp=link.stamp,
            submap_from=loop_closure.newer,
            submap_to=loop_closure.older,
            position_from=np.array([here.x, here.y]),
            position_to=np.array([there.x, there.y]),
            score=link.score,
            state=loop_closure.state,
            words=WORDS[loop_closure.state].format(views=len(loop_closure.accepted)),
        )

    def landmarks(self) -> tuple[Landmark, ...]:
        """The landmarks of all submaps, in the world, each with a number of its own."""
        changed, revision = False, self._graph.revision
        for submap in self._graph.submaps:
            own, known = submap.landmarks, self._landmarks.get(submap.id)
            if known is not None and known[0] == revision and known[1] is own:
                continue
            pose = self._base(submap)
            self._landmarks[submap.id] = revision, own, tuple(_placed(mark, pose, submap.id) for mark in own)
            changed = True
        if changed:
            self._all = tuple(mark for _, _, placed in self._landmarks.values() for mark in placed)
        return self._all

    def associations(self, active: Submap) -> tuple[Association, ...]:
        """The newest sightings' fates, in the world."""
        pose, own = self._base(active), active.associations
        known = self._associations
        if known[0] != pose or known[1] is not own:
            placed = tuple(
                replace(
                    each,
                    position=pose.apply(each.position[None])[0],
                    landmark=None if each.landmark is None else each.landmark + PER_SUBMAP * active.id,
                )
                for each in own
            )
            self._associations = pose, own, own if pose == Pose() and not active.id else placed
        return self._associations[2]

    def _base(self, submap: Submap) -> Pose:
        return self._graph.world_from(submap.id) if submap.views else Pose()


def _extent(submap: Submap) -> Array:
    """(2, 2) [m]: lowest and highest x, y of what is drawn of a room."""
    origin, values = submap.tile.cells
    return np.stack((origin, origin + np.array(values.shape[::-1]) * submap.tile.resolution))


def _placed(mark: Landmark, pose: Pose, submap: int) -> Landmark:
    if pose == Pose() and not submap:
        return mark
    onto = rotation(pose.heading)
    covariance = onto @ np.asarray(mark.covariance) @ onto.T
    position = pose.apply(mark.position[None])[0]
    return replace(mark, id=mark.id + PER_SUBMAP * submap, position=position, covariance=covariance)
