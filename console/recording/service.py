"""The recorder: what the robot senses and does, written by a process of its own; the last minutes can be kept."""

import asyncio
import contextlib
import json
import logging
import math
import pickle
import re
import shutil
import stat
import time
import unicodedata
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import msgspec
import numpy as np

from console import beckon_version
from console.access.logins import Person
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from console.recording import work
from console.recording.events import DriveEvents
from console.robot.supervisor import RobotSupervisor
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError, Refused, Unwritable
from core.files import reason, replacing, saving, write_atomic
from core.pilot.pilot import Pilot
from core.pilot.trail import NO_POINTS
from core.pipelines.drive_film import FilmForm
from core.recording.frame_record import TurnAct
from core.recording.mcap_writing import PART
from core.recording.settings import RecordingSettings
from core.robots import Profile
from core.robots.profile_json import profile_to_json
from core.sensors import SensorFrame
from core.sentences import Statement
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

NO_LASER = np.zeros((0, 3))
NO_GRID = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))
FOLDER, NOTES = "recordings", "recordings.json"  # in the data folder
ENDING = ".mcap"
MAX_NAME_LETTERS, MAX_NOTE_LETTERS = 80, 2000
MAX_NAME_BYTES = 235  # of a file's 255, for its endings and a number
NAME = re.compile(r"[\w][\w .-]*")
NO_NAME = re.compile(r"^[^\w]|[^\w .-]")  # letters of a file of elsewhere that a name cannot have
BATCH_PERIOD_S = 0.25  # [s] between two batches for the recorder's process
RING_PERIOD_S = 1.0  # [s] of the same where only the last minutes are held
FOXGLOVE_PERIOD_S = 0.05  # [s] of the same where other programs watch live
IDLE_PERIOD_S = 0.5  # [s] of the same where nothing comes
BATCH_BUDGET_S, FILE_BUDGET_S = 5.0, 120.0  # [s] of processor time
MAX_WAITING_MOMENTS = 400  # frames that may wait; more are left out, with a notice
MAP_PERIOD_S = 2.0  # [s] between two maps, at least
WHOLE_MAP_PERIOD_S = 20.0  # [s] between two maps to go on in, at least …
WHOLE_MAP_BYTES_S = 50_000  # … and of them in a second of the recording, at most
RING_DELAY_S = 5.0  # [s] after the first motion: its start must not be what slows that
RING_REST_S = 20.0  # [s] after the first frame, where nothing moves before
AFTER_INCIDENT_S = 3.0  # [s] that are still kept after what caused it
INCIDENT_PAUSE_S = 30.0  # [s] until another one is kept by itself
DISK_PERIOD_S = 2.0  # [s] between two looks at the disk
BYTES_PER_MB = 1e6
NEARLY_FULL = 0.9  # of the folder, from which on it is said which recording goes next
RUNS = Statement("recording.runs")
NOTHING_YET = Statement("recording.nothing_yet")
KEPT_BY = Statement("recording.kept_by")
CUT = Statement("recording.cut")
LOST = Statement("recording.lost")
OLD_GOES, NEXT_GOES = Statement("recording.old_goes"), Statement("recording.next_goes")
RECOVERED = Statement("recording.was_recovered")
KEPT = Statement("recording.kept")


class RecordingNote(msgspec.Struct):
    note: str = ""


class RecordingState(msgspec.Struct, frozen=True):
    """The recorder as the page shows it."""

    name: str | None  # of the recording that runs
    path: str
    seconds: float
    bytes: int
    started_s: float
    messages: dict[str, int]
    ring_s: float  # [s] that can be kept now


