"""Beckon's own recordings: every frame as the pilot took it, and what the console made of it, at any time.

A moment is one frame with its results; all its messages have one log time. Nothing is held but the index and a few
chunks, so a recording may be as long as the disk. `mcap_file` reads a file from its beginning to its end; here the
index says where a time lies. A file without one, which was cut, is read once for it.
"""

import bisect
import contextlib
import itertools
import struct
from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO, cast

import msgspec
import numpy as np
from mcap.reader import SeekingReader, make_reader
from mcap.summary import Summary

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.recording import frame_record
from core.recording.frame_record import FRAME, FrameRecord, ResultRecord
from core.recording.mcap_file import CHUNK_OPCODE, HEAD, MAGIC, NANOSECOND_S, ChunkSpan, McapWalk
from core.recording.mcap_writing import BROKEN_RECORD
from core.recording.odometry_track import heading_of
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings, RecordingReport
from core.recording.ros import LASER_SCAN, ODOMETRY, Envelope, decode, seconds_of, stamp_of
from core.recording.ros_pictures import COMPRESSED
from core.recording.ros_sound import RAW_AUDIO
from core.recording.source import BinaryLog, first_bytes
from core.sensors import Image, Scan, SensorFrame, Sound, Wheels
from core.sensors.recordable import samples_of, unpack_picture

HELD_CHUNKS = 8  # unpacked ones that are kept
LIBRARY = b"beckon"  # in the header of the file
ODOMETRY_TOPIC = "/odom"
CAMERA_TOPIC = "/camera/image/compressed"
FORM = "Beckon's recording"
NO_OWN_RECORDING = "A part can be exported only of a recording that Beckon made."
SAME_MOMENT_S = 1e-6  # Unix times have no more digits
UNREADABLE = (ValueError, msgspec.MsgspecError, AttributeError, struct.error, UnicodeDecodeError, BadInput)


class McapChunks:
    """The chunks of one file, in the order of time."""

    def __init__(self, path: Path, settings: LogSettings, tally: ReadReport) -> None:
        """Raises BadInput where the file is no MCAP, or holds no chunk."""
        self._source = BinaryLog(path, settings.largest_file)
        if self._source.at(0, len(MAGIC)) != MAGIC:
            self.close()
            raise BadInput(f"{path.name} is not an MCAP file: it does not begin as one.")
        self._walk = McapWalk(self._source, settings.largest_block, tally)
        self._held: OrderedDict[int, tuple[Envelope, ...]] = OrderedDict()
        summary = _summary(path)
        self.indexed = summary is not None and bool(summary.chunk_indexes)
        self.counts: dict[str, int] = {}  # messages by topic
        self._holding: dict[str, list[int]] = {}  # begins of the chunks with messages of each topic
        spans = self._walked() if summary is None or not self.indexed else self._listed(summary)
        self.spans = tuple(sorted(spans, key=lambda span: span.begin))
        self._begins = [span.begin for span in self.spans]
        self._firsts = list(itertools.accumulate((span.first for span in self.spans), max))
        if not self.spans:
            self.close()
            raise BadInput(f"{path.name} holds no messages that can be read.")

    def close(self) -> None:
        """Let go of the file."""
        self._source.__exit__(None, None, None)

    def messages(self, number: int) -> tuple[Envelope, ...]:
        """The messages of one chunk, in the order in which they were written; what is damaged is left out."""
        if number not in self._held:
            span = self.spans[number]
            self._held[number] = tuple(self._walk.within(CHUNK_OPCODE, span.begin, span.length))
            while len(self._held) > HELD_CHUNKS:
                self._held.popitem(last=False)
        self._held.move_to_end(number)
        return self._held[number]

    def number_at(self, logged: float) -> int:
        """The last chunk that begins before that time [s]: a moment that a later one goes on with begins in it."""
        return max(bisect.bisect_left(self._firsts, logged - SAME_MOMENT_S) - 1, 0)

    def numbers_with(self, topic: str) -> list[int]:
        """The chunks with messages of this topic."""
        return [bisect.bisect_left(self._begins, begin) for begin in sorted(self._holding.get(topic, []))]

    def _listed(self, summary: Summary) -> list[ChunkSpan]:
        schemas = [(number, one.name) for number, one in summary.schemas.items()]
        channels = [(key, one.topic, one.message_encoding, one.schema_id) for key, one in summary.channels.items()]
        self._walk.know(schemas, channels)
        if summary.statistics is not None:
            counted = summary.statistics.channel_message_counts
            known = summary.channels  # of which a writer may leave some out there
            self.counts = {known[number].topic: count for number, count in counted.items() if number in known}
        for one in summary.chunk_indexes:
            for number in one.message_index_offsets:
                if number in summary.channels:
                    holding = self._holding.setdefault(summary.channels[number].topic, [])
                    holding.append(one.chunk_start_offset + HEAD.size)
        return [
            ChunkSpan(
                one.chunk_start_offset + HEAD.size,
                one.chunk_length - HEAD.size,
                one.message_start_time * NANOSECOND_S,
                one.message_end_time * NANOSECOND_S,
            )
            for one in summary.chunk_indexes
        ]

    def _walked(self) -> list[ChunkSpan]:
        """The chunks by one pass over the file, in which its topics are learned, too."""
        found: list[ChunkSpan] = []
        for opcode, begin, length in self._walk.records():
            inside = tuple(self._walk.within(opcode, begin, length))
            for one in inside:
                self.counts[one.topic] = self.counts.get(one.topic, 0) + 1
            span = self._walk.span(begin, length) if opcode == CHUNK_OPCODE and inside else None
            if span is not None:
                times = [one.logged for one in inside]
                found.append(ChunkSpan(begin, length, min(times), max(times)))
                for topic in {one.topic for one in inside}:
                    self._holding.setdefault(topic, []).append(begin)
        return found


