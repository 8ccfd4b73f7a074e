"""The rooms that the floor is made of: a frame around each, with its number; the one the robot is in stands out."""

from dataclasses import dataclass

import numpy as np
from viser import LabelHandle, SceneApi

from console.scene.drawing.lines import Lines, lifted
from console.scene.drawing.palette import POSE, ROOM, UNSURE, mix
from core.message import Array
from core.robots import Profile
from core.slam.map.status import SubmapView
from core.snapshot import Snapshot

HEIGHT_M = 0.005
LABEL_HEIGHT_M = 0.25  # of the number
CORNER_SHARE = 0.12  # of a side that is drawn from each corner: whole frames would look like walls
MIN_CORNER_M, MAX_CORNER_M = 0.3, 1.5  # of such a piece


@dataclass(frozen=True)
class VisibleSubmap:
    """Return the visible state of a submap, to a centimetre."""

    id: int
    place: tuple[float, float, float]
    extent: tuple[float, ...]
    active: bool


class Submaps:
    """One node for all frames, a label for every room; nothing at all while there is a single room."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._scene = scene
        self._frames = Lines(scene, "/rooms/frames", ROOM, 1.6)
        self._labels: dict[int, LabelHandle] = {}
        self._shown: tuple[VisibleSubmap, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        rooms = snapshot.floor.submaps if len(snapshot.floor.submaps) > 1 else ()
        seen = tuple(visible(room) for room in rooms)
        if seen == self._shown:
            return
        self._shown = seen
        self._frames.draw_each((frame(room), POSE if room.active else mix(ROOM, UNSURE, 0.5)) for room in rooms)
        for gone in self._labels.keys() - {room.id for room in rooms}:
            self._labels.pop(gone).remove()
        for room in rooms:
            self._name(room)

    def _name(self, room: SubmapView) -> None:
        x, y = room.pose.apply(room.extent.mean(axis=0)[None])[0].tolist()
        if room.id not in self._labels:
            self._labels[room.id] = self._scene.add_label(f"/rooms/{room.id}", f"Room {room.id}")
        self._labels[room.id].position = (x, y, LABEL_HEIGHT_M)


def visible(room: SubmapView) -> VisibleSubmap:
    at = room.pose
    extent = tuple(np.round(room.extent, 1).ravel().tolist())
    return VisibleSubmap(room.id, (round(at.x, 2), round(at.y, 2), round(at.heading, 3)), extent, room.active)


def frame(room: SubmapView) -> Array:
    """A room → segments (8, 2, 3) [m], world: the corners of the rectangle around it."""
    (left, bottom), (right, top) = room.extent.tolist()
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    pieces: list[Array] = []
    for at, before, after in zip(corners, np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0), strict=True):
        for other in (before, after):
            side = float(np.hypot(*(other - at)))
            reach = min(side / 2, max(MIN_CORNER_M, min(MAX_CORNER_M, CORNER_SHARE * side)))
            pieces.append(np.stack((at, at + (other - at) * (reach / max(side, 1e-9)))))
    segments = np.stack(pieces)
    return lifted(room.pose.apply(segments.reshape(-1, 2)).reshape(-1, 2, 2), HEIGHT_M)
