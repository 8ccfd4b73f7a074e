"""Map operations of the operator: saved maps, the robot's place on the map, and the closures that hold."""

import asyncio
import contextlib
import logging
import math
import re
import secrets
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Literal, TypeVar

import msgspec
import numpy as np

from console.access.logins import Person
from console.control.dispatcher import REACHED, CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.http.problems import Problem
from console.maps.export import FLOOR, PREVIEW, known_part, write_map
from console.maps.join_worker import JoinWorker, TwoMaps
from console.maps.marks import MapMarks, put_together, read_marks, taken_again, write_marks
from console.maps.plan import PrintedPlan
from console.maps.store import MAX_NAME_LETTERS, MapInfo, MapStore, StoredMap, checked_name, key_of
from console.maps.trajectory import Trajectory, laid_out
from console.messages.map import MapState
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.job import Answer, Job
from console.workers.tasks import QueueLimit, to_the_end
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError, Refused
from core.files import checksum, saving, write_atomic
from core.geometry import Pose
from core.message import Array
from core.pilot.pilot import Pilot, parts_of
from core.pipelines.nav2_map import laid_out as cells_laid_out
from core.pipelines.nav2_map import read_nav2_zip
from core.pipelines.slam_report import landmarks_csv, trajectory_tum
from core.sensors import SensorFrame
from core.sentences import PageTexts, Statement
from core.settings import Settings
from core.slam.map.drawn_map import drawn_map
from core.slam.map.map_file import SavedMap, checked
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.outline import MapOutline, trace_outline
from core.slam.map.status import SubmapView
from core.slam.map_join import MapMatch
from core.snapshot import PilotAct, Snapshot

log = logging.getLogger(__name__)

T = TypeVar("T")

BEYOND_MAP_M = 10.0  # that a place or a zone may lie outside the known map
SAME_RESOLUTION_M = 1e-6  # by which two resolutions may differ
SAME_LASER_HEIGHT_M = 0.05  # by which the planes of two lasers may differ that see the same walls
UNSAVED_M = 0.3  # that the robot moves before its map is worth a question
LAST_MAP = "last map"  # what a console keeps that ends, and one that may be killed
LAST_BUT_ONE = "last map but one"  # what it was before the map in use
LAST_BUT_TWO = "last map but two"  # the same, while the last but one is in use
AUTOSAVE_PERIOD_S = 60.0
ITSELF = Person("console", "Beckon", "operator")
MAX_PACKERS = 4  # who packs or joins a map and those who wait for it
JOIN_BUDGET_S = 300.0  # of processor time
ENTER_TIMEOUT_S = 1.0  # for which a load waits until the pilot is in its map


@dataclass(frozen=True)
class JoinProposal:
    """Two saved maps, and where the newer one lies in the older one: shown, and joined when a person says so."""

    id: str
    older: StoredMap
    newer: StoredMap
    maps: TwoMaps
    found: MapMatch
    picture: bytes  # PNG


