"""ROS 1 bags, version 2.0, record by record: the index, which is what breaks, is not used.

A record is a header (length u32, then fields of length u32 and `name=value`) and data (length u32, bytes), all little
endian.
"""

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from core.errors import BadInput
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import Envelope
from core.recording.source import BinaryLog, unpack

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE_OP, CHUNK_OP, CHUNK_COUNTS_OP, CONNECTION_OP = 2, 5, 6, 7
MAX_HEADER_BYTES = 10_000

MARK = re.compile(rb"\x04\0\0\0op=[\x02-\x07]", re.DOTALL)  # every header has it, after at most LOOK_BACK bytes
MARK_LENGTH = 8
LOOK_BACK_BYTES = 400
MOST_RESTARTS = 500

Fields = dict[bytes, bytes]


def messages(path: Path, settings: LogSettings, tally: ReadReport) -> Iterator[Envelope]:
    """Every message of a ROS 1 bag in the order of the file. Raises BadInput when it is none."""
    with BinaryLog(path, settings.largest_file) as source:
        if source.at(0, len(MAGIC)) != MAGIC:
            if source.at(0, 9) in (b"#ROSBAG V", b"#ROSRECOR"):
                raise BadInput(f"{path.name} is a ROS bag from before version 2.0. Convert it: rosbag fix OLD NEW.")
            raise BadInput(f"{path.name} is not a ROS 1 bag of version 2.0: it does not begin as one.")
        yield from _BagWalk(source, settings.largest_block, tally).messages()


class _BagWalk:
    def __init__(self, source: BinaryLog, largest_block: int, tally: ReadReport):
        self._source = source
        self._largest_block = largest_block
        self._tally = tally
        self._connections: dict[bytes, tuple[str, str]] = {}  # number → topic, type
        self._budget = max(50 * source.size, 4 * largest_block)  # [bytes] that all blocks together may unpack to
        self._restarts = 0

    def messages(self) -> Iterator[Envelope]:
        offset: int | None = len(MAGIC)
        uncertain = len(MAGIC)  # up to here everything was understood; a wrong length may lie after it
        declared = 0
        while offset is not None and offset < self._source.size:
            fields, begin, length = self._head(offset)
            if fields is None or begin + length > self._source.size:
                again = self._restart(uncertain)
                what = "it is damaged" if again else "the file ends in the middle of a record"
                self._tally.skip(what, f"byte {offset}")
                if again is None and fields is not None and fields[b"op"] == bytes([CHUNK_OP]):
                    yield from self._chunk(fields, begin, self._source.size - begin)
                offset, uncertain = again, (again or 0) + 1
                continue
            code = fields[b"op"][0]
            if code == CHUNK_OP:
                yield from self._chunk(fields, begin, length)
            elif code == CHUNK_COUNTS_OP:
                counts = self._source.at(begin, min(length, self._largest_block))
                declared += sum(count for _, count in struct.iter_unpack("<II", counts[: len(counts) // 8 * 8]))
            elif code in (MESSAGE_OP, CONNECTION_OP):
                yield from self._record(fields, self._source.at(begin, min(length, self._largest_block)))
            offset = begin + length
            uncertain = offset if code == CHUNK_OP else begin
        self._tally.declared = declared or None

    def _head(self, offset: int) -> tuple[Fields | None, int, int]:
        """The record at `offset` → its fields (None: no record), where its data begin, and their length."""
        (size,) = struct.unpack("<I", self._source.at(offset, 4).ljust(4, b"\xff"))
        if not 0 < size <= MAX_HEADER_BYTES:
            return None, 0, 0
        piece = self._source.at(offset + 4, size + 4)
        if len(piece) < size + 4:
            return None, 0, 0
        return _header(piece[:size]), offset + 8 + size, struct.unpack("<I", piece[size:])[0]

    def _restart(self, start: int) -> int | None:
        """The next offset from `start` on where a record seems to begin, or None."""
        while self._restarts < MOST_RESTARTS:
            self._restarts += 1
            mark = self._source.find(MARK, start, MARK_LENGTH)
            if mark is None:
                return None
            for offset in range(mark - 4, max(start, mark - LOOK_BACK_BYTES) - 1, -1):
                fields, begin, length = self._head(offset)
                if fields is not None and begin > mark and begin + length <= self._source.size:
                    return offset
            start = mark + 1
        return None

    def _chunk(self, fields: Fields, begin: int, length: int) -> Iterator[Envelope]:
        where = f"byte {begin}"
        try:
            if length > self._largest_block:
                raise BadRecord(f"its block is larger than {self._largest_block // 1_000_000} MB")
            compression = fields.get(b"compression", b"none").decode("ascii", "replace")
            size = struct.unpack("<I", fields.get(b"size", b"").rjust(4, b"\xff")[:4])[0]
            content = self._source.at(begin, length)
            block = unpack(content, compression, size, min(self._largest_block, self._budget))
            self._budget -= len(block)
        except BadRecord as problem:
            self._tally.skip(str(problem), where)
            return
        at = 0
        while at < len(block):
            (size,) = struct.unpack("<I", block[at : at + 4].ljust(4, b"\xff"))
            data = at + 4 + size
            inner = _header(block[at + 4 : data]) if size <= MAX_HEADER_BYTES and data + 4 <= len(block) else None
            end = data + 4 + struct.unpack_from("<I", block, data)[0] if inner is not None else len(block) + 1
            if inner is None or end > len(block):
                self._tally.skip("its block is cut or damaged", where)
                return
            yield from self._record(inner, block[data + 4 : end])
            at = end

    def _record(self, fields: Fields, content: bytes) -> Iterator[Envelope]:
        number = fields.get(b"conn", b"")
        if fields[b"op"][0] == CONNECTION_OP:
            own = _fields(content) or {}
            topic = own.get(b"topic", fields.get(b"topic", b"")).decode("utf-8", "replace")
            self._connections[number] = topic, own.get(b"type", b"").decode("utf-8", "replace")
        elif fields[b"op"][0] == MESSAGE_OP:
            stamp = fields.get(b"time", b"")
            if len(stamp) != 8 or number not in self._connections:
                self._tally.skip("it is damaged")
                return
            seconds, nanoseconds = struct.unpack("<II", stamp)
            topic, kind = self._connections[number]
            yield Envelope(topic, kind, "ros1", seconds + nanoseconds * 1e-9, content)


def _fields(header: bytes) -> Fields | None:
    """A header → its fields, or None when it is none."""
    fields: Fields = {}
    at = 0
    while at < len(header):
        (size,) = struct.unpack("<I", header[at : at + 4].ljust(4, b"\xff"))
        at += 4 + size
        name, mark, value = header[at - size : at].partition(b"=")
        if at > len(header) or not mark:
            return None
        fields[name] = value
    return fields


def _header(header: bytes) -> Fields | None:
    """A record's header → its fields, or None when it is none: every header says what its record is."""
    fields = _fields(header)
    return fields if fields is not None and len(fields.get(b"op", b"")) == 1 else None
