"""The rooms that the floor is made of, and the places that were recognised."""

import numpy as np
from viser import LabelHandle, SceneApi

from console.scene.drawing.lines import CROSS, Lines, lifted
from console.scene.drawing.palette import CLOSURE, DOUBT, POSE, ROOM, UNSURE, Colour, faded
from core.message import Array
from core.robots import Profile
from core.slam.map.status import ClosureState, ClosureStatus, SubmapView
from core.snapshot import Snapshot

HEIGHT_M = 0.005
LABEL_HEIGHT_M = 0.25  # of the number
CORNER_SHARE = 0.12  # of a side that is drawn from each corner: whole frames would look like walls
MIN_CORNER_M, MAX_CORNER_M = 0.3, 1.5  # of such a piece
ARCH_PIECES = 24  # of an arch
MIN_ARCH_M, MAX_ARCH_M = 0.25, 2.0  # of an arch's middle
ARCH_STEEPNESS = 0.35  # height of an arch for its length
FOOT_M = 0.05  # of the cross at either end
FLOOR_HEIGHT_M = 0.012
COLOURS: dict[ClosureState, Colour] = {"accepted": CLOSURE, "doubtful": DOUBT, "undone": UNSURE}


class Submaps:
    """A frame around each with its number, the one with the robot stands out; nothing while there is one room."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._scene = scene
        self._frames = Lines(scene, "/rooms/frames", ROOM, 1.6)
        self._labels: dict[int, LabelHandle] = {}
        self._shown: tuple[tuple[float, ...], ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        rooms = snapshot.floor.submaps if len(snapshot.floor.submaps) > 1 else ()
        seen = tuple(visible(room) for room in rooms)
        if seen == self._shown:
            return
        self._shown = seen
        self._frames.draw_each((frame(room), POSE if room.active else faded(ROOM, 0.5)) for room in rooms)
        for gone in self._labels.keys() - {room.id for room in rooms}:
            self._labels.pop(gone).remove()
        for room in rooms:
            self._name(room)

    def _name(self, room: SubmapView) -> None:
        x, y = room.pose.apply(room.extent.mean(axis=0)[None])[0].tolist()
        if room.id not in self._labels:
            self._labels[room.id] = self._scene.add_label(f"/rooms/{room.id}", f"Room {room.id}")
        self._labels[room.id].position = (x, y, LABEL_HEIGHT_M)


def visible(room: SubmapView) -> tuple[float, ...]:
    """Number, place to a centimetre, extent, and whether the robot is in it."""
    at = room.pose
    extent = np.round(room.extent, 1).ravel().tolist()
    return room.id, round(at.x, 2), round(at.y, 2), round(at.heading, 3), *extent, room.active


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


class LoopClosureArcs:
    """Arches from where the robot was to where it had seen the same before, in one node; undone ones are dashed."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._arches = Lines(scene, "/closures", CLOSURE, 2.6)
        self._shown: tuple[ClosureStatus, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        if snapshot.floor.closures is self._shown:
            return
        self._shown = snapshot.floor.closures
        self._arches.draw_each((strokes_of(closure), COLOURS[closure.state]) for closure in self._shown)


def strokes_of(closure: ClosureStatus) -> Array:
    """A closure → segments (N, 2, 3) [m]: an arch and a cross at either end."""
    spans = arch(closure.position_from, closure.position_to)
    if closure.state == "undone":
        spans = spans[::2]
    ends = (closure.position_from, closure.position_to)
    return np.concatenate((spans, *(lifted(at + FOOT_M * CROSS, FLOOR_HEIGHT_M) for at in ends)))


def arch(start: Array, end: Array) -> Array:
    """Feet (2,) [m] → segments (PIECES, 2, 3): half a wave over the line between them."""
    part = np.linspace(0.0, 1.0, ARCH_PIECES + 1)
    height = np.clip(ARCH_STEEPNESS * float(np.hypot(*(end - start))), MIN_ARCH_M, MAX_ARCH_M)
    ground = start + part[:, None] * (end - start)
    points = np.column_stack((ground, FLOOR_HEIGHT_M + height * np.sin(np.pi * part)))
    return np.stack((points[:-1], points[1:]), axis=1)