def _summary(path: Path) -> Summary | None:
    """The index at the end of a file; None where it has none that can be read."""
    try:
        with path.open("rb") as file:
            return SeekingReader(cast(BinaryIO, file)).get_summary()
    except (OSError, *BROKEN_RECORD):
        return None


class DriveMoment:
    """One frame, and everything else that was written with it; its bulk is decoded when it is asked for."""

    def __init__(
        self, logged: float, group: tuple[Envelope, ...], record: FrameRecord | None, tally: ReadReport
    ) -> None:
        """`logged` [s], Unix time; `record`: None where it was recorded before there were any."""
        self.logged, self.record = logged, record
        self._group, self._tally = group, tally

    @cached_property
    def frame(self) -> SensorFrame:
        """The whole frame."""
        found: dict[str, Any] = {}
        for one in self._group:
            if one.kind in READERS:
                with self._tally.reading(one.topic):
                    found[one.kind] = READERS[one.kind](one.topic, decode(one, one.kind))
                    self._tally.read += 1
        scan, image, sound = (found.get(kind) for kind in (LASER_SCAN, COMPRESSED, RAW_AUDIO))
        if self.record is None:  # from before there were records of frames
            newest = max((one.stamp for one in (scan, image, sound) if one is not None), default=self.logged)
            stamp, wheels = found.get(ODOMETRY, (newest, None))
            return SensorFrame(stamp=stamp, wheels=wheels, scan=scan, image=image, sound=sound)
        if image is not None and self.record.image is not None:
            image = replace(image, stamp=self.record.image[0], camera=self.record.image[1])
        return self.record.frame(scan and scan.ranges, image, sound and sound.samples)

    @property
    def light_frame(self) -> SensorFrame:
        """The frame without ranges, pictures and samples."""
        return self.frame if self.record is None else self.record.frame(None, None, None)

    @property
    def results(self) -> ResultRecord | None:
        """The results of that day, as numbers; None where nothing was computed then."""
        return None if self.record is None else self.record.results

    @property
    def deaf(self) -> bool:
        """True where the pilot of that day did not listen to its sound: the robot spoke."""
        taken = None if self.record is None else self.record.taken
        return taken is not None and taken.deaf

    @property
    def others(self) -> tuple[Envelope, ...]:
        """The results, as they lie in the file."""
        return tuple(one for one in self._group if one.kind not in READERS)

    @property
    def is_frame(self) -> bool:
        """True where there is a frame in it."""
        return self.record is not None or any(one.kind in READERS for one in self._group)


