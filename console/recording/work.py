"""The recorder's process: readings and results → one MCAP that grows, and the last minutes in memory.

It gets what it writes through the pipe of a worker, so that neither the pilot nor the event loop waits for a disk,
or for a picture to be packed. What has come is written by a thread: it is safe from the end of the console at once,
however busy the computer is. When the console hangs up the file is finished.
"""

from __future__ import annotations

import atexit
import contextlib
import pickle
import queue
import threading
import time
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from mcap.reader import make_reader

from console.workers.job import job
from console.workers.pictures import jpeg
from core.errors import Refused, Unwritable
from core.gate.status import GateStatus
from core.message import Array
from core.pilot.drive_record import record_of
from core.pipelines.drive_film import FilmForm, film_of
from core.pipelines.record import record_sample
from core.recording.drive import CAMERA_TOPIC
from core.recording.excerpt import write_excerpt
from core.recording.foxglove_server import FoxgloveServer
from core.recording.frame_record import RobotRecord
from core.recording.mcap_recovery import recovered
from core.recording.mcap_writing import BROKEN_RECORD, NS_PER_S, PART, McapRecording, RecordedFile
from core.recording.ros import Envelope, decode
from core.recording.ros_writing import LATCHED_TOPICS, RosEncoder, RosMessage
from core.robots import Profile
from core.robots.profile_json import profile_from_json, profile_to_json
from core.sensors import SensorFrame
from core.sentences import SentenceCode, Statement, code_of, coded
from core.snapshot import PilotInputs, Snapshot

PICTURE_SIDE_PX, PICTURE_QUALITY = 240, 95  # of the one in the list
DESCRIPTION = "beckon"  # name of the metadata record
RECOVERED = Statement("recording.recovered")
MAX_WAITING_BATCHES = 8  # that have come and are not yet written; then the console waits


@dataclass(frozen=True, kw_only=True)
class RecordedMoment:
    """One frame, and what the console made of it; what has not changed is None."""

    at: float  # [s] of this computer's monotonic clock, which nobody sets
    logged: float  # [s] Unix time
    snapshot: Snapshot  # without what can be computed from the rest
    gate: GateStatus
    operator: str  # name; "": nobody drives
    map_is_new: bool = False
    view_is_new: bool = False
    azimuth: float | None = None  # [rad] of a voice
    whole_map: bytes = b""  # to go on in, as it was before this frame; empty: none was taken
    texts: tuple[tuple[str, str | Mapping[str, object]], ...] = ()  # topic, words or JSON


class FinishedRecording(msgspec.Struct, frozen=True):
    """A file with all that was written to it."""

    name: str
    seconds: float
    bytes: int
    messages: dict[str, int]  # by topic
    started_s: float = 0.0  # Unix time of its first message
    complete: bool = True
    note: str = ""
    cause: str = ""  # a sentence: why it was kept, or what is the matter with it
    robot: str = ""
    code: str | None = None  # of the sentence in `cause`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names
    file: str = ""  # its name in the folder of recordings, once it is finished

    @classmethod
    def of(cls, written: RecordedFile, cause: str = "") -> FinishedRecording:
        """As it goes through the pipe."""
        facts = written.path.stem, written.seconds, written.bytes, dict(written.messages)
        return cls(*facts, cause=cause, file=written.path.name)


def cause_facts(cause: str) -> dict[str, str]:
    """Return the part of a file's description that says its cause."""
    return {"cause": cause, "said": msgspec.json.encode(code_of(cause)).decode()}


def with_cause(cause: str) -> dict[str, Any]:
    """The fields of a recording that say a cause, in every language."""
    return {"cause": cause, **code_of(cause)._asdict()}


class NewFile(msgspec.Struct, frozen=True):
    path: str
    described: dict[str, str]
    attached: list[tuple[str, str, bytes]]  # name, media type, content

    def opened(self) -> McapRecording:
        """The file with its description and the files that belong to it. Raises Unwritable."""
        recording = McapRecording(Path(self.path))
        try:
            recording.describe(DESCRIPTION, self.described)
            for name, media_type, content in self.attached:
                recording.attach(name, media_type, content)
        except Unwritable:
            recording.discard()
            raise
        return recording


