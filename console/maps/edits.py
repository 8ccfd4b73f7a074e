"""Edits of the map in use: cells erased and drawn, the map cropped and turned; each can be taken back.

Edits are a list that only grows: one that is taken back stays in it and can be made again, and a version of the map
is the number of its last edit. Nothing of what the robot saw is changed; a turn moves the axes of the world.
"""

import asyncio
import math
import time
from functools import partial

import msgspec
import numpy as np

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.control.lease import Lease
from console.http.problems import Problem
from console.maps.marks import EditKind, EditMark, anchor_at
from console.maps.service import MapService
from console.part import Part
from core.errors import BadInput
from core.sentences import Statement
from core.slam.map.edits import MapEdits

MAX_EDITS, MAX_EDIT_POINTS = 2000, 1000
MAX_BRUSH_M, MAX_REACH_M = 5.0, 500.0
TURNED_WITHIN_S = 10.0  # for which a turn waits for the pilot
TURN_LOOK_S = 0.02
NOTHING_TO_UNDO = Statement("edits.nothing_to_undo")


class EditService(Part):
    """Lives on the event loop."""

    def __init__(self, maps: MapService, dispatcher: CommandDispatcher, lease: Lease) -> None:
        self._maps, self._dispatcher, self._lease = maps, dispatcher, lease
        self._turn = asyncio.Lock()  # one change at a time
        maps.when_marked.append(self._refresh)

    @property
    def edits(self) -> tuple[EditMark, ...]:
        """All that were made on the map in use, also those that were taken back."""
        return self._maps.marks.edits

    async def add(
        self, kind: EditKind, points: list[tuple[float, float]], width: float, angle: float, who: Person
    ) -> EditMark:
        """Edit the map: cells within points [m], world, or along them with a brush of `width` [m]; a turn by `angle`
        [rad]. Raises BadInput, Problem 409, 503, Refused, Unwritable.
        """
        self._lease.check_not_anothers(who)
        made = self._checked(kind, points, width, angle, who)
        async with self._turn:
            edit = msgspec.structs.replace(made, id=1 + max((one.id for one in self.edits), default=0))
            if len(self.edits) >= MAX_EDITS:
                raise Problem(409, Statement("edits.full", most=MAX_EDITS))
            await self._change((*self.edits, edit), f"map edit {edit.id}: {kind}", who)
        return edit

    async def undo(self, who: Person, number: int | None = None) -> EditMark:
        """Take back an edit, the newest that holds if none is named. Raises Problem 404, 409, as `add`."""
        self._lease.check_not_anothers(who)
        async with self._turn:  # two at once take back two
            held = [one for one in self.edits if not one.undone_s and number in (None, one.id)]
            if not held:
                raise Problem(404 if number else 409, NOTHING_TO_UNDO)
            edit = max(held, key=lambda one: one.id)
            await self._mark_undone({edit.id}, time.time(), f"map edit {edit.id} undone", who)
        return edit

    async def redo(self, who: Person, number: int | None = None) -> EditMark:
        """Make an edit again, the one that was taken back last if none is named. Raises as `undo`."""
        self._lease.check_not_anothers(who)
        async with self._turn:
            gone = [one for one in self.edits if one.undone_s and number in (None, one.id)]
            if not gone:
                raise Problem(404 if number else 409, Statement("edits.nothing_to_redo"))
            edit = max(gone, key=lambda one: (one.undone_s, -one.id))
            await self._mark_undone({edit.id}, 0.0, f"map edit {edit.id} redone", who)
        return edit

    async def back_to(self, version: int, who: Person) -> None:
        """Take back all edits after this one: the map as it was then. Raises Problem 409, as `add`."""
        self._lease.check_not_anothers(who)
        async with self._turn:
            later = {one.id for one in self.edits if one.id > version and not one.undone_s}
            if not later:
                raise Problem(409, NOTHING_TO_UNDO)
            await self._mark_undone(later, time.time(), f"map back to edit {version}", who)

    # steps of the above

    async def _mark_undone(self, numbers: set[int], when: float, words: str, who: Person) -> None:
        changed = (msgspec.structs.replace(one, undone_s=when) if one.id in numbers else one for one in self.edits)
        await self._change(tuple(changed), words, who)

    async def _change(self, edits: tuple[EditMark, ...], words: str, who: Person) -> None:
        """These are the edits from now on; a turn is carried out before, and saved with the whole map."""
        angle = _turned(edits) - _turned(self.edits)
        if angle:
            await self._turn_by(angle)
        try:
            change = partial(msgspec.structs.replace, edits=edits)
            await self._maps.mark(change, words, who, whole=bool(angle))
        except BaseException:
            if angle:
                await self._turn_by(-angle)
            raise

    async def _turn_by(self, angle: float) -> None:
        """Have the pilot turn the map, and wait for it. Raises Problem 409, 503."""
        pilot = self._dispatcher.pilot
        if pilot is None:
            raise Problem(503, Statement("pilot.not_running"))
        if self._maps.snapshot.floor.lost is not None:
            raise Problem(409, Statement("edits.lost"))
        before = self._maps.snapshot.floor.graph_revision
        self._dispatcher.cancel("cancelled", Statement("edits.turned"))
        pilot.turn_map(angle)
        end = time.monotonic() + TURNED_WITHIN_S
        while self._maps.snapshot.floor.graph_revision == before:
            if time.monotonic() > end:
                raise Problem(503, Statement("pilot.not_running"))
            await asyncio.sleep(TURN_LOOK_S)

    def _refresh(self) -> None:
        if self._dispatcher.pilot is not None:
            now = (one.now(self._maps.submaps) for one in self.edits)
            self._dispatcher.pilot.edit_map(MapEdits(tuple(edit for edit in now if edit is not None)))

    def _checked(
        self, kind: EditKind, points: list[tuple[float, float]], width: float, angle: float, who: Person
    ) -> EditMark:
        """An edit as it is kept, without its number. Raises BadInput."""
        if kind == "turn":
            if not 0.0 < abs(angle) <= math.pi:
                raise BadInput(Statement("edits.angle"))
            return EditMark(0, kind, angle_rad=angle, by=who.name, at_s=time.time())
        at = np.array(points, float).reshape(-1, 2)
        area = width == 0.0 or kind == "crop"
        sound = np.isfinite(at).all() and np.abs(at).max(initial=0.0) <= MAX_REACH_M
        if not (3 if area else 1) <= len(at) <= MAX_EDIT_POINTS or not sound:
            raise BadInput(Statement("edits.points", most=MAX_EDIT_POINTS))
        if not 0.0 <= width <= MAX_BRUSH_M:
            raise BadInput(Statement("edits.width", most=f"{MAX_BRUSH_M:g}"))
        rounded = tuple((round(float(x), 3), round(float(y), 3)) for x, y in at)
        anchor = anchor_at(at, self._maps.snapshot.floor.submaps)
        return EditMark(0, kind, rounded, 0.0 if area else width, 0.0, anchor, who.name, time.time())


def _turned(edits: tuple[EditMark, ...]) -> float:
    """How far [rad] all turns that hold have turned the map."""
    return sum(one.angle_rad for one in edits if not one.undone_s)
