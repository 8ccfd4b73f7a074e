"""The marks that people make on a map: named places, zones, routes, edits. They lie sealed in the map's folder.

Each mark is anchored to the submap that was nearest when it was made: where a loop closure moves the submap, the mark
moves with it.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from core.errors import BadInput
from core.files import is_intact, sealed, write_atomic
from core.geometry import Pose
from core.message import Array
from core.navigation.places import NamedPlace
from core.navigation.zones import MapZone, ZoneKind
from core.sentences import Statement
from core.slam.map.edits import CellEdit, MapEdit
from core.slam.map.status import SubmapView

EditKind = CellEdit | Literal["turn"]
StopAction = Literal["wait_for_continue", "come_here", "say", "take_a_picture", "record"]

MARKS = "marks.json"  # in the folder of a map
MARKS_VERSION = 1
MAX_MARKS_BYTES = 20_000_000


class Anchor(msgspec.Struct, frozen=True):
    """A submap, and where it lay when a mark was made."""

    submap: int
    x_m: float  # world_from_submap
    y_m: float
    heading_rad: float

    def moved(self, submaps: Iterable[SubmapView]) -> Pose:
        """Return the transform from the world as it was then to the world as it is now."""
        now = next((one.pose for one in submaps if one.id == self.submap), None)
        return Pose() if now is None else now @ Pose(self.x_m, self.y_m, self.heading_rad).inverse()


class PlaceMark(msgspec.Struct, frozen=True):
    """A place with a name, in the world as it was when it was made."""

    name: str
    x_m: float
    y_m: float
    heading_rad: float | None = None
    anchor: Anchor | None = None
    by: str = ""  # who made it
    outline_m: tuple[tuple[float, float], ...] = ()  # corners of a room; the place is where one stands in it

    def now(self, submaps: Iterable[SubmapView]) -> NamedPlace:
        if self.anchor is None:
            return NamedPlace(
                name=self.name, x_m=self.x_m, y_m=self.y_m, heading_rad=self.heading_rad, outline_m=self.outline_m
            )
        moved = self.anchor.moved(submaps)
        outline = moved.apply(np.array(self.outline_m).reshape(-1, 2)).tolist()
        here = moved @ Pose(self.x_m, self.y_m, self.heading_rad or 0.0)
        heading = None if self.heading_rad is None else here.heading
        return NamedPlace(
            name=self.name, x_m=here.x, y_m=here.y, heading_rad=heading, outline_m=tuple((x, y) for x, y in outline)
        )


class ZoneMark(msgspec.Struct, frozen=True):
    """A zone, in the world as it was when it was drawn."""

    name: str
    kind: ZoneKind
    points_m: tuple[tuple[float, float], ...]
    max_speed_m_s: float | None = None
    anchor: Anchor | None = None
    by: str = ""  # who drew it

    def now(self, submaps: Iterable[SubmapView]) -> MapZone:
        points = np.array(self.points_m)
        moved = points if self.anchor is None else self.anchor.moved(submaps).apply(points)
        return MapZone(name=self.name, kind=self.kind, points=moved, max_speed=self.max_speed_m_s)


class RouteStop(msgspec.Struct, frozen=True):
    """A stop of a route."""

    place: str  # its name
    wait_s: float = 0.0
    action: StopAction | None = None  # before the wait; “record” lasts as long as that
    text: str = ""  # that is said


class RouteMark(msgspec.Struct, frozen=True):
    """Places in the order in which they are driven to."""

    name: str
    stops: tuple[RouteStop, ...]
    loop: bool = False
    begins: str = ""  # "08:30": rounds begin from then on, by the console's clock; "": at any time
    ends: str = ""  # "17:00": until then
    every_min: float = 0.0  # from the beginning of a round to that of the next one, at least


class EditMark(msgspec.Struct, frozen=True):
    """An edit of the map, in the world as it was when it was made."""

    id: int
    kind: EditKind
    points_m: tuple[tuple[float, float], ...] = ()
    width_m: float = 0.0  # of a brush; 0: the area within the points
    angle_rad: float = 0.0  # of a turn
    anchor: Anchor | None = None
    by: str = ""
    at_s: float = 0.0  # Unix time
    undone_s: float = 0.0  # when it was taken back; 0: it holds

    def now(self, submaps: Iterable[SubmapView]) -> MapEdit | None:
        """The edit in the world as it is now; None for one that changes no cells, or does not hold."""
        if self.kind == "turn" or self.undone_s:
            return None
        points = np.array(self.points_m)
        moved = points if self.anchor is None else self.anchor.moved(submaps).apply(points)
        return MapEdit(self.kind, moved, self.width_m)


class MapMarks(msgspec.Struct, frozen=True):
    places: tuple[PlaceMark, ...] = ()
    zones: tuple[ZoneMark, ...] = ()
    routes: tuple[RouteMark, ...] = ()
    edits: tuple[EditMark, ...] = ()

    def without(self, kind: Literal["places", "zones", "routes"], name: str) -> MapMarks:
        left = tuple(one for one in getattr(self, kind) if one.name != name)
        return msgspec.structs.replace(self, **{kind: left})


def put_together(older: MapMarks, newer: MapMarks, submaps: int) -> MapMarks:
    """The marks of two maps that were joined; the newer one's submaps stand behind so many of the older one.

    A name that both have gets a number; crops and turns of the newer map were of that map alone.
    """
    names = {kind: {one.name.casefold() for one in getattr(older, kind)} for kind in ("places", "zones", "routes")}

    def named(kind: str, name: str) -> str:
        free = next(
            one for one in (name, *(f"{name} {k}" for k in itertools.count(2))) if one.casefold() not in names[kind]
        )
        names[kind].add(free.casefold())
        return free

    def behind(anchor: Anchor | None) -> Anchor:
        if anchor is None:  # it lay in the axes of the newer map, which are those of its first submap
            return Anchor(submaps, 0.0, 0.0, 0.0)
        return msgspec.structs.replace(anchor, submap=anchor.submap + submaps)

    called = {one.name: named("places", one.name) for one in newer.places}
    first = 1 + max((one.id for one in older.edits), default=0)
    kept = [one for one in newer.edits if one.kind not in ("crop", "turn")]
    return MapMarks(
        (
            *older.places,
            *(msgspec.structs.replace(one, name=called[one.name], anchor=behind(one.anchor)) for one in newer.places),
        ),
        (
            *older.zones,
            *(
                msgspec.structs.replace(one, name=named("zones", one.name), anchor=behind(one.anchor))
                for one in newer.zones
            ),
        ),
        (*older.routes, *(renamed(one, named("routes", one.name), called) for one in newer.routes)),
        (
            *older.edits,
            *(msgspec.structs.replace(one, id=first + k, anchor=behind(one.anchor)) for k, one in enumerate(kept)),
        ),
    )


def taken_again(theirs: MapMarks, own: MapMarks) -> MapMarks:
    """The marks of a map that is taken from another robot again, and a robot's own of other names."""

    def both(kind: str) -> tuple[Any, ...]:
        new = getattr(theirs, kind)
        names = {one.name.casefold() for one in new}
        return (*new, *(one for one in getattr(own, kind) if one.name.casefold() not in names))

    return MapMarks(both("places"), both("zones"), both("routes"), theirs.edits)


