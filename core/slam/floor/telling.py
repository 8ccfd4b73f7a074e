"""What the submaps know, told in the world's frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.geometry import Pose, rotation
from core.message import Array
from core.slam.estimate import Association, Landmark
from core.slam.floor.atlas import Atlas
from core.slam.floor.closure import Bond
from core.slam.floor.health import Closure, ClosureState, SubmapView
from core.slam.floor.submap import Submap

DRAWN = 10  # scans after which a room's extent is told anew
WORDS: dict[ClosureState, str] = {
    "accepted": "I have been here before: {views} views agree.",
    "undone": "Undone by the operator.",
    "doubtful": "It contradicts the rest of the map, so the map does not bend to it.",
}
PER_SUBMAP = 10_000  # a landmark's number in the world: its own in the submap, and this for every submap before


class Telling:
    """Keeps what was told until it changes."""

    def __init__(self, atlas: Atlas) -> None:
        self._atlas = atlas
        self._landmarks: dict[int, tuple[int, tuple[Landmark, ...], tuple[Landmark, ...]]] = {}
        self._rooms: tuple[tuple[int, ...], tuple[SubmapView, ...]] = (), ()
        self._closures: tuple[object, tuple[Closure, ...]] = None, ()
        self._all: tuple[Landmark, ...] = ()
        self._associations: tuple[Pose, tuple[Association, ...], tuple[Association, ...]] = (Pose(), (), ())

    def submaps(self, active: Submap) -> tuple[SubmapView, ...]:
        """Where the rooms lie."""
        key = self._atlas.revision, len(self._atlas.submaps), active.id, -(-active.tile.revision // DRAWN)
        if key != self._rooms[0]:
            told = tuple(
                SubmapView(id=submap.id, pose=self._base(submap), extent=_extent(submap), active=submap is active)
                for submap in self._atlas.submaps
            )
            self._rooms = key, told
        return self._rooms[1]

    def closures(self) -> tuple[Closure, ...]:
        """The places that were recognised, and what became of each."""
        told = [bond for bond in self._atlas.bonds if bond.shown is not None and not bond.next_door]
        key = self._atlas.revision, tuple((bond.id, bond.state, len(bond.accepted)) for bond in told)
        if key != self._closures[0]:
            self._closures = key, tuple(self._closure(bond) for bond in told)
        return self._closures[1]

    def _closure(self, bond: Bond) -> Closure:
        link = bond.shown
        assert link is not None, "only shown bonds are told"
        here, there = self._atlas.poses[link.b], self._atlas.poses[link.a]
        return Closure(
            id=bond.id,
            stamp=link.stamp,
            submap_from=bond.newer,
            submap_to=bond.older,
            position_from=np.array([here.x, here.y]),
            position_to=np.array([there.x, there.y]),
            score=link.score,
            state=bond.state,
            words=WORDS[bond.state].format(views=len(bond.accepted)),
        )

    def landmarks(self) -> tuple[Landmark, ...]:
        """The landmarks of all submaps, in the world, each with a number of its own."""
        changed, revision = False, self._atlas.revision
        for submap in self._atlas.submaps:
            own, known = submap.slam.landmarks, self._landmarks.get(submap.id)
            if known is not None and known[0] == revision and known[1] is own:
                continue
            pose = self._base(submap)
            self._landmarks[submap.id] = revision, own, tuple(_placed(mark, pose, submap.id) for mark in own)
            changed = True
        if changed:
            self._all = tuple(mark for _, _, told in self._landmarks.values() for mark in told)
        return self._all

    def associations(self, active: Submap) -> tuple[Association, ...]:
        """The newest sightings' fates, in the world."""
        pose, own = self._base(active), active.slam.associations
        known = self._associations
        if known[0] != pose or known[1] is not own:
            told = tuple(
                replace(
                    each,
                    position=pose.apply(each.position[None])[0],
                    landmark=None if each.landmark is None else each.landmark + PER_SUBMAP * active.id,
                )
                for each in own
            )
            self._associations = pose, own, own if pose == Pose() and not active.id else told
        return self._associations[2]

    def _base(self, submap: Submap) -> Pose:
        return self._atlas.world_from(submap.id) if submap.views else Pose()


def _extent(submap: Submap) -> Array:
    """(2, 2) [m]: lowest and highest x, y of what is drawn of a room."""
    origin, values = submap.tile.cells
    size = np.array(values.shape[::-1]) * submap.tile.resolution
    return np.stack((origin, origin + size))


def _placed(mark: Landmark, pose: Pose, submap: int) -> Landmark:
    if pose == Pose() and not submap:
        return mark
    onto = rotation(pose.heading)
    covariance = onto @ np.asarray(mark.covariance) @ onto.T
    position = pose.apply(mark.position[None])[0]
    return replace(mark, id=mark.id + PER_SUBMAP * submap, position=position, covariance=covariance)
