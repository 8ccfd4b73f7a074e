"""MCAP, record by record in the order of the file, so that a cut or damaged file gives all that is left of it.

Layout from the MCAP specification 1.0: magic, then records of opcode (u8), length (u64) and content, little endian.
"""

import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from core.errors import BadInput
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import Envelope
from core.recording.source import BinaryLog, unpack

MAGIC = b"\x89MCAP0\r\n"
NANOSECOND_S = 1e-9
FOOTER_OPCODE, SCHEMA_OPCODE, CHANNEL_OPCODE, MESSAGE_OPCODE, CHUNK_OPCODE, STATISTICS_OPCODE = (
    0x02,
    0x03,
    0x04,
    0x05,
    0x06,
    0x0B,
)
LAST_OPCODE = 0x0F

HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time [ns]
CHUNK_HEAD = struct.Struct("<QQQI")  # start, end [ns], unpacked size, checksum

# A compressed chunk betrays itself by the name of its compression: from there reading can start again after damage.
CHUNK_MARK = re.compile(rb"\x06.{36}(?:\x04\0\0\0zstd|\x03\0\0\0lz4)", re.DOTALL)
CHUNK_MARK_LENGTH = 9 + 28 + 8
MOST_RESTARTS = 500


@dataclass
class _Channel:
    topic: str
    encoding: str
    schema: int


@dataclass(frozen=True)
class ChunkSpan:
    """A chunk in the file, and from when to when it goes by the recorder's clock."""

    begin: int  # [bytes] of its content
    length: int
    first: float  # [s]
    last: float


def messages(path: Path, settings: LogSettings, tally: ReadReport) -> Iterator[Envelope]:
    """Every message of an MCAP file in the order of the file. Raises BadInput when it is none."""
    with BinaryLog(path, settings.largest_file) as source:
        if source.at(0, len(MAGIC)) != MAGIC:
            raise BadInput(f"{path.name} is not an MCAP file: it does not begin as one.")
        yield from McapWalk(source, settings.largest_block, tally).messages()