class RecordingService(Part):
    """Lives on the event loop."""

    def __init__(
        self,
        home: Path,
        settings: RecordingSettings,
        robot: RobotSupervisor,
        history: History,
        notifications: Notifications,
        lease: Lease,
        attached: tuple[Path, ...] = (),
    ) -> None:
        """`attached`: files and folders of the data folder that go into every recording."""
        self._lease = lease
        self._folder, self._notes_file = home / FOLDER, home / NOTES
        self._settings, self._robot, self._history, self._notifications = settings, robot, history, notifications
        self._attached = attached
        self._worker, self._cutter = Worker("recorder"), Worker("recorder")  # reading a file holds up no recording
        self._described = self._writes = 0  # start of the worker that knows the robot, that writes the file
        self._moments: list[work.RecordedMoment] = []
        self._left_out = 0
        self._unfinished = False  # a file waits to be recovered
        self._keeps = ""  # name of the part of the drive that is being kept
        self._events = DriveEvents(robot.status())
        self._pilot: Pilot | None = None
        self._running: work.FinishedRecording | None = None
        self._base, self._number = "", 1  # name of the recording that runs, and of its file
        self._began = 0.0  # [s] monotonic, of its file
        self._unix_from_monotonic = 0.0  # [s]; a recording keeps the one that it began with
        self._listens = False  # readings go to the recorder's process
        self._listened = 0.0  # [s] monotonic, since when
        self._moved = False  # the robot has
        self._ring_from = math.inf  # [s] monotonic, when the ring begins
        self._known: dict[tuple[str, float], work.FinishedRecording] = {}  # by name and time of change
        self._notes: dict[str, RecordingNote] = {}
        self._deletes = True  # the oldest files where all are too large; not where nobody knows which have a note
        self._turn, self._change = asyncio.Lock(), asyncio.Lock()  # of the process; of what begins and ends
        self._noting, self._cutting = asyncio.Lock(), asyncio.Lock()  # of who writes the notes; has a file made
        self._map_at = self._disk_at = -1e9
        self._grid = self._voice = -1
        self._whole_map = b""  # to go on in, for the next moment
        self._whole_map_due = -math.inf  # [s] monotonic
        self._seen = -1e9  # [s] stamp of the newest view
        self._used: Profile | None = None  # the robot as calibrated
        self._incident: tuple[float, str] | None = None  # [s] monotonic when it is kept, and why
        self._kept_at = -1e9
        self._goes_next = ""  # name of the recording of which that was said
        self._roomy = -1  # revision of the list when the folder's size was looked at
        self._wake = asyncio.Event()
        self.revision = 0  # of the list of recordings
        self.foxglove_port = 0  # where Foxglove and others watch live; 0: nowhere

    # life

    async def open(self) -> None:
        """Read the notes; finish what a former console left behind."""
        self._notes = await asyncio.to_thread(self._read_notes)
        if await asyncio.to_thread(self._parts):
            await self._recover()
            self._worker.kill()
        if self._settings.from_start and not self._replays:
            try:
                await self._begin_first_of("", "")
            except (BeckonError, Problem) as trouble:
                self._notifications.tell("error", Statement("recording.not_begun", trouble=trouble), "recorder")

    async def _recover(self) -> None:
        """Finish what a lost process left behind, once nothing is recorded and no process writes it."""
        try:
            async with self._turn:
                if self._running is not None:
                    return
                self._unfinished = False
                found = await self._worker.ask(work.RecoverRecordings(str(self._folder)), budget=FILE_BUDGET_S)
        except BeckonError as trouble:
            self._notifications.tell("warning", Statement("recording.unrecovered", trouble=trouble), "recovery")
            return
        self.revision += 1
        for one in found:
            if one.complete:
                self._notifications.tell("info", RECOVERED(name=one.name, seconds=f"{one.seconds:.0f}"), "recovery")
            else:
                self._unfinished = True

    async def run(self) -> None:
        """Send what came to the recorder's process, and look at the disk."""
        while True:
            with contextlib.suppress(TimeoutError):  # where nothing comes, what came last is written all the same
                rests = self._running is None and not self._unfinished
                async with asyncio.timeout(None if rests else IDLE_PERIOD_S):
                    await self._wake.wait()
            await asyncio.sleep(self._batch_period)
            self._wake.clear()
            await asyncio.shield(self._send())  # a console that ends meanwhile would end the recorder
            if self._unfinished:
                await self._recover()
            try:
                await self._after_batch(time.monotonic())
            except OSError as trouble:  # of the folder; what is written is not concerned
                self._notifications.tell("error", Statement("recording.folder", trouble=reason(trouble)), "recorder")

    @property
    def _batch_period(self) -> float:
        """Time [s] over which what comes is gathered: to wake a process costs more than what it gets."""
        if self.foxglove_port:
            return FOXGLOVE_PERIOD_S
        return RING_PERIOD_S if self._running is None else BATCH_PERIOD_S

    async def close(self) -> None:
        if self._running is not None:
            try:
                await self.stop()
            except (BeckonError, Problem) as trouble:
                log.warning("The recording could not be finished: %s", trouble)
        for worker in (self._worker, self._cutter):
            worker.kill()
            await worker.gone()

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Take a frame and what was made of it, once the ring has begun or something is recorded."""
        self._begin_ring(time.monotonic(), moves=bool(snapshot.setpoint.v or snapshot.setpoint.w))
        acts = () if snapshot.inputs is None else snapshot.inputs.acts
        self._used = next((act for act in reversed(acts) if isinstance(act, Profile)), self._used)
        if not self._listens or (self._replays and not self.foxglove_port):
            return
        if why := self._events.take(snapshot, self._notifications.shown, self._robot.status()):
            now = time.monotonic()
            if self.ring_limit_s > 0 and self._incident is None and now - self._kept_at > INCIDENT_PAUSE_S:
                self._incident = (now + AFTER_INCIDENT_S, why)  # the ring is kept in a moment
        if len(self._moments) >= MAX_WAITING_MOMENTS:
            self._left_out += 1
            return
        self._moments.append(self._moment(snapshot, frame))
        self._wake.set()

    def equip(self, pilot: Pilot) -> None:
        """Its map goes into what is recorded."""
        self._pilot, self._whole_map_due = pilot, -math.inf

    def _begin_ring(self, now: float, *, moves: bool) -> None:
        """Listen for the ring: some time after the start, but never with the first motion."""
        if self._listens:
            return
        if self.ring_limit_s > 0 and (self._ring_from == math.inf or (moves and not self._moved)):
            self._moved, self._ring_from = moves, now + (RING_DELAY_S if moves else RING_REST_S)
        if self._running is not None or self.foxglove_port or now > self._ring_from:
            self._listens, self._listened = True, now

    def _moment(self, snapshot: Snapshot, frame: SensorFrame) -> work.RecordedMoment:
        stamp, view, holder = snapshot.stamp, snapshot.view, self._lease.holder
        if any(isinstance(act, SavedMap | TurnAct) for act in (snapshot.inputs.acts if snapshot.inputs else ())):
            self._whole_map_due = -math.inf
        whole_map, self._whole_map = self._whole_map, b""
        map_is_new = snapshot.grid.revision != self._grid and not 0 <= stamp - self._map_at < MAP_PERIOD_S
        if map_is_new:
            self._grid, self._map_at = snapshot.grid.revision, stamp
        view_is_new = view is not None and view.stamp != self._seen
        self._seen = self._seen if view is None else view.stamp
        azimuth, voices = None, () if snapshot.hearing is None else snapshot.hearing.voices
        if voices and voices[0].id != self._voice:
            azimuth, self._voice = voices[0].azimuth, voices[0].id
        now = time.monotonic()
        if self._running is None:
            self._unix_from_monotonic = time.time() - now
        at = min(frame.sensed or now, now)
        return work.RecordedMoment(
            at=at,
            logged=self._unix_from_monotonic + at,
            snapshot=slimmed(snapshot, with_map=map_is_new),
            gate=self._robot.status(),
            operator="" if holder is None else holder.name,
            map_is_new=map_is_new,
            view_is_new=view_is_new,
            azimuth=azimuth,
            whole_map=whole_map,
            texts=self._events.taken(),
        )

    async def _take_whole_map(self) -> None:
        """Take the map that what is computed later goes on in; its cells and landmarks are written with it."""
        pilot = self._pilot
        if pilot is None:
            return
        with contextlib.suppress(Refused):  # there is none yet
            self._whole_map = await asyncio.to_thread(lambda: pilot.keep_map().to_bytes())
            self._grid, self._map_at = -1, -1e9
            period = max(WHOLE_MAP_PERIOD_S, len(self._whole_map) / WHOLE_MAP_BYTES_S)
            self._whole_map_due = time.monotonic() + period

    # events

    def heard(self, words: str, verdict: str, command: str | None) -> None:
        if self._listens:
            self._events.heard(words, verdict, command)

    def note(self, words: str, remark: str) -> None:
        if self._listens:
            self._events.note(words, remark)

    # recording

    @property
    def ring_limit_s(self) -> float:
        """The longest part of a drive [s] that is held in memory; 0: none is."""
        return 0.0 if self._replays else self._settings.ring_s

    @property
    def _replays(self) -> bool:
        return "replay" in self._robot.profile.capabilities

    @property
    def state(self) -> RecordingState:
        one, now = self._running, time.monotonic()
        ring_s = min(now - self._listened, self.ring_limit_s) if self._listens else 0.0
        if one is None:
            return RecordingState(None, "", 0.0, 0, 0.0, {}, ring_s)
        path = str(self._path(one.name)) + PART
        return RecordingState(one.name, path, one.seconds, one.bytes, one.started_s, one.messages, ring_s)

    async def start(self, name: str | None, note: str, who: Person) -> RecordingState:
        """Begin a recording. Raises BadInput, Problem 409, Unwritable."""
        if self._replays:
            raise Problem(409, Statement("recording.replay"))
        async with self._change:
            if self._running is not None:
                raise Problem(409, RUNS)
            await self._begin_first_of(bare_name(name) if name else "", note)
        self._history.add("record", who, words=self._base)
        return self.state

    async def _begin_first_of(self, name: str, note: str) -> None:
        """Begin the first file of a recording; "": its name is the date."""
        self._base, self._number = await self._begin(name, note), 1

    async def _begin(self, wanted: str, note: str = "") -> str:
        """Begin a file of this name, or of one like it, "": the date → its name."""
        await asyncio.to_thread(self._make_folder)
        await self._take_whole_map()  # the file begins with it
        self._listens, self._listened = True, self._listened or time.monotonic()
        async with self._turn:
            if self._running is not None:  # another one has begun while this one waited
                raise Problem(409, RUNS)
            await self._ready()
            name = self._fresh_name(wanted)
            job = work.BeginRecording(str(self._path(name)), self._description("", note), await self._files())
            await self._worker.ask(job, budget=FILE_BUDGET_S)
            self._writes = self._worker.starts
            self._running = work.FinishedRecording(
                name, 0.0, 0, {}, time.time(), complete=False, note=note, robot=self._robot.profile.name
            )
        self.revision += 1
        self._began = time.monotonic()
        if note:
            try:
                await self._set_note(name, note)
            except Unwritable as trouble:  # it records all the same, and the note stands in the file
                self._notifications.tell("warning", str(trouble), "recorder")
        await self._send()  # what came while the process started is in its hands before it is said that it records
        return name

    async def stop(self, who: Person | None = None) -> work.FinishedRecording:
        """End the recording → the finished file. Raises Problem 409, Unwritable, WorkerLost."""
        async with self._change:
            return await self._stopped(who)

    async def stop_own(self, name: str, who: Person) -> None:
        """End the recording that began under this name, where nobody has ended it before. Raises as `stop`."""
        async with self._change:
            if self._running is not None and self._base == name:
                await self._stopped(who)

    async def _stopped(self, who: Person | None) -> work.FinishedRecording:
        done = await self._stop(who)
        self._listens = self.ring_limit_s > 0 or self.foxglove_port > 0
        return done

    async def _stop(self, who: Person | None = None) -> work.FinishedRecording:
        if self._running is None:
            raise Problem(409, Statement("recording.nothing_runs"))
        await self._send()
        running, self._running = self._running, None
        try:
            async with self._turn:
                done = await self._worker.ask(work.FinishRecording(), budget=FILE_BUDGET_S)
        except BeckonError:
            self._unfinished = True
            self._wake.set()
            raise
        self.revision += 1
        if who is not None:
            self._history.add("stop_recording", who, words=done.name)
        return msgspec.structs.replace(done, started_s=running.started_s, note=running.note)

    async def keep(self, seconds: float, cause: str, who: Person | None = None) -> work.FinishedRecording:
        """Save the last part of the drive as a recording of its own. Raises Problem 409, Unwritable."""
        if self.ring_limit_s <= 0 or not self._listens:
            raise Problem(409, NOTHING_YET if self.ring_limit_s > 0 else Statement("recording.nothing_held"))
        await self._send()
        await asyncio.to_thread(self._make_folder)
        async with self._turn:
            await self._ready()
            self._keeps = name = self._fresh_name("")
            described = self._description(cause, "")
            job = work.KeepRing(str(self._path(name)), seconds, described, await self._files())
            kept = await self._worker.ask(job, budget=FILE_BUDGET_S)
        self.revision += 1
        if who is not None:
            self._history.add("keep_recording", who, words=name)
        return msgspec.structs.replace(kept, **work.with_cause(cause))

    async def _send(self) -> None:
        moments, self._moments = self._moments, []
        if self._left_out:
            self._notifications.tell("warning", Statement("recording.left_out", count=self._left_out), "recorder")
            self._left_out = 0
        if self._running is not None and not (self._worker.alive and self._worker.starts == self._writes):
            self._lost("its process has ended.")
        if not moments and self._running is None:
            return
        try:
            async with self._turn:
                await self._ready()
                packed = await asyncio.to_thread(pickled, moments)
                written = await self._worker.ask(work.RecordMoments(packed), budget=BATCH_BUDGET_S)
        except BeckonError as trouble:
            self._lost(str(trouble))
            return
        if self._running is not None and written is not None:
            facts = {"seconds": written.seconds, "bytes": written.bytes, "messages": written.messages}
            self._running = msgspec.structs.replace(self._running, **facts)

    def _lost(self, trouble: str) -> None:
        self._listened = time.monotonic()
        if self._running is not None:
            self._running, self._unfinished = None, True
            self.revision += 1
            self._notifications.tell("error", LOST(trouble=trouble), "recorder")

    async def _ready(self) -> None:
        if self._worker.alive and self._described == self._worker.starts:
            return
        profile = self._robot.profile
        built, used = profile_to_json(profile), profile_to_json(self._used or profile)
        await self._worker.ask(work.DescribeRobot(built, used, self.ring_limit_s), budget=FILE_BUDGET_S)
        self._described = self._worker.starts
        if self.foxglove_port:
            try:
                await self._worker.ask(
                    work.ServeFoxglove(self.foxglove_port, f"Beckon: {profile.name}"), budget=FILE_BUDGET_S
                )
            except BeckonError as trouble:
                self.foxglove_port = 0
                self._notifications.tell("error", str(trouble), "foxglove")

    async def _after_batch(self, now: float) -> None:
        if self._listens and now > self._whole_map_due and not self._replays:
            await self._take_whole_map()
        if self._incident is not None and now > self._incident[0]:
            why, self._incident, self._kept_at = self._incident[1], None, now
            try:
                kept = await self.keep(self._settings.ring_s, why)
                words = KEPT(seconds=f"{kept.seconds:.0f}", name=kept.name, cause=why)
                self._notifications.tell("info", words, "kept")
            except (BeckonError, Problem) as trouble:
                self._notifications.tell("warning", Statement("recording.not_kept", trouble=trouble), "kept")
        if now - self._disk_at < DISK_PERIOD_S or (self._running is None and self._roomy == self.revision):
            return
        self._disk_at, self._roomy = now, self.revision
        if self._running is not None:
            await self._look_at_file(now)
        await self._make_room()

    async def _look_at_file(self, now: float) -> None:
        free = await asyncio.to_thread(lambda: shutil.disk_usage(self._folder).free / BYTES_PER_MB)
        if free < self._settings.free_mb:
            await self._end(Statement("recording.low_disk", free=f"{free:.0f}"))
            return
        size = 0 if self._running is None else self._running.bytes
        long = now - self._began > 60 * self._settings.file_minutes or size > BYTES_PER_MB * self._settings.file_mb
        if long:
            await self._rotate()

    async def _end(self, why: str) -> None:
        try:
            await self.stop()
        except (BeckonError, Problem) as trouble:
            why = f"{why} {trouble}"
        self._notifications.tell("error", why, "recorder")

    async def _rotate(self) -> None:
        try:
            async with self._change:  # nobody begins or ends one between the two files
                done = await self._stop()
                self._number += 1
                await self._begin(fitted(self._base, f" part {self._number}"), done.note)
        except (BeckonError, Problem) as trouble:
            self._notifications.tell("error", f"The recording has ended: {trouble}", "recorder")

    async def _make_room(self) -> None:
        """Delete the oldest files that nobody gave a note while all are too large, and say before which is next."""
        if not self._deletes:
            return
        most, files = 1e9 * self._settings.folder_gb, await asyncio.to_thread(self._sizes)
        total = sum(size for _, _, size in [*files, *await asyncio.to_thread(self._parts)])
        for name, _, size in sorted(files, key=lambda one: one[1]):
            if total <= NEARLY_FULL * most:
                return
            if self._notes.get(name, RecordingNote()).note:
                continue
            if total <= most:
                if name != self._goes_next:
                    self._goes_next = name
                    self._notifications.tell("warning", NEXT_GOES(name=name), "recorder")
                return
            await asyncio.to_thread(self._path(name).unlink, missing_ok=True)
            self._notifications.tell("warning", OLD_GOES(name=name), "recorder")
            self.revision += 1
            total -= size

    # kept recordings

    async def all(self) -> list[work.FinishedRecording]:
        """Every recording, the newest first, with the one that runs."""
        found: list[work.FinishedRecording] = []
        for name, changed, size in await asyncio.to_thread(self._sizes):
            one = await self._looked_at(name, changed, size)
            note = self._notes.get(name, RecordingNote(one.note)).note
            cut = {} if one.complete else work.with_cause(CUT)
            found.append(msgspec.structs.replace(one, note=note, file=self._path(name).name, **cut))
        running = self._running
        for name, changed, size in await asyncio.to_thread(self._parts):
            if name not in (running and running.name, self._keeps):
                left = work.FinishedRecording(name, 0.0, size, {}, changed, complete=False)
                found.append(msgspec.structs.replace(left, **work.with_cause(Statement("recording.recovering"))))
        if running is not None:
            found.append(msgspec.structs.replace(running, **work.with_cause(Statement("recording.records"))))
        return sorted(found, key=lambda one: one.started_s, reverse=True)

    async def _looked_at(self, name: str, changed: float, size: int) -> work.FinishedRecording:
        """Describe a file. It is read once, or again where its reader was not to blame."""
        path, known = self._path(name), self._known.get((name, changed))
        if path.suffix != ENDING:  # its reader judges it when it is opened
            known = work.FinishedRecording(name, 0.0, size, {}, changed)
        if known is not None:
            return known
        try:  # beside the recorder: what a stranger wrote may break who reads it
            read = await self._cutter.ask(work.ReadRecording(str(path)), budget=FILE_BUDGET_S)
        except BeckonError as trouble:
            unread = work.with_cause(Statement("recording.unread", trouble=trouble))
            read = work.FinishedRecording(name, 0.0, size, {}, changed, **unread)
            if isinstance(trouble, WorkerLost) and trouble.killed:
                return read
        self._known[name, changed] = read
        return read

    def file(self, name: str) -> Path:
        """The file of a finished recording. Raises Problem 404."""
        path = self._path(name) if NAME.fullmatch(name) else None
        if path is None or not path.is_file():
            raise Problem(404, Statement("recording.unknown"))
        return path

    async def picture(self, name: str) -> bytes:
        """A small picture of a finished recording, as a JPEG. Raises Problem 404 where it has none."""
        job = work.PictureRecording(str(await asyncio.to_thread(self.file, name)))
        picture = await self._cutter.ask(job, budget=FILE_BUDGET_S)
        if not picture:
            raise Problem(404, Statement("recording.no_picture"))
        return picture

    async def cut(self, path: Path, begin_s: float, end_s: float, who: Person) -> work.FinishedRecording:
        """Save a part of a finished recording as one of its own. Raises BadInput, Unwritable."""
        await asyncio.to_thread(self._make_folder)
        place = f" {begin_s:.0f}-{end_s:.0f} s"
        async with self._cutting:
            fresh = self._fresh_name(NO_NAME.sub("-", path.stem)[: MAX_NAME_LETTERS - len(place)] + place)
            job = work.CutRecording(str(path), str(self._path(fresh)), begin_s, end_s)
            done = await self._cutter.ask(job, budget=FILE_BUDGET_S)
        self.revision += 1
        if done.note:
            await self._set_note(done.name, done.note)
        self._history.add("keep_recording", who, words=fresh)
        return done

    async def film(self, path: Path, begin_s: float, end_s: float, form: FilmForm) -> bytes:
        """A film of a part of a finished recording. Raises BadInput, Unavailable."""
        return await self._cutter.ask(work.FilmRecording(str(path), begin_s, end_s, form), budget=FILE_BUDGET_S)

    async def take_in(self, file: str, content: bytes, who: Person) -> str:
        """Keep a recording that was made elsewhere, as it came → the name of its file.

        Its reader judges it when it is opened. Raises BadInput, Problem 409, 507, Unwritable.
        """
        path = self._folder / checked_name(file)
        if not content:
            raise BadInput(Statement("recording.empty", name=path.name))

        def write() -> float:
            with saving("The recording could not be kept"):
                with replacing(path, lambda: self._check_free(path.name)) as file:
                    file.write(content)
                return path.stat().st_mtime

        self._check_free(path.name)
        await self._check_room()
        changed, name = await asyncio.to_thread(write), path.name.removesuffix(ENDING)
        self.revision += 1
        if note := (await self._looked_at(name, changed, len(content))).note:
            await self._set_note(name, note)
        self._history.add("keep_recording", who, words=path.name)
        return path.name

    async def sample(self, sample: str, who: Person) -> str:
        """Record a sample, unless it was before → the name of its file. Raises Unwritable, Problem 507."""
        path = self._path(f"sample {sample}")
        async with self._cutting:
            if not await asyncio.to_thread(path.exists):
                await self._check_room()
                await self._cutter.ask(work.MakeSample(sample, str(path)), budget=FILE_BUDGET_S)
                self.revision += 1
                self._history.add("keep_recording", who, words=path.stem)
        return path.name

    async def _check_room(self) -> None:
        """Make the folder. Raises Problem 507 where the disk takes no more."""
        await asyncio.to_thread(self._make_folder)
        free = await asyncio.to_thread(lambda: shutil.disk_usage(self._folder).free / BYTES_PER_MB)
        if free < self._settings.free_mb:
            raise Problem(507, Statement("recording.no_room", free=f"{free:.0f}"))

    async def rewrite(self, name: str, note: str | None, new_name: str | None) -> None:
        """Give a recording another note, or another name. Raises BadInput, Problem 404, 409, Unwritable."""
        path = self.file(name)
        if note is not None and len(note) > MAX_NOTE_LETTERS:
            raise BadInput(f"A note has at most {MAX_NOTE_LETTERS} letters.")
        if new_name is not None and (fresh := bare_name(new_name)) != name:
            if path.name == name:  # of another form, which its ending may say
                fresh = fresh if fresh.endswith(path.suffix) else f"{fresh}{path.suffix}"
            ending = "" if path.name == name else ENDING
            async with self._turn:  # nobody takes the name between the look and the change
                self._check_free(fresh)
                with saving("The recording could not be renamed"):
                    await asyncio.to_thread(path.rename, path.with_name(f"{fresh}{ending}"))
            self.revision += 1
            before = self._notes.pop(name, None)
            note = before.note if note is None and before is not None else note
            name = fresh
        if note is not None:
            await self._set_note(name, note)
        self.revision += 1

    async def delete(self, name: str, who: Person) -> None:
        """Remove a recording. Raises Problem 404, Unwritable."""
        path = self.file(name)
        with saving("The recording could not be deleted"):
            await asyncio.to_thread(path.unlink)
        if self._notes.pop(name, None) is not None:
            await self._save_notes()
        self.revision += 1
        self._history.add("delete_recording", who, words=name)

    # files

    def _path(self, name: str) -> Path:
        """The file of a recording; one of another form than ours has the whole name."""
        whole = self._folder / name
        return whole if whole.suffix != ENDING and whole.is_file() else self._folder / f"{name}{ENDING}"

    def _fresh_name(self, wanted: str) -> str:
        base = wanted or datetime.now().astimezone().strftime("%Y-%m-%d %H.%M.%S")
        name, number = base, 1
        while self._is_taken(name):
            number += 1
            name = f"{base} {number}"
        return name

    def _is_taken(self, name: str) -> bool:
        names, ends = {name, name.removesuffix(ENDING)}, ("", ENDING, f"{ENDING}{PART}")
        return any((self._folder / f"{one}{end}").exists() for one in names for end in ends)

    def _check_free(self, name: str) -> None:
        """Raises Problem 409 where a recording has this name."""
        if self._is_taken(name):
            raise Problem(409, Statement("recording.taken", name=name))

    def _make_folder(self) -> None:
        with saving("Nothing can be recorded"):
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _sizes(self, *, parts: bool = False) -> list[tuple[str, float, int]]:
        """Name, time of change [s] and bytes of every finished file, or of those that are still written."""
        found: list[tuple[str, float, int]] = []
        for path in self._folder.glob("[!.]*"):
            with contextlib.suppress(FileNotFoundError):  # deleted or renamed meanwhile
                facts = path.stat()
                if stat.S_ISREG(facts.st_mode) and path.name.endswith(f"{ENDING}{PART}") == parts:
                    name = path.name.removesuffix(PART).removesuffix(ENDING)
                    found.append((name, facts.st_mtime, facts.st_size))
        return found

    def _parts(self) -> list[tuple[str, float, int]]:
        return self._sizes(parts=True)

    def _description(self, cause: str, note: str) -> dict[str, str]:
        profile = self._robot.profile
        facts = {"version": beckon_version(), "robot": profile.name, "url": profile.url}
        return {**facts, **work.cause_facts(cause), "note": note}

    async def _files(self) -> list[tuple[str, str, bytes]]:
        def read() -> list[tuple[str, str, bytes]]:
            paths = [
                path for given in self._attached for path in ([given] if given.is_file() else given.glob("*.json"))
            ]
            found: list[tuple[str, str, bytes]] = []
            for path in filter(Path.is_file, paths):
                try:
                    found.append((path.name, media_type(path), path.read_bytes()))
                except OSError as trouble:  # gone since, or another user's: the drive is recorded all the same
                    log.warning("%s does not go into the recording: %s", path, trouble)
            return found

        profile = self._robot.profile
        card = {"name": profile.name, "url": profile.url, "radius_m": profile.radius, "kind": profile.kind}
        facts = [("robot.json", "application/json", json.dumps(card).encode())]
        return facts + await asyncio.to_thread(read)

    def _read_notes(self) -> dict[str, RecordingNote]:
        try:
            return msgspec.json.decode(self._notes_file.read_bytes(), type=dict[str, RecordingNote])
        except FileNotFoundError:
            return {}
        except (OSError, msgspec.MsgspecError) as trouble:
            self._deletes = False
            self._notifications.tell(
                "warning", f"The notes of the recordings cannot be read, so none is deleted to make room: {trouble}"
            )
            return {}

    async def _set_note(self, name: str, note: str) -> None:
        self._notes[name] = RecordingNote(note)
        await self._save_notes()

    async def _save_notes(self) -> None:
        async with self._noting:
            content = msgspec.json.encode(self._notes)
            with saving("The note could not be saved"):
                await asyncio.to_thread(write_atomic, self._notes_file, content)


def pickled(moments: Iterable[work.RecordedMoment]) -> list[bytes]:
    """Pickle each by itself: between two of them the pilot may have the interpreter."""
    found: list[bytes] = []
    for one in moments:
        found.append(pickle.dumps(one, pickle.HIGHEST_PROTOCOL))
        time.sleep(0)
    return found


def slimmed(snapshot: Snapshot, *, with_map: bool) -> Snapshot:
    """A snapshot without what is large and is not recorded: of a picture that is packed, its pixels."""
    inputs, view = snapshot.inputs, snapshot.view
    image = None if inputs is None else inputs.frame.image
    if inputs is not None and image is not None and image.packed:
        frame = replace(inputs.frame, image=replace(image, pixels=image.pixels[:0]))
        inputs = replace(inputs, frame=frame)
    return replace(
        snapshot,
        scan_points=NO_POINTS,
        trail=NO_POINTS,
        dead_reckoning_trail=NO_POINTS,
        associations=(),
        landmarks=snapshot.landmarks if with_map else (),
        grid=snapshot.grid if with_map else NO_GRID,
        notices=(),
        sensors=(),
        inputs=inputs,
        view=None if view is None else replace(view, laser=NO_LASER, quality=None),
    )


def media_type(path: Path) -> str:
    return {".json": "application/json", ".toml": "application/toml"}.get(path.suffix, "application/octet-stream")


def checked_name(name: str) -> str:
    """A name as it is kept. Raises BadInput with what a name may be."""
    tidy = unicodedata.normalize("NFC", " ".join(name.split()))
    if not 0 < len(tidy) <= MAX_NAME_LETTERS or not NAME.fullmatch(tidy):
        raise BadInput(Statement("recording.bad_name", letters=MAX_NAME_LETTERS))
    return tidy


def fitted(name: str, tail: str) -> str:
    """A name with something behind it, as much of it as the name of a file holds."""
    return name.encode()[: MAX_NAME_BYTES - len(tail)].decode(errors="ignore").rstrip() + tail


def bare_name(name: str) -> str:
    """A name without the ending of its file. Raises BadInput as `checked_name`."""
    return checked_name(checked_name(name).removesuffix(ENDING))
