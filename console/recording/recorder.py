"""The recorder: what the robot senses and does, written by a process of its own; the last minutes can be kept."""

import asyncio
import contextlib
import json
import logging
import math
import time
from collections.abc import Iterable
from pathlib import Path

import msgspec

from console import beckon_version
from console.access.logins import Person
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from console.recording import work
from console.recording.moments import MomentBuilder, pickled
from console.recording.store import BYTES_PER_MB, FILE_BUDGET_S, RecordingStore, bare_name
from console.recording.work import RecorderWorker
from console.robot.supervisor import RobotSupervisor
from console.workers.worker import Worker
from core.errors import BeckonError, Unwritable
from core.files import reason
from core.pilot.pilot import Pilot
from core.recording.mcap_writing import PART
from core.recording.settings import RecordingSettings
from core.robots import Profile
from core.robots.profile_json import profile_to_json
from core.sensors import SensorFrame
from core.sentences import Statement
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

MAX_NAME_BYTES = 235  # of a file's 255, for its endings and a number
BATCH_PERIOD_S = 0.25  # [s] between two batches for the recorder's process
RING_PERIOD_S = 1.0  # [s] of the same where only the last minutes are held
FOXGLOVE_PERIOD_S = 0.05  # [s] of the same where other programs watch live
IDLE_PERIOD_S = 0.5  # [s] of the same where nothing comes
BATCH_BUDGET_S = 5.0  # [s] of processor time
MAX_WAITING_MOMENTS = 400  # frames that may wait; more are left out, with a notice
RING_DELAY_S = 5.0  # [s] after the first motion: its start must not be what slows that
RING_REST_S = 20.0  # [s] after the first frame, where nothing moves before
AFTER_INCIDENT_S = 3.0  # [s] that are still kept after what caused it
INCIDENT_PAUSE_S = 30.0  # [s] until another one is kept by itself
DISK_PERIOD_S = 2.0  # [s] between two looks at the disk
MEDIA_TYPES = {".json": "application/json", ".toml": "application/toml"}
RUNS = Statement("recording.runs")
NOTHING_YET = Statement("recording.nothing_yet")
KEPT_BY = Statement("recording.kept_by")
LOST = Statement("recording.lost")
RECOVERED = Statement("recording.was_recovered")
KEPT = Statement("recording.kept")


class RecordingState(msgspec.Struct, frozen=True):
    """The recorder as the page shows it."""

    name: str | None  # of the recording that runs
    path: str
    seconds: float
    bytes: int
    started_s: float
    messages: dict[str, int]
    ring_s: float  # [s] that can be kept now