class McapWalk:
    """One pass over the records."""

    def __init__(self, source: BinaryLog, largest_block: int, tally: ReadReport):
        self._source = source
        self._largest_block = largest_block
        self._tally = tally
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, _Channel] = {}
        self._restarts = 0
        self._budget = max(50 * source.size, 4 * largest_block)  # [bytes] that all blocks together may unpack to
        self._unpacked: dict[int, int] = {}  # [bytes] that each block took of it, once however often it is read

    def messages(self) -> Iterator[Envelope]:
        """Every message, in the order of the file."""
        for opcode, begin, length in self.records():
            yield from self.within(opcode, begin, length)

    def records(self) -> Iterator[tuple[int, int, int]]:
        """Opcode, begin and length of every record that is sound, and of a chunk that is cut by the file's end."""
        offset, closed = len(MAGIC), False
        while not closed:
            head = self._source.at(offset, HEAD.size)
            if len(head) < HEAD.size:
                self._tally.skip("the file ends in the middle of a record", f"byte {offset}")
                return
            opcode, length = HEAD.unpack(head)
            begin, end = offset + HEAD.size, offset + HEAD.size + length
            sound = end <= self._source.size and (1 <= opcode <= LAST_OPCODE or opcode >= 0x80)
            if not sound:
                again = self._restart(offset + 1)
                what = "it is damaged" if again else "the file ends in the middle of a record"
                self._tally.skip(what, f"byte {offset}")
                if opcode == CHUNK_OPCODE and again is None:
                    yield opcode, begin, self._source.size - begin
                if again is None:
                    return
                offset = again
                continue
            yield opcode, begin, length
            closed, offset = opcode == FOOTER_OPCODE, end

    def within(self, opcode: int, begin: int, length: int) -> Iterator[Envelope]:
        """The messages of one record."""
        if opcode == CHUNK_OPCODE:
            yield from self._chunk(begin, length)
        elif opcode == STATISTICS_OPCODE:
            content = self._source.at(begin, 8)
            self._tally.declared = struct.unpack("<Q", content)[0] if len(content) == 8 else None
        elif opcode in (SCHEMA_OPCODE, CHANNEL_OPCODE, MESSAGE_OPCODE):
            yield from self._record(opcode, self._source.at(begin, min(length, self._largest_block)))

    def span(self, begin: int, length: int) -> ChunkSpan | None:
        """Return the place of a chunk and from when to when it goes; None where it is cut before that."""
        head = self._source.at(begin, CHUNK_HEAD.size)
        if len(head) < CHUNK_HEAD.size:
            return None
        first, last, *_ = CHUNK_HEAD.unpack(head)
        return ChunkSpan(begin, length, first * NANOSECOND_S, last * NANOSECOND_S)

    def know(self, schemas: Iterable[tuple[int, str]], channels: Iterable[tuple[int, str, str, int]]) -> None:
        """Learn from the summary: number and name; number, topic, encoding and schema."""
        self._schemas |= dict(schemas)
        self._channels |= {number: _Channel(topic, encoding, kind) for number, topic, encoding, kind in channels}

    def _restart(self, start: int) -> int | None:
        """The next offset from `start` on where a chunk seems to begin, or None."""
        self._restarts += 1
        return self._source.find(CHUNK_MARK, start, CHUNK_MARK_LENGTH) if self._restarts < MOST_RESTARTS else None

    def _chunk(self, begin: int, length: int) -> Iterator[Envelope]:
        where = f"byte {begin - HEAD.size}"
        try:
            if length > self._largest_block + 1000:
                raise BadRecord(f"its block is larger than {self._largest_block // 1_000_000} MB")
            content = self._source.at(begin, length)
            *_, size, checksum = CHUNK_HEAD.unpack_from(content)
            compression, at = _text(content, CHUNK_HEAD.size)
            packed = content[at + 8 :]
            self._budget += self._unpacked.pop(begin, 0)
            block = unpack(packed, compression, size, min(self._largest_block, self._budget))
            self._unpacked[begin] = len(block)
            self._budget -= len(block)
        except (BadRecord, struct.error, ValueError) as problem:
            self._tally.skip(str(problem) if isinstance(problem, BadRecord) else "it is damaged", where)
            return
        if checksum and zlib.crc32(block) != checksum:
            self._tally.warn("Some blocks of the file fail their checksum; what was read from them may be wrong.")
        yield from self._inside(block, where)

    def _inside(self, block: bytes, where: str) -> Iterator[Envelope]:
        at = 0
        while at < len(block):
            if at + HEAD.size > len(block):
                break
            opcode, length = HEAD.unpack_from(block, at)
            begin, at = at + HEAD.size, at + HEAD.size + length
            if opcode not in (SCHEMA_OPCODE, CHANNEL_OPCODE, MESSAGE_OPCODE) and opcode < 0x80:
                at = len(block) + 1
            elif at <= len(block):
                yield from self._record(opcode, block[begin:at])
        if at != len(block):
            self._tally.skip("its block is cut or damaged", where)

    def _record(self, opcode: int, content: bytes) -> Iterator[Envelope]:
        try:
            if opcode == SCHEMA_OPCODE:
                self._schemas[struct.unpack_from("<H", content)[0]] = _text(content, 2)[0]
            elif opcode == CHANNEL_OPCODE:
                number, schema = struct.unpack_from("<HH", content)
                topic, at = _text(content, 4)
                self._channels[number] = _Channel(topic, _text(content, at)[0], schema)
            elif opcode == MESSAGE_OPCODE:
                number, _, log_time, _ = MESSAGE_HEAD.unpack_from(content)
                channel = self._channels[number]
                kind = self._schemas.get(channel.schema, "")
                logged, packed = log_time * NANOSECOND_S, content[MESSAGE_HEAD.size :]
                yield Envelope(channel.topic, kind, channel.encoding, logged, packed)
        except (struct.error, KeyError, ValueError):
            self._tally.skip("it is damaged")


def _text(content: bytes, at: int) -> tuple[str, int]:
    """A text with its length before it, at `at` → the text and where it ends. Raises ValueError."""
    (length,) = struct.unpack_from("<I", content, at)
    if length > 10_000 or at + 4 + length > len(content):
        raise ValueError("a text longer than its record")
    return content[at + 4 : at + 4 + length].decode("utf-8", "replace"), at + 4 + length