def is_drive(path: Path) -> bool:
    """Return whether a file was recorded by Beckon."""
    head = first_bytes(path, 200)
    try:
        at = len(MAGIC) + HEAD.size
        (length,) = struct.unpack_from("<I", head, at)
        (other,) = struct.unpack_from("<I", head, at + 4 + length)
    except struct.error:
        return False
    return head.startswith(MAGIC) and head[at + 8 + length :][: min(other, 100)].startswith(LIBRARY)


class DriveRecording:
    """One recording that stays open."""

    def __init__(self, path: Path, settings: LogSettings | None = None) -> None:
        """Raises BadInput where nothing in the file can be read."""
        self.path = path
        self._tally = ReadReport(path)
        self._chunks = McapChunks(path, settings or LogSettings(), self._tally)
        self.start = self._chunks.spans[0].first  # [s] Unix time
        self.duration = max(max(span.last for span in self._chunks.spans) - self.start, 0.0)  # [s]
        self.counts = self._chunks.counts  # messages by topic
        self.exact = FRAME in self.counts

    @property
    def has_wheels(self) -> bool:
        """True if there is odometry."""
        return ODOMETRY_TOPIC in self.counts

    def close(self) -> None:
        """Let go of the file."""
        self._chunks.close()

    @property
    def report(self) -> RecordingReport:
        """Everything that was read until now, and what could not be."""
        if not self._chunks.indexed:
            self._tally.warn("The recording was not finished; it plays as far as it can be read.")
        self._tally.topics = [f"{topic}: {count}" for topic, count in sorted(self.counts.items())]
        return self._tally.report(FORM)

    def moments(self, since: float = 0.0) -> Iterator[DriveMoment]:
        """Every moment from `since` [s] after the start on, in the order in which it was recorded."""
        for logged, group in self._groups(self._chunks.number_at(self.start + since)):
            if logged >= self.start + since - SAME_MOMENT_S and (moment := self._moment(logged, group)) is not None:
                yield moment

    def __iter__(self) -> Iterator[SensorFrame]:
        return (moment.frame for moment in self.moments())

    def latest(self, topic: str, until: float) -> Envelope | None:
        """The newest message of a topic up to `until` [s] after the start, however long before it was written."""
        end = self.start + until + SAME_MOMENT_S
        for number in reversed(self._chunks.numbers_with(topic)):
            if self._chunks.spans[number].first > end:
                continue
            found = [one for one in self._chunks.messages(number) if one.topic == topic and one.logged <= end]
            if found:
                return found[-1]
        return None

    def every(self, topic: str) -> Iterator[Envelope]:
        """Every message of a topic; only the chunks that hold some are read."""
        for number in self._chunks.numbers_with(topic):
            yield from (one for one in self._chunks.messages(number) if one.topic == topic)

    def attached(self, name: str) -> bytes | None:
        """The content of an attached file; None where there is none, or it cannot be read."""
        with contextlib.suppress(OSError, *BROKEN_RECORD), self.path.open("rb") as file:
            return next((one.data for one in make_reader(file).iter_attachments() if one.name == name), None)
        return None

    @property
    def has_results(self) -> bool:
        """True where what was made of the readings was recorded, too."""
        return next((True for _ in self.places()), False)

    def places(self) -> Iterator[tuple[float, frame_record.Row]]:
        """Time [s] after the start and pose of every frame; nothing else of it is read."""
        for number in range(len(self._chunks.spans)):
            for one in self._chunks.messages(number):
                pose = _pose(one) if one.topic == FRAME else None
                if pose is not None:
                    yield one.logged - self.start, pose

    def moment_of(self, found: Envelope) -> DriveMoment | None:
        """The moment in which a message was written."""
        for logged, group in self._groups(self._chunks.number_at(found.logged)):
            if any(one is found or (one.topic, one.logged) == (found.topic, found.logged) for one in group):
                return self._moment(logged, group)
            if logged > found.logged:
                break
        return None

    def _groups(self, first: int) -> Iterator[tuple[float, tuple[Envelope, ...]]]:
        """Messages that were written together, from a chunk on; a moment may go on in the next chunk."""
        held, framed = list[Envelope](), False  # a record of a frame is among them
        for number in range(first, len(self._chunks.spans)):
            for one in self._chunks.messages(number):
                begins = one.topic == FRAME and framed
                if held and (begins or one.logged != held[0].logged):
                    yield held[0].logged, tuple(held)
                    held, framed = [], False
                held.append(one)
                framed = framed or one.topic == FRAME
        if held:
            yield held[0].logged, tuple(held)

    def _moment(self, logged: float, group: tuple[Envelope, ...]) -> DriveMoment | None:
        moment = DriveMoment(logged, group, self._record(group), self._tally)
        return moment if moment.is_frame else None

    def _record(self, group: tuple[Envelope, ...]) -> FrameRecord | None:
        for one in group:
            if one.topic == FRAME:
                try:
                    return frame_record.decode(text_of(one))
                except UNREADABLE:
                    self._tally.skip("it cannot be decoded", f"a message of {one.topic}")
        return None