class RecorderService(Part):
    """Lives on the event loop. Every moment goes to the recorder's process; what that finishes is in the store."""

    def __init__(
        self,
        settings: RecordingSettings,
        store: RecordingStore,
        robot: RobotSupervisor,
        history: History,
        notifications: Notifications,
        lease: Lease,
        attached: tuple[Path, ...] = (),
    ) -> None:
        """`attached`: files and folders of the data folder that go into every recording."""
        self.foxglove_port = 0  # where Foxglove and others watch live; 0: nowhere
        self.running: work.FinishedRecording | None = None
        self.kept = ""  # name of the part of the drive that is being kept
        self._settings, self._store, self._robot = settings, store, robot
        self._history, self._notifications, self._attached = history, notifications, attached
        self._moments = MomentBuilder(robot, lease)
        self._worker = Worker("recorder")
        self._described = self._writes = 0  # start of the worker that knows the robot, that writes the file
        self._waiting: list[work.RecordedMoment] = []
        self._left_out = 0  # frames for which there was no room among those
        self._unfinished = False  # a file waits to be recovered
        self._base, self._number = "", 1  # name of the recording that runs, and of its file
        self._began_s = 0.0  # monotonic, of its file
        self._listens_since_s: float | None = None  # monotonic; None: no moments go to the recorder's process
        self._ring_from_s = math.inf  # monotonic, when the ring begins
        self._moved = False  # the robot has
        self._calibrated: Profile | None = None  # the robot as the pilot sees it
        self._incident: tuple[float, str] | None = None  # [s] monotonic when it is kept, and why
        self._kept_s = self._disk_s = -math.inf  # monotonic, of the newest incident and look at the disk
        self._turn, self._change = asyncio.Lock(), asyncio.Lock()  # of the process; of what begins and ends
        self._wake = asyncio.Event()

    # life

    async def open(self) -> None:
        """Finish what a former console left behind."""
        if await asyncio.to_thread(self._store.parts):
            await self._recover()
            self._worker.kill()
        if self._settings.from_start and not self._replays:
            try:
                self._base = await self._begin("", "")
            except (BeckonError, Problem) as trouble:
                self._notifications.tell("error", Statement("recording.not_begun", trouble=trouble), "recorder")

    async def _recover(self) -> None:
        """Finish what a lost process left behind, once nothing is recorded and no process writes it."""
        try:
            async with self._turn:
                if self.running is not None:
                    return
                self._unfinished = False
                job = RecorderWorker.recover(str(self._store.folder))
                found = await self._worker.ask(job, budget=FILE_BUDGET_S)
        except BeckonError as trouble:
            self._notifications.tell("warning", Statement("recording.unrecovered", trouble=trouble), "recovery")
            return
        self._store.revision += 1
        for one in found:
            if one.complete:
                self._notifications.tell("info", RECOVERED(name=one.name, seconds=f"{one.seconds:.0f}"), "recovery")
            else:
                self._unfinished = True

    async def run(self) -> None:
        """Send what came to the recorder's process, and look at the disk."""
        while True:
            with contextlib.suppress(TimeoutError):  # where nothing comes, what came last is written all the same
                rests = self.running is None and not self._unfinished
                async with asyncio.timeout(None if rests else IDLE_PERIOD_S):
                    await self._wake.wait()
            await asyncio.sleep(self._batch_period_s)
            self._wake.clear()
            await asyncio.shield(self._send())  # a console that ends meanwhile would end the recorder
            if self._unfinished:
                await self._recover()
            try:
                await self._after_batch(time.monotonic())
            except OSError as trouble:  # of the folder; what is written is not concerned
                self._notifications.tell("error", Statement("recording.folder", trouble=reason(trouble)), "recorder")

    @property
    def _batch_period_s(self) -> float:
        """Time [s] over which what comes is gathered: to wake a process costs more than what it gets."""
        if self.foxglove_port:
            return FOXGLOVE_PERIOD_S
        return RING_PERIOD_S if self.running is None else BATCH_PERIOD_S

    async def close(self) -> None:
        if self.running is not None:
            try:
                await self.stop()
            except (BeckonError, Problem) as trouble:
                log.warning("The recording could not be finished: %s", trouble)
        self._worker.kill()
        await self._worker.gone()

    # what comes

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Take a frame and what was made of it, once the ring has begun or something is recorded."""
        now = time.monotonic()
        self._begin_ring(now, moves=bool(snapshot.setpoint.v or snapshot.setpoint.w))
        acts = () if snapshot.inputs is None else snapshot.inputs.acts
        self._calibrated = next((act for act in reversed(acts) if isinstance(act, Profile)), self._calibrated)
        if self._listens_since_s is None or (self._replays and not self.foxglove_port):
            return
        why = self._moments.events.take(snapshot, self._notifications.shown, self._robot.status())
        if why and self.ring_limit_s > 0 and self._incident is None and now - self._kept_s > INCIDENT_PAUSE_S:
            self._incident = (now + AFTER_INCIDENT_S, why)  # the ring is kept in a moment
        if len(self._waiting) >= MAX_WAITING_MOMENTS:
            self._left_out += 1
            return
        self._waiting.append(self._moments.moment(snapshot, frame, running=self.running is not None))
        self._wake.set()

    def equip(self, pilot: Pilot) -> None:
        self._moments.equip(pilot)

    def heard(self, words: str, verdict: str, command: str | None) -> None:
        if self._listens_since_s is not None:
            self._moments.events.heard(words, verdict, command)

    def note(self, words: str, remark: str) -> None:
        if self._listens_since_s is not None:
            self._moments.events.note(words, remark)

    def _begin_ring(self, now: float, *, moves: bool) -> None:
        """Listen for the ring: some time after the start, but never with the first motion."""
        if self._listens_since_s is not None:
            return
        if self.ring_limit_s > 0 and (self._ring_from_s == math.inf or (moves and not self._moved)):
            self._moved, self._ring_from_s = moves, now + (RING_DELAY_S if moves else RING_REST_S)
        if self.running is not None or self.foxglove_port or now > self._ring_from_s:
            self._listens_since_s = now

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
        one, since = self.running, self._listens_since_s
        ring_s = 0.0 if since is None else min(time.monotonic() - since, self.ring_limit_s)
        if one is None:
            return RecordingState(None, "", 0.0, 0, 0.0, {}, ring_s)
        path = str(self._store.path(one.name)) + PART
        return RecordingState(one.name, path, one.seconds, one.bytes, one.started_s, one.messages, ring_s)

    async def start(self, name: str | None, note: str, who: Person) -> RecordingState:
        """Begin a recording. Raises BadInput, Problem 409, Unwritable."""
        if self._replays:
            raise Problem(409, Statement("recording.replay"))
        async with self._change:
            if self.running is not None:
                raise Problem(409, RUNS)
            self._base, self._number = await self._begin(bare_name(name) if name else "", note), 1
        self._history.add("record", who, words=self._base)
        return self.state

    async def _begin(self, wanted: str, note: str) -> str:
        """Begin a file of this name, or of one like it, "": the date → its name."""
        await asyncio.to_thread(self._store.make_folder)
        await self._moments.take_whole_map()  # the file begins with it
        self._listens_since_s = self._listens_since_s or time.monotonic()
        async with self._turn, self._store.naming:
            if self.running is not None:  # another one has begun while this one waited
                raise Problem(409, RUNS)
            await self._ready()
            name = self._store.fresh_name(wanted)
            await self._worker.ask(RecorderWorker.begin(await self._file(name, "", note)), budget=FILE_BUDGET_S)
            self._writes = self._worker.starts
            self.running = work.FinishedRecording(
                name, 0.0, 0, {}, time.time(), complete=False, note=note, robot=self._robot.profile.name
            )
        self._store.revision += 1
        self._began_s = time.monotonic()
        if note:
            try:
                await self._store.set_note(name, note)
            except Unwritable as trouble:  # it records all the same, and the note stands in the file
                self._notifications.tell("warning", str(trouble), "recorder")
        await self._send()  # what came while the process started is in its hands before it is said that it records
        return name

    async def stop(self, who: Person | None = None) -> work.FinishedRecording:
        """End the recording → the finished file. Raises Problem 409, Unwritable, WorkerLost."""
        async with self._change:
            return await self._stop(who)

    async def stop_own(self, name: str, who: Person) -> None:
        """End the recording that began under this name, where nobody has ended it before. Raises as `stop`."""
        async with self._change:
            if self.running is not None and self._base == name:
                await self._stop(who)

    async def _stop(self, who: Person | None = None, *, goes_on: bool = False) -> work.FinishedRecording:
        """`goes_on`: in another file, so that what comes meanwhile waits for that."""
        if self.running is None:
            raise Problem(409, Statement("recording.nothing_runs"))
        await self._send()
        running, self.running = self.running, None
        try:
            async with self._turn:
                done = await self._worker.ask(RecorderWorker.finish(), budget=FILE_BUDGET_S)
        except BeckonError:
            self._unfinished = True
            self._wake.set()
            raise
        self._store.revision += 1
        if who is not None:
            self._history.add("stop_recording", who, words=done.name)
        if not (goes_on or self.ring_limit_s > 0 or self.foxglove_port):
            self._listens_since_s = None
        return msgspec.structs.replace(done, started_s=running.started_s, note=running.note)

    async def keep(self, seconds: float, cause: str, who: Person | None = None) -> work.FinishedRecording:
        """Save the last part of the drive as a recording of its own. Raises Problem 409, Unwritable."""
        if self.ring_limit_s <= 0 or self._listens_since_s is None:
            raise Problem(409, NOTHING_YET if self.ring_limit_s > 0 else Statement("recording.nothing_held"))
        await self._send()
        await asyncio.to_thread(self._store.make_folder)
        async with self._turn, self._store.naming:
            await self._ready()
            self.kept = name = self._store.fresh_name("")
            job = RecorderWorker.keep(await self._file(name, cause, ""), seconds)
            kept = await self._worker.ask(job, budget=FILE_BUDGET_S)
        self._store.revision += 1
        if who is not None:
            self._history.add("keep_recording", who, words=name)
        return msgspec.structs.replace(kept, **work.with_cause(cause))

    async def _send(self) -> None:
        moments, self._waiting = self._waiting, []
        if self._left_out:
            self._notifications.tell("warning", Statement("recording.left_out", count=self._left_out), "recorder")
            self._left_out = 0
        if self.running is not None and not (self._worker.alive and self._worker.starts == self._writes):
            self._lost("its process has ended.")
        if not moments and self.running is None:
            return
        try:
            async with self._turn:
                await self._ready()
                packed = await asyncio.to_thread(pickled, moments)
                written = await self._worker.ask(RecorderWorker.record(packed), budget=BATCH_BUDGET_S)
        except BeckonError as trouble:
            self._lost(str(trouble))
            return
        if self.running is not None and written is not None:
            facts = {"seconds": written.seconds, "bytes": written.bytes, "messages": written.messages}
            self.running = msgspec.structs.replace(self.running, **facts)

    def _lost(self, trouble: str) -> None:
        """The recorder's process, and with it the ring, is gone."""
        if self._listens_since_s is not None:
            self._listens_since_s = time.monotonic()
        if self.running is not None:
            self.running, self._unfinished = None, True
            self._store.revision += 1
            self._notifications.tell("error", LOST(trouble=trouble), "recorder")

    async def _ready(self) -> None:
        """Start the process and describe the robot to it, unless it is there and knows it."""
        if self._worker.alive and self._described == self._worker.starts:
            return
        profile = self._robot.profile
        built, calibrated = profile_to_json(profile), profile_to_json(self._calibrated or profile)
        await self._worker.ask(RecorderWorker.describe(built, calibrated, self.ring_limit_s), budget=FILE_BUDGET_S)
        self._described = self._worker.starts
        if self.foxglove_port:
            job = RecorderWorker.serve(self.foxglove_port, f"Beckon: {profile.name}")
            try:
                await self._worker.ask(job, budget=FILE_BUDGET_S)
            except BeckonError as trouble:
                self.foxglove_port = 0
                self._notifications.tell("error", str(trouble), "foxglove")

    async def _file(self, name: str, cause: str, note: str) -> work.NewFile:
        """The begin of a new file: its description, the robot, and what is attached."""
        profile = self._robot.profile
        described = {"version": beckon_version(), "robot": profile.name, "url": profile.url, "note": note}
        card = {"name": profile.name, "url": profile.url, "radius_m": profile.radius, "kind": profile.kind}
        facts = [("robot.json", MEDIA_TYPES[".json"], json.dumps(card).encode())]
        attached = facts + await asyncio.to_thread(attachments, self._attached)
        return work.NewFile(str(self._store.path(name)), described | work.cause_facts(cause), attached)

    # after each batch

    async def _after_batch(self, now: float) -> None:
        if self._listens_since_s is not None and not self._replays:
            await self._moments.take_whole_map(when_due=True)
        if self._incident is not None and now > self._incident[0]:
            why, self._incident, self._kept_s = self._incident[1], None, now
            try:
                kept = await self.keep(self._settings.ring_s, why)
                words = KEPT(seconds=f"{kept.seconds:.0f}", name=kept.name, cause=why)
                self._notifications.tell("info", words, "kept")
            except (BeckonError, Problem) as trouble:
                self._notifications.tell("warning", Statement("recording.not_kept", trouble=trouble), "kept")
        if now - self._disk_s >= DISK_PERIOD_S and (self.running is not None or self._store.has_changed):
            self._disk_s = now
            await self._look_at_file(now)
            await self._store.make_room()

    async def _look_at_file(self, now: float) -> None:
        """End the recording that runs where the disk is nearly full; where its file is long, go on in another one."""
        if self.running is None:
            return
        free = await asyncio.to_thread(self._store.free_mb)
        if free < self._settings.free_mb:
            await self._end(Statement("recording.low_disk", free=f"{free:.0f}"))
            return
        limit_s, limit_bytes = 60 * self._settings.file_minutes, BYTES_PER_MB * self._settings.file_mb
        if now - self._began_s > limit_s or self.state.bytes > limit_bytes:
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
                done = await self._stop(goes_on=True)
                self._number += 1
                await self._begin(fitted(self._base, f" part {self._number}"), done.note)
        except (BeckonError, Problem) as trouble:
            self._notifications.tell("error", f"The recording has ended: {trouble}", "recorder")


def attachments(places: Iterable[Path]) -> list[tuple[str, str, bytes]]:
    """Name, media type and content of the files, and of the JSON files of folders, that can be read."""
    found: list[tuple[str, str, bytes]] = []
    for path in (path for place in places for path in ([place] if place.is_file() else place.glob("*.json"))):
        try:
            found.append((path.name, MEDIA_TYPES.get(path.suffix, "application/octet-stream"), path.read_bytes()))
        except OSError as trouble:  # gone since, or another user's: the drive is recorded all the same
            log.warning("%s does not go into the recording: %s", path, trouble)
    return found


def fitted(name: str, tail: str) -> str:
    """A name with something behind it, as much of it as the name of a file holds."""
    return name.encode()[: MAX_NAME_BYTES - len(tail)].decode(errors="ignore").rstrip() + tail