class MapService(Part):
    """Lives on the event loop; the disk is waited for in threads, one write after the other."""

    def __init__(
        self,
        home: Path,
        settings: Settings,
        robot: RobotSupervisor,
        dispatcher: CommandDispatcher,
        lease: Lease,
        history: History,
    ) -> None:
        self.trajectory = Trajectory()
        self._store = MapStore(home / "maps")
        self._settings, self._robot, self._dispatcher, self._lease = settings, robot, dispatcher, lease
        self._history = history
        self._newest: Snapshot | None = None
        self._pilot: Pilot | None = None  # whose map it is
        self._name: str | None = None  # of the saved map that it goes on in
        self.frame = ""  # of the axes of the map in use, as they were saved; "": in no saved map
        self._revision = 0
        self._turn = asyncio.Lock()  # of who writes the map in use, or brings another into use
        self._marking = asyncio.Lock()
        self._maps_used = 0  # how many maps were in use: a write notices that its own is not any more
        self._entering: SavedMap | None = None  # that the pilot is to go on in, and has not reached
        self._entered = asyncio.Event()
        self._packing = QueueLimit(MAX_PACKERS)
        self._clean = False
        self._kept_at: Pose | None = None  # where the robot was when its map was begun, saved or loaded
        self._unsaved = False
        self.kept_as = LAST_MAP  # name under which a map that would be lost is saved at the end
        self._autosaved_at: Pose | None = None  # where the robot was when its unsaved map was last kept
        self._traced: tuple[OccupancyGrid, MapOutline] | None = None  # the newest outline and of what
        self._earlier_kept = False  # the last map from before the one in use has its own name
        self.marks = MapMarks()  # of the map in use
        self.marks_revision = 0
        self.when_marked: list[Callable[[], None]] = []  # the marks are others, or lie elsewhere
        self._proposal: JoinProposal | None = None  # that was shown last
        self._worker = Worker("maps")
        self._redrawn = False  # edits were made since the saved map in use was written

    # state

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """The newest snapshot. Another pilot, or one whose clock began again, knows nothing of the former map."""
        former, self._newest = self._newest, snapshot
        went_back = former is not None and snapshot.stamp < former.stamp - 1e-6
        if went_back or self._dispatcher.pilot is not self._pilot:
            self._pilot = self._dispatcher.pilot
            self._use(None, "", MapMarks())
        if self._entering is not None and any(act is self._entering for act in _acts(snapshot)):
            self._entering = None
            self._entered.set()
            self.trajectory.forget()  # the poses since the load were still of the former map
            self._stands_kept()
        if former is not None and _layout(former) != _layout(snapshot):
            self._set_marks(self.marks)
        if self._kept_at is None:
            self._kept_at = snapshot.estimate.pose
        self._unsaved |= self._robot.profile.drives and self._moved_since(self._kept_at)
        self.trajectory.add(snapshot)

    @property
    def shown(self) -> MapState:
        return MapState(self._name, self._revision, self._unsaved, self.marks_revision)

    @property
    def snapshot(self) -> Snapshot:
        """The newest one. Raises Problem 503 while there is none."""
        if self._newest is None:
            raise Problem(503, "No frame of the robot has arrived yet.")
        return self._newest

    @property
    def submaps(self) -> tuple[SubmapView, ...]:
        """The submaps, where they are now; none while there is no snapshot."""
        return () if self._newest is None else self._newest.floor.submaps

    @property
    def grid(self) -> OccupancyGrid:
        """The map as it is now. Raises Problem 503 while there is none."""
        if self._newest is None or not (self._newest.grid.log_odds != 0).any():
            raise Problem(503, "There is no map yet; the robot is still looking around.")
        return self._newest.grid

    def check_near(self, points: Array) -> None:
        """Raise Problem 422 for points (N, 2) [m], world, that all lie far outside the map; 503 without one."""
        low = self.grid.origin - BEYOND_MAP_M
        high = low + 2 * BEYOND_MAP_M + self.grid.resolution * np.array(self.grid.log_odds.shape[::-1])
        if not np.isfinite(points).all() or (points.max(0) < low).any() or (points.min(0) > high).any():
            raise Problem(422, Statement("places.beyond", metres=f"{BEYOND_MAP_M:g}"))

    @property
    def outline(self) -> MapOutline:
        """The outline of the map as it is now, traced once a map. Raises Problem 503 while there is none."""
        grid = self.grid
        if self._traced is None or self._traced[0] is not grid:
            self._traced = (grid, trace_outline(grid))
        return self._traced[1]

    def plan_in(self, texts: PageTexts) -> PrintedPlan:
        """All that a plan of the map shows, in a language of the page. Raises Problem 503 while there is no map."""
        submaps = self.submaps
        places = tuple(place.now(submaps) for place in self.marks.places)
        zones = tuple(zone.now(submaps) for zone in self.marks.zones)
        return PrintedPlan(self.outline, self.titled(texts), places, zones)

    def titled(self, texts: PageTexts) -> str:
        """Return the line under a printed plan: name if it has one, robot, day."""
        named = (self._name,) if self._name else ()
        return " · ".join((*named, texts.said(self._robot.profile.name), time.strftime("%Y-%m-%d")))

    # saved maps

    async def all(self) -> list[MapInfo]:
        """Every saved map, the newest first."""
        return [kept.card for kept in await self._on_disk(self._listed())]

    async def save(self, name: str, who: Person, *, replace: bool) -> MapInfo:
        """Keep the map under a name. Raises BadInput, NameTaken, Unwritable, Problem 503.

        Refused where another map comes into use before this one is written.
        """
        named, number = checked_name(name), self._maps_used
        async with self._turn:
            card = await self._write(named, who, number, replace=replace)
            self._name = card.name
            self._stands_kept()
        self._changed("save", card.name, who)
        return card

    async def _write(self, name: str, who: Person, number: int, *, replace: bool) -> MapInfo:
        """Write the map in use, which is the one of this number; the turn is held. Raises as `save`."""
        self._check_in_use(number)
        grid, snapshot = self.grid, self.snapshot
        pilot, trajectory, marks = self._piloting(), self.trajectory.rows(), self.marks
        card = self._card(name, who, known_part(grid), len(snapshot.floor.submaps))
        self.frame = card.frame = self.frame or secrets.token_hex(8)
        card.landmarks = len(snapshot.landmarks)
        card.closures = sum(closure.state == "accepted" for closure in snapshot.floor.closures)

        def write() -> None:
            saved = pilot.keep_map()
            self._check_in_use(number)

            def fill(folder: Path) -> None:
                path = trajectory_tum(*laid_out(trajectory, snapshot.floor))
                write_map(folder, saved, grid, landmarks_csv(snapshot.landmarks), path)
                write_marks(folder, marks)

            self._store.keep(card, fill, replace=replace)

        await self._on_disk(to_the_end(write))
        self._check_in_use(number)
        return card

    def _check_in_use(self, number: int) -> None:
        """Raises Refused where another map has come into use since: what was asked for was of the former one."""
        if number != self._maps_used:
            raise Refused(Statement("pilot.other_map"))

    async def take_in(self, name: str, packed: bytes, who: Person, *, replace: bool) -> tuple[MapInfo, str]:
        """Keep a map as one to go on in: one that another robot of the site has saved, as `packed` made it, with its
        places, zones and routes; or a map of Nav2 or slam_toolbox, a zip of YAML and picture. The sentence says
        what in it may be meant otherwise; "": nothing.

        Raises BadInput with what is wrong in it, NameTaken, Unwritable, Problem 409, 503.
        """
        named, settings = checked_name(name), self._settings
        found = await asyncio.to_thread(self._store.unpacked, packed)
        if found is not None:
            return await self._take_over(named, *found, who, replace=replace), ""
        cells = await asyncio.to_thread(read_nav2_zip, packed)

        def draw() -> tuple[OccupancyGrid, SavedMap]:
            grid = cells_laid_out(cells, settings.occupancy.resolution)
            return grid, drawn_map(grid, settings.occupancy, settings.submaps)

        grid, saved = await asyncio.to_thread(draw)
        card = self._card(named, who, known_part(grid), saved.submaps)
        card.frame = checksum(packed)

        def fill(folder: Path) -> None:
            write_map(folder, saved, grid, landmarks_csv(()), "")
            write_marks(folder, MapMarks())

        await self._on_disk(self._taking_turns(lambda: self._store.keep(card, fill, replace=replace)))
        self._leave_replaced(card)
        self._changed("import", card.name, who)
        return card, cells.remark

    async def _take_over(
        self, name: str, other: MapInfo, files: dict[str, bytes], who: Person, *, replace: bool
    ) -> MapInfo:
        """Keep another robot's saved map as one of this robot. Raises as `take_in`.

        Taken again, it brings the marks that are new; in a map that is in use they hold at once.
        """
        self._check_fits(other)
        card = msgspec.structs.replace(
            other, name=name, saved_s=time.time(), by=who.name, robot=self._robot.profile.name
        )

        marks: list[MapMarks] = []

        def fill(folder: Path) -> None:
            (folder / FLOOR).mkdir()
            for each, content in files.items():
                write_atomic(folder / each, content)
            SavedMap.from_files(folder / FLOOR)
            marks.append(read_marks(folder))
            former = self._store.find(name)
            if former is not None and former.card.frame == card.frame != "":
                marks.append(taken_again(marks.pop(), read_marks(former.folder)))
                write_marks(folder, marks[0])

        await self._on_disk(self._taking_turns(lambda: self._store.keep(card, fill, replace=replace)))
        self._leave_replaced(card)
        if self._name == card.name and self.frame == card.frame != "":
            self._set_marks(marks[0])
        self._changed("import", card.name, who)
        return card

    def _leave_replaced(self, card: MapInfo) -> None:
        """Another map has the name of the one in use: that one goes on in no saved map."""
        if self._name is not None and key_of(self._name) == key_of(card.name):
            self._name = card.name if self.frame == card.frame != "" else None

    def _check_fits(self, card: MapInfo) -> None:
        """Raises Problem 409 for a map of other cells, or of a laser that sees other things than this robot's."""
        cell_m, laser = self._settings.occupancy.resolution, self._robot.profile.laser
        if abs(card.resolution_m - cell_m) > SAME_RESOLUTION_M:
            values = {"cells": f"{100 * card.resolution_m:g}", "here": f"{100 * cell_m:g}"}
            raise Problem(409, Statement("maps.other_cells", **values))
        height_m = card.laser_height_m
        if laser is not None and height_m is not None and abs(laser.height - height_m) > SAME_LASER_HEIGHT_M:
            values = {"height": f"{100 * height_m:.0f}", "here": f"{100 * laser.height:.0f}"}
            raise Problem(409, Statement("maps.other_height", **values))

    async def match(self, older: str, newer: str) -> JoinProposal:
        """Find where one saved map lies in another; nothing is changed. Raises BadInput, Problem 404, 429, 503."""
        async with self._packing.taken():
            one, two = await self.kept(older), await self.kept(newer)
            if one.folder == two.folder or one.card.resolution_m != two.card.resolution_m:
                raise BadInput(Statement("join.two_maps"))
            for each in (one, two):
                await self._on_disk(asyncio.to_thread(self._store.checked, each))
            maps = TwoMaps(str(one.folder / FLOOR), str(two.folder / FLOOR), parts_of(self._settings))
            drawn = await self._worked(JoinWorker.match(maps))
            self._proposal = JoinProposal(secrets.token_hex(4), one, two, maps, drawn.found, drawn.picture)
            return self._proposal

    def proposal(self, number: str, status: int = 409) -> JoinProposal:
        """The match that was shown last. Raises a Problem of this status for another one."""
        if self._proposal is None or self._proposal.id != number:
            raise Problem(status, Statement("join.gone"))
        return self._proposal

    async def join(self, number: str, name: str, who: Person) -> MapInfo:
        """Join the two maps of a match that was shown, as a new one; both stay as they are.

        Raises BadInput, NameTaken, Unwritable, Problem 404, 409, 503.
        """
        shown, named = self.proposal(number), checked_name(name)
        async with self._packing.taken():
            made = await self._worked(JoinWorker.join(shown.maps, shown.found))
        saved = checked(made.saved, named)
        card = self._card(named, who, known_part(made.grid), saved.submaps)
        card.landmarks, card.frame = sum(map(len, saved.facts.landmarks)), shown.older.card.frame

        def write() -> None:
            older, newer = read_marks(shown.older.folder), read_marks(shown.newer.folder)

            def fill(folder: Path) -> None:
                write_map(folder, saved, made.grid, landmarks_csv(()), "")
                write_marks(folder, put_together(older, newer, made.older_submaps))

            self._store.keep(card, fill, replace=False)

        await self._on_disk(self._taking_turns(write))
        self._proposal = None
        self._changed("join", card.name, who)
        return card

    async def _worked(self, job: Job[Answer]) -> Answer:
        """Have the worker do a job; it is there only meanwhile. Raises BadInput, Problem 503."""
        try:
            return await self._worker.ask(job, budget=JOIN_BUDGET_S)
        except WorkerLost as lost:
            raise Problem(503, str(lost)) from None
        finally:
            self._worker.kill()

    def _card(self, name: str, who: Person, grid: OccupancyGrid, submaps: int) -> MapInfo:
        """The card of a map that is kept now; `grid`: its known part."""
        rows, columns = grid.log_odds.shape
        laser = self._robot.profile.laser
        return MapInfo(
            name=name,
            saved_s=time.time(),
            by=who.name,
            robot=self._robot.profile.name,
            resolution_m=grid.resolution,
            width_m=round(columns * grid.resolution, 2),
            height_m=round(rows * grid.resolution, 2),
            submaps=submaps,
            landmarks=0,
            closures=0,
            laser_height_m=None if laser is None else laser.height,
        )

    async def close(self) -> None:
        """Save a map that would be lost; nothing is joined any more."""
        self._worker.kill()
        await self.keep_unsaved(self.kept_as)
        await self._worker.gone()

    async def keep_unsaved(self, name: str) -> None:
        """Save a map that would be lost, in the place of the one that was kept under this name before."""
        if not self._unsaved:
            return
        try:
            if name == LAST_MAP:
                await self._keep_earlier()
            await self.save(
                " ".join(re.findall(r"[\w-]+", name))[:MAX_NAME_LETTERS].rstrip(" -"), ITSELF, replace=True
            )
        except (BeckonError, Problem) as trouble:
            log.warning("The map could not be kept as %s: %s", name, trouble)

    async def run(self) -> None:
        """Keep an unsaved map while it grows: a console that is killed can keep nothing more."""
        while True:
            await asyncio.sleep(AUTOSAVE_PERIOD_S)
            await self.autosaved()
            try:
                await self._keep_redrawn()
            except (BeckonError, Problem) as trouble:
                log.warning("The edited map could not be written again: %s", trouble)

    async def autosaved(self) -> bool:
        """Keep an unsaved map that has grown as the last one → True when it was kept. It stays unsaved."""
        if not self._unsaved or not (self._autosaved_at is None or self._moved_since(self._autosaved_at)):
            return False
        here, number = self.snapshot.estimate.pose, self._maps_used
        try:
            await self._keep_earlier()
            async with self._turn:
                await self._write(LAST_MAP, ITSELF, number, replace=True)
                self._autosaved_at = here
        except (BeckonError, Problem) as trouble:
            log.warning("The map could not be kept as %s: %s", LAST_MAP, trouble)
            return False
        self._revision += 1
        return True

    async def load(self, name: str, who: Person) -> None:
        """Go on in a saved map. Raises Problem 404, 409, 503, BadInput."""
        async with self._turn:  # nobody replaces it while it is read
            kept = await self.kept(name)
            card, profile = kept.card, self._robot.profile
            if card.robot != profile.name:
                raise Problem(409, f"This map was made by “{card.robot}”; this robot is “{profile.name}”.")
            self._check_fits(card)
            saved = await self._on_disk(
                asyncio.to_thread(lambda: SavedMap.from_files(self._store.checked(kept) / FLOOR))
            )
            marks = await self._on_disk(asyncio.to_thread(read_marks, kept.folder))
            self._lease.check_not_anothers(who)
            self._entering = saved
            self._entered.clear()
            self._piloting().enter_map(saved)
            self._dispatcher.cancel("cancelled", Statement("pilot.other_map"))
            self._use(card.name, card.frame, marks)
            with contextlib.suppress(TimeoutError):  # a robot that sends no frames is not waited for
                async with asyncio.timeout(ENTER_TIMEOUT_S):
                    await self._entered.wait()
        self._changed("load", card.name, who)

    async def rename(self, name: str, to_name: str, who: Person) -> MapInfo:
        """Call a saved map otherwise. Raises BadInput, Problem 404, 409, 503, Unwritable."""
        kept, to_name = await self.kept(name), checked_name(to_name)

        def rename() -> None:
            other = self._store.find(to_name)
            if other is not None and other.folder != kept.folder:
                raise Problem(409, Statement("maps.taken", name=other.card.name))
            self._store.rename(kept, to_name)

        await self._on_disk(self._taking_turns(rename))
        if self._name == kept.card.name:
            self._name = to_name
        self._changed("rename", f"{kept.card.name} to {to_name}", who)
        return (await self.kept(to_name)).card

    async def delete(self, name: str, who: Person) -> None:
        """Away with a saved map. Raises Problem 404, 503, Unwritable."""
        kept = await self.kept(name)
        await self._on_disk(self._taking_turns(lambda: self._store.remove(kept)))
        if self._name == kept.card.name:
            self._name = None
        self._changed("delete", kept.card.name, who)

    async def kept(self, name: str) -> StoredMap:
        """The saved map of this name. Raises Problem 404."""
        kept = await self._on_disk(asyncio.to_thread(self._store.find, name))
        if kept is None:
            raise Problem(404, "There is no saved map of that name.")
        return kept

    async def packed(self, name: str) -> IO[bytes]:
        """A saved map as a zip on the disk. Raises Problem 404, 429, 503, BadInput, Unwritable."""
        await self._keep_redrawn()
        kept = await self.kept(name)
        async with self._packing.taken():
            return await self._on_disk(asyncio.to_thread(self._store.packed, kept))

    async def preview(self, name: str) -> bytes:
        """A small picture of a saved map. Raises Problem 404, 503."""
        kept = await self.kept(name)
        return await self._on_disk(asyncio.to_thread((kept.folder / PREVIEW).read_bytes))

    # what people marked on the map in use

    async def mark(
        self, change: Callable[[MapMarks], MapMarks], words: str, who: Person, *, whole: bool = False
    ) -> None:
        """Change the marks, and have them on the disk with their map, with a `whole` new one where that was turned.

        Raises what `change` raises, Unwritable, Problem 404, 503.
        """
        async with self._marking:
            before, frame = self.marks, self.frame
            marks = change(before)
            _ = self.grid  # a mark without a map means nothing
            self.frame = "" if whole else frame  # the axes were turned
            self._set_marks(marks)
            self._redrawn |= marks.edits != before.edits
            try:
                await self._keep_marks(marks, whole=whole)
            except BaseException:
                if self.marks is marks:
                    self.frame = frame
                    self._set_marks(before)
                raise
        self._history.add("map", who, words=words)

    async def _keep_marks(self, marks: MapMarks, *, whole: bool) -> None:
        """Have them with the saved map that is in use; a map without a name is kept as the last one."""
        name, number = self._name, self._maps_used
        if name is None:
            self._unsaved = True
            await self._keep_earlier()
        if name is None or whole:
            async with self._turn:
                await self._write(name or LAST_MAP, ITSELF, number, replace=True)
            self._revision += 1
            return

        def write() -> None:
            self._check_in_use(number)
            kept = self._store.find(self._name or name)  # it may have another one by now
            if kept is None:
                raise FileNotFoundError(name)
            with saving("The places could not be saved, and nothing was changed"):
                write_marks(kept.folder, marks)

        await self._on_disk(self._taking_turns(write))

    async def _keep_redrawn(self) -> None:
        """The pictures of the saved map that is in use show its newest edits from now on."""
        redrawn, self._redrawn, number = self._redrawn, False, self._maps_used
        if not redrawn:
            return
        try:
            async with self._turn:
                if self._name is not None:  # under the name that it has by now
                    await self._write(self._name, ITSELF, number, replace=True)
                    self._revision += 1
        except BaseException:
            self._redrawn |= number == self._maps_used
            raise

    def _set_marks(self, marks: MapMarks) -> None:
        """These hold from now on, where the map is now: all parts know them at once."""
        self.marks = marks
        self.marks_revision += 1
        for tell in self.when_marked:
            tell()

    # the map that is in use

    def change_closure(self, number: int, what: Literal["undo", "redo"], who: Person) -> None:
        """A closure does not hold: rooms go back to where they would be without it; or it does. Raises Problem."""
        found = next((closure for closure in self.snapshot.floor.closures if closure.id == number), None)
        if found is None:
            raise Problem(404, "There is no such closure.")
        if what == "undo" and found.state == "undone":
            raise Problem(409, "That closure is undone already.")
        if what == "redo" and found.state != "undone":
            raise Problem(409, "That closure is not undone; there is nothing to take back.")
        self._lease.check_not_anothers(who)
        self._piloting().believe_closure(number, believed=what == "redo")
        self._history.add("closure", who, words=f"{what} {number}")

    def here(self, x: float, y: float, heading: float | None, who: Person, *, force: bool) -> None:
        """The robot is at (x, y) [m], world, and looks to `heading` [rad] or nobody knows where. Raises Problem."""
        if not self._robot.profile.drives:
            raise Problem(409, "This is a recording; its place cannot be set.")
        if self.snapshot.floor.lost is None and not force:
            raise Problem(409, "The robot is not lost; it knows where it is.")
        if self._robot.link()[0] not in REACHED:
            raise Problem(503, self._robot.trouble or Statement("robot.unreached"))
        self._lease.check_not_anothers(who)
        self._piloting().place_at(x, y, heading)
        self._dispatcher.cancel("cancelled", "The robot's place was set.")
        self._history.add("here", who, words=f"I am at {x:.2f} and {y:.2f}")

    # steps of the above

    def _use(self, name: str | None, frame: str, marks: MapMarks) -> None:
        """Another map is in use from now on: the saved one of this name, or one that begins now."""
        self._maps_used += 1
        self._name, self.frame = name, frame
        self._redrawn = self._earlier_kept = False
        self.trajectory.forget()
        self._stands_kept()
        self._set_marks(marks)

    def _stands_kept(self) -> None:
        """The map as it is now is on the disk, or is not worth it."""
        self._kept_at, self._autosaved_at, self._unsaved = None, None, False

    def _moved_since(self, pose: Pose) -> bool:
        moved = pose.inverse() @ self.snapshot.estimate.pose
        return math.hypot(moved.x, moved.y) > UNSAVED_M

    async def _keep_earlier(self) -> None:
        """Before the map in use is first kept as the last one: the one that is there gets a name of its own."""
        if self._earlier_kept:
            return
        used = key_of(self._name or "")

        def rename() -> None:
            found = self._store.find(LAST_MAP)
            if found is not None and used != LAST_MAP:
                self._store.rename(found, LAST_BUT_TWO if used == LAST_BUT_ONE else LAST_BUT_ONE)

        await self._on_disk(self._taking_turns(rename))
        self._earlier_kept = True

    def _piloting(self) -> Pilot:
        if self._dispatcher.pilot is None:
            raise Problem(503, Statement("pilot.not_running"))
        return self._dispatcher.pilot

    async def _listed(self) -> list[StoredMap]:
        if not self._clean:
            self._clean = True
            await self._taking_turns(self._store.clean)
        return await asyncio.to_thread(self._store.all)

    async def _taking_turns(self, work: Callable[[], None]) -> None:
        """A write in a thread; who is cancelled meanwhile keeps the turn until it is done."""
        async with self._turn:
            await to_the_end(work)

    async def _on_disk(self, work: Awaitable[T]) -> T:
        """Work on the disk. Raises Problem 404 or 503 where it cannot be read, and what the work raises."""
        try:
            return await work
        except FileNotFoundError:
            raise Problem(404, "There is no saved map of that name any more.") from None
        except OSError as wrong:
            raise Problem(503, f"The saved maps cannot be read ({wrong.strerror or wrong}).") from None

    def _changed(self, what: str, name: str, who: Person) -> None:
        self._revision += 1
        self._history.add("map", who, words=f"{what} {name}")


def _acts(snapshot: Snapshot) -> tuple[PilotAct, ...]:
    return () if snapshot.inputs is None else snapshot.inputs.acts


def _layout(snapshot: Snapshot) -> list[tuple[int, Pose]]:
    return [(one.id, one.pose) for one in snapshot.floor.submaps]