class _PoseResult(msgspec.Struct):
    pose: frame_record.Row


class _PoseRecord(msgspec.Struct):
    results: _PoseResult | None = None


pose_decoder = msgspec.json.Decoder(_PoseRecord)


def _pose(one: Envelope) -> frame_record.Row | None:
    try:
        results = pose_decoder.decode(text_of(one)).results
    except UNREADABLE:
        return None
    return None if results is None else results.pose


def text_of(one: Envelope) -> bytes:
    """The text of a std_msgs/String, without decoding what need not be. Raises ValueError."""
    (length,) = struct.unpack_from("<I", one.content, 4)
    if not 0 < length <= len(one.content) - 8:
        raise ValueError("a text longer than its message")
    return one.content[8 : 8 + length - 1]


def _scan(topic: str, content: Any) -> Scan:
    name = topic.removeprefix("/scan").strip("/")
    return Scan(
        stamp=stamp_of(content.header),
        laser=name or content.header.frame_id,
        ranges=content.ranges.astype(np.float64),
        angle_min=float(content.angle_min),
        angle_step=float(content.angle_increment),
        range_min=float(content.range_min),
        range_max=float(content.range_max),
        time_step=float(content.time_increment),
    )


def _wheels(_topic: str, content: Any) -> tuple[float, Wheels]:
    place, turned, twist = content.pose.pose.position, content.pose.pose.orientation, content.twist.twist
    heading = float(heading_of(turned.x, turned.y, turned.z, turned.w))
    wheels = Wheels(
        odometry=Pose(place.x, place.y, heading), speed=float(twist.linear.x), turn_rate=float(twist.angular.z)
    )
    return stamp_of(content.header), wheels


def _image(_topic: str, content: Any) -> Image:
    packed = content.data.tobytes()
    pixels = unpack_picture(packed)
    if pixels is None:
        raise ValueError("no picture")
    return Image(stamp=stamp_of(content.header), camera=content.header.frame_id, pixels=pixels, packed=packed)


def _sound(_topic: str, content: Any) -> Sound:
    channels = int(content.number_of_channels)
    pcm: Array = np.frombuffer(content.data.tobytes(), "<i2").reshape(-1, channels)
    return Sound(stamp=seconds_of(content.timestamp), rate=int(content.sample_rate), samples=samples_of(pcm))


READERS: dict[str, Callable[[str, Any], Any]] = {
    LASER_SCAN: _scan,
    ODOMETRY: _wheels,
    COMPRESSED: _image,
    RAW_AUDIO: _sound,
}
"""A message's topic and content → the reading."""