class RecorderWorker:
    """Keeps the file that grows, and the ring."""

    def __init__(self) -> None:
        self._encoder = RosEncoder()
        self._robot = RobotRecord(msgspec.Raw(b"{}"), msgspec.Raw(b"{}"))
        self._recording: McapRecording | None = None
        self._ring: deque[tuple[float, RosMessage]] = deque()  # [s] monotonic
        self._unix_from_monotonic = 0.0  # [s], of the newest moment
        self._latched: dict[str, RosMessage] = {}  # newest of each topic that a file begins with
        self._before: dict[str, RosMessage] = {}  # the same at the beginning of the ring
        self._ring_s = 0.0
        self._foxglove: FoxgloveServer | None = None
        self._waiting: queue.Queue[list[bytes]] = queue.Queue(MAX_WAITING_BATCHES)
        self._written: FinishedRecording | None = None  # the file after the newest batch
        self._trouble: Exception | None = None  # with what came, not yet answered
        threading.Thread(target=self._write, name="recorder", daemon=True).start()
        atexit.register(self._leave)

    @job
    def describe(self, built: bytes, used: bytes, ring_s: float) -> None:
        """Another robot, or the first: its profile as built and as calibrated until now, JSON; [s] kept in memory."""
        profile = profile_from_json(built)
        self._encoder, self._ring_s = RosEncoder(profile.lasers, profile.cameras), ring_s
        self._ring.clear()
        self._robot = RobotRecord(msgspec.Raw(built), msgspec.Raw(used))
        fixed = (*self._encoder.fixed(0.0), self._encoder.robot(0.0, self._robot))
        self._latched = {one.topic: one for one in fixed}
        self._before = dict(self._latched)

    @job
    def serve(self, port: int, name: str) -> None:
        """Send everything that comes to Foxglove's clients, too; after `describe`. Raises Unavailable."""
        self._foxglove = self._foxglove or FoxgloveServer(port, name, self._encoder.topics())
        self._foxglove.publish(self._latched.values(), time.time())

    @job
    def begin(self, file: NewFile) -> None:
        """Write from now on to this file. Raises Unwritable."""
        self._settle()
        self._recording = file.opened()

    @job
    def record(self, moments: list[bytes]) -> FinishedRecording | None:
        """Take these, each a pickled RecordedMoment of our own console → at once the file as far as written, None
        where none is. Raises Unwritable for what came before; then the file is finished as far as it goes.
        """
        self._waiting.put(moments)
        self._complain()
        return self._written

    def _write(self) -> None:
        while True:
            moments = self._waiting.get()
            try:
                for moment in moments:
                    self._record(pickle.loads(moment))
                if self._recording is not None:
                    self._recording.flush_when_due()
                    self._written = FinishedRecording.of(self._recording.written)
            except Exception as trouble:  # said with the next answer
                self._trouble = trouble
                self._end()
            finally:
                self._waiting.task_done()

    def _settle(self) -> None:
        """Wait until all that has come is written. Raises what went wrong with it."""
        self._waiting.join()
        self._complain()

    def _complain(self) -> None:
        trouble, self._trouble = self._trouble, None
        if trouble is not None:
            raise trouble

    def _record(self, moment: RecordedMoment) -> None:
        messages = list(self._messages(moment))
        recording, logged = self._recording, moment.logged
        if self._foxglove is not None:
            self._foxglove.publish(messages, logged)
        if recording is not None:
            fresh = not recording.written.messages
            recording.add([*self._latched.values(), *messages] if fresh else messages, logged)
        self._latched |= {one.topic: one for one in messages if one.topic in LATCHED_TOPICS}
        if self._ring_s > 0:
            self._unix_from_monotonic = logged - moment.at
            self._ring.extend((moment.at, one) for one in messages)
            while self._ring and self._ring[0][0] < moment.at - self._ring_s:
                _, gone = self._ring.popleft()
                self._before |= {gone.topic: gone} if gone.topic in LATCHED_TOPICS else {}

    def _messages(self, moment: RecordedMoment) -> Iterator[RosMessage]:
        snapshot, encoder, gate = moment.snapshot, self._encoder, moment.gate
        inputs = snapshot.inputs or PilotInputs(frame=SensorFrame(stamp=snapshot.stamp))
        frame, wheels = inputs.frame, inputs.frame.wheels
        news = {"map_is_new": moment.map_is_new, "view_is_new": moment.view_is_new}
        yield encoder.frame(record_of(snapshot, gate.state, moment.operator, **news))
        for used in (act for act in inputs.acts if isinstance(act, Profile)):
            self._robot = msgspec.structs.replace(self._robot, used=msgspec.Raw(profile_to_json(used)))
            yield encoder.robot(frame.stamp, self._robot)
        yield from encoder.readings(frame)
        yield from encoder.pose(frame.stamp, snapshot.estimate, None if wheels is None else wheels.odometry)
        yield encoder.speeds(frame.stamp, gate.v, gate.w)
        if moment.map_is_new:
            yield encoder.landmarks(frame.stamp, snapshot.landmarks)
            yield encoder.grid(frame.stamp, snapshot.grid)
        if moment.whole_map:
            yield encoder.whole_map(frame.stamp, moment.whole_map)
        if moment.azimuth is not None:
            yield encoder.direction(frame.stamp, moment.azimuth)
        for topic, content in moment.texts:
            yield encoder.text(topic, frame.stamp, content)

    @job
    def finish(self) -> FinishedRecording:
        """Close the file. Raises Refused, Unwritable."""
        self._settle()
        recording, self._recording, self._written = self._recording, None, None
        if recording is None:
            raise Refused(Statement("recording.nothing_runs"))
        return FinishedRecording.of(recording.finish())

    @job
    def keep(self, file: NewFile, seconds: float) -> FinishedRecording:
        """Write what is in memory to a file of its own. Raises Refused, Unwritable."""
        self._waiting.join()
        if not self._ring:
            raise Refused("There is nothing to keep yet: the recorder has just begun to listen.")
        since = self._ring[-1][0] - seconds
        kept = [(self._unix_from_monotonic + at, one) for at, one in self._ring if at >= since]
        earlier = (one for at, one in self._ring if at < since and one.topic in LATCHED_TOPICS)
        begun = self._before | {one.topic: one for one in earlier}
        recording = file.opened()
        try:
            recording.add(begun.values(), kept[0][0])
            for logged, one in kept:
                recording.add([one], logged)
            return FinishedRecording.of(recording.finish())
        except Unwritable:
            recording.discard()  # the ring is still there
            raise

    @job
    def recover(self, folder: str) -> list[FinishedRecording]:
        """Finish what a process left behind; what one still writes is answered as not complete. Raises Unwritable."""
        found: list[FinishedRecording] = []
        for part in sorted(Path(folder).glob(f"*.mcap{PART}")):
            try:
                whole = recovered(part, cause_facts(RECOVERED))
            except Refused:  # still written
                found.append(FinishedRecording(part.name.removesuffix(f".mcap{PART}"), 0.0, 0, {}, complete=False))
            else:
                found += [] if whole is None else [FinishedRecording.of(whole, RECOVERED)]
        return found

    @job
    def read(self, file: str) -> FinishedRecording:
        """Look at a file's summary; one that has none, or that was just taken away, is shown as not complete."""
        path, size = Path(file), 0
        described, said = dict[str, str](), SentenceCode()
        try:
            size = path.stat().st_size
            with path.open("rb") as opened:
                reader = make_reader(opened)
                summary = reader.get_summary()
                for one in reader.iter_metadata():  # of a recovered one the last says so
                    described |= one.metadata if one.name == DESCRIPTION else {}
                said = msgspec.json.decode(described.get("said", "[null,null]"), type=SentenceCode)
        except (OSError, msgspec.MsgspecError, *BROKEN_RECORD):
            summary = None
        if summary is None or summary.statistics is None:
            return FinishedRecording(path.stem, 0.0, size, {}, complete=False)
        counted = summary.statistics
        return FinishedRecording(
            path.stem,
            (counted.message_end_time - counted.message_start_time) / NS_PER_S,
            size,
            {
                summary.channels[number].topic: count
                for number, count in counted.channel_message_counts.items()
                if number in summary.channels  # which a writer may leave out there
            },
            counted.message_start_time / NS_PER_S,
            **with_cause(coded(described.get("cause", ""), said)),
            note=described.get("note", ""),
            robot=described.get("robot", ""),
        )

    @job
    def picture(self, path: str) -> bytes:
        """The camera's picture of the middle of the drive, as a JPEG; empty where there is none."""
        with contextlib.suppress(OSError, cv2.error, *BROKEN_RECORD), Path(path).open("rb") as file:
            reader = make_reader(file)
            summary = reader.get_summary()
            counted = None if summary is None else summary.statistics
            if counted is None:
                return b""
            middle = (counted.message_start_time + counted.message_end_time) // 2
            for since in (middle, None):
                for schema, channel, message in reader.iter_messages([CAMERA_TOPIC], start_time=since):
                    kind = "" if schema is None else schema.name
                    raw = Envelope(channel.topic, kind, channel.message_encoding, 0.0, message.data)
                    packed = np.asarray(decode(raw, kind).data, np.uint8)
                    pixels: Array | None = cv2.imdecode(packed, cv2.IMREAD_COLOR)
                    return b"" if pixels is None else jpeg(pixels, PICTURE_SIDE_PX, PICTURE_QUALITY)
        return b""

    @job
    def sample(self, sample: str, target: str) -> FinishedRecording:
        """Drive and record. Raises Unwritable."""
        return FinishedRecording.of(record_sample(sample, Path(target)))

    @job
    def cut(self, path: str, target: str, begin_s: float, end_s: float) -> FinishedRecording:
        """Write a part to a file of its own. Raises BadInput, Unwritable."""
        written = FinishedRecording.of(write_excerpt(Path(path), Path(target), begin_s, end_s))
        return msgspec.structs.replace(written, note=self.read(target).note)

    @job
    def film(self, path: str, begin_s: float, end_s: float, form: FilmForm) -> bytes:
        """The map and the camera of a part, as an animated picture. Raises BadInput, Unavailable."""
        return film_of(Path(path), begin_s, end_s, form)

    def _leave(self) -> None:
        self._waiting.join()
        self._end()

    def _end(self) -> None:
        recording, self._recording, self._written = self._recording, None, None
        if recording is not None:
            with contextlib.suppress(Unwritable):  # said already; what is there is recovered
                recording.finish()