def renamed(route: RouteMark, name: str, places: Mapping[str, str]) -> RouteMark:
    """The route under that name; `places`: the new names of those that got one."""
    stops = tuple(msgspec.structs.replace(stop, place=places.get(stop.place, stop.place)) for stop in route.stops)
    return msgspec.structs.replace(route, name=name, stops=stops)


def anchor_at(points: Array, submaps: Iterable[SubmapView]) -> Anchor | None:
    """The submap nearest to the middle of points (N, 2) [m], world; None where there is none."""
    middle = points.mean(axis=0)

    def away(submap: SubmapView) -> float:
        inner = submap.pose.inverse().apply(middle[None])[0]
        low, high = submap.extent
        outside = np.maximum(np.maximum(low - inner, inner - high), 0.0)
        return float(np.hypot(*outside)) + 1e-3 * float(np.hypot(*(inner - (low + high) / 2)))

    nearest = min(submaps, key=away, default=None)
    if nearest is None or not math.isfinite(away(nearest)):
        return None
    return Anchor(nearest.id, nearest.pose.x, nearest.pose.y, nearest.pose.heading)


def write_marks(folder: Path, marks: MapMarks) -> None:
    """Write the marks into the folder of their map. Raises BadInput for more than can be read again, OSError."""
    document = {"version": MARKS_VERSION, **msgspec.to_builtins(marks)}
    content = json.dumps(sealed(document), separators=(",", ":")).encode()
    if len(content) > MAX_MARKS_BYTES:
        raise BadInput(Statement("maps.marks_full"))
    write_atomic(folder / MARKS, content)


def read_marks(folder: Path) -> MapMarks:
    """Read the marks of a map; those of earlier consoles have none. Raises BadInput with a sentence, OSError, also
    where the map is gone.
    """
    path = folder / MARKS
    if not path.exists():
        folder.stat()
        return MapMarks()
    if path.stat().st_size > MAX_MARKS_BYTES:
        raise BadInput(f"The file {MARKS} of this map is too large.")
    try:
        document = json.loads(path.read_bytes())
        intact = is_intact(document)
    except (ValueError, RecursionError, TypeError, AttributeError):
        document, intact = {}, False
    if intact is not True:
        raise BadInput(
            f"The places of this map are damaged: {path} is not as it was saved. Restore this file from a backup, or "
            "remove it to go on without them."
        )
    if document.get("version") != MARKS_VERSION:
        raise BadInput(f"The places of this map were saved by another version of Beckon: {path}. Use that version.")
    try:
        return msgspec.convert(document, MapMarks)
    except msgspec.ValidationError as trouble:
        raise BadInput(f"The places of this map cannot be read: {path}: {trouble}.") from None
