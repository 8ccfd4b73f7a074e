"""Finish a recording whose process ended before its index was written, in place: a full disk has no room for two."""

import contextlib
import errno
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader, breakup_chunk

from core.errors import Refused, Unwritable
from core.files import reason
from core.recording.mcap_file import MAGIC
from core.recording.mcap_writing import BROKEN_RECORD, NS_PER_S, PART, RecordedFile, locked

NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


@dataclass
class _Block:
    """A record of the file that its index names."""

    end: int  # [bytes], with the message indexes of a chunk
    index: ChunkIndex | AttachmentIndex | MetadataIndex
    messages: dict[int, MessageIndex] = field(default_factory=dict[int, MessageIndex])  # of a chunk, by channel


def recovered(part: Path, more: Mapping[str, str]) -> RecordedFile | None:
    """Finish a recording whose process has ended → the finished file; None: nothing is left to do.

    `more` is added to its description. What follows the last whole chunk is overwritten by the index; where the disk
    has no room for that, the last chunks give way to it. Raises Unwritable, and Refused while a process writes it;
    then `part` can be recovered again.
    """
    try:
        with part.open("r+b") as file:
            if not locked(file):
                raise Refused(f"{part.name} is still being written.")
            remains = _Remains(file)
            if remains.chunks:
                remains.finish(more)
        if not remains.chunks:
            part.unlink()
            return None
        whole = _free(part.with_name(part.name.removesuffix(PART)))
        part.rename(whole)
    except FileNotFoundError:
        return None  # its process has just finished it
    except OSError as trouble:
        raise Unwritable(f"{part.name} cannot be recovered: {reason(trouble)}") from None
    return remains.written(whole)


class _Remains:
    """All that is whole in a file without an end."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._size = file, file.seek(0, os.SEEK_END)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._described: Metadata | None = None  # its newest description
        self._blocks: list[_Block] = []
        file.seek(0)
        with contextlib.suppress(*BROKEN_RECORD):
            for begin, end, record in _records(file):
                self._take(begin, end, record)

    def _take(self, begin: int, end: int, record: McapRecord) -> None:
        match record:
            case Chunk():
                self._blocks.append(self._chunk(begin, end, record))
            case MessageIndex() if self._blocks and isinstance(index := self._blocks[-1].index, ChunkIndex):
                index.message_index_offsets[record.channel_id] = begin
                index.message_index_length += end - begin
                self._blocks[-1].end = end
            case Attachment():
                facts = (record.log_time, record.create_time, len(record.data), record.name, record.media_type)
                self._blocks.append(_Block(end, AttachmentIndex(begin, end - begin, *facts)))
            case Metadata():
                self._described = record
                self._blocks.append(_Block(end, MetadataIndex(begin, end - begin, record.name)))
            case _:
                pass

    def _chunk(self, begin: int, end: int, chunk: Chunk) -> _Block:
        """The chunk with the indexes of its messages. Raises BROKEN_RECORD where it is damaged."""
        builder, messages = RecordBuilder(), dict[int, MessageIndex]()
        for record in breakup_chunk(chunk, validate_crc=True):
            at = builder.count
            record.write(builder)
            match record:
                case Schema():
                    self._schemas[record.id] = record
                case Channel():
                    self._channels[record.id] = record
                case Message():
                    of = messages.setdefault(record.channel_id, MessageIndex(record.channel_id, []))
                    of.records.append((record.log_time, at))
                case _:
                    pass
        index = ChunkIndex(
            end - begin,
            begin,
            chunk.compression,
            len(chunk.data),
            chunk.message_end_time,
            0,
            {},
            chunk.message_start_time,
            chunk.uncompressed_size,
        )
        return _Block(end, index, messages)

    @property
    def chunks(self) -> list[ChunkIndex]:
        return [block.index for block in self._blocks if isinstance(block.index, ChunkIndex)]

    def finish(self, more: Mapping[str, str]) -> None:
        """Write the index behind what is whole. Raises OSError."""
        try:
            self._write(*self._tail(more))
        except OSError as trouble:
            if trouble.errno not in NO_SPACE:
                raise
            begin, tail = self._tail(more)
            while begin + len(tail) > self._size and len(self.chunks) > 1:
                self._blocks.pop()
                begin, tail = self._tail(more)
            self._write(begin, tail)

    def written(self, path: Path) -> RecordedFile:
        first, last = self._span
        counts = {self._channels[number].topic: count for number, count in self._counts.items()}
        return RecordedFile(
            path=path,
            seconds=(last - first) / NS_PER_S,
            bytes=path.stat().st_size,
            messages=dict(sorted(counts.items())),
        )

    @property
    def _span(self) -> tuple[int, int]:
        """Log time of the first message and of the last [ns]."""
        chunks = self.chunks
        return min(one.message_start_time for one in chunks), max(one.message_end_time for one in chunks)

    @property
    def _counts(self) -> Counter[int]:
        counts = Counter[int]()
        for block in self._blocks:
            counts.update({number: len(index.records) for number, index in block.messages.items()})
        return counts

    def _write(self, begin: int, tail: bytes) -> None:
        # what is overwritten first and cut off then has its place on the disk already
        self._file.seek(begin)
        self._file.write(tail)
        self._file.truncate()
        self._file.flush()
        os.fsync(self._file.fileno())

    def _tail(self, more: Mapping[str, str]) -> tuple[int, bytes]:
        """The offset at which the end of the file begins, and that end: last indexes, description and summary."""
        last, builder = self._blocks[-1], RecordBuilder()
        begin, indexes = last.end, [block.index for block in self._blocks]
        if isinstance(last.index, ChunkIndex):  # its indexes may be cut
            begin = last.index.chunk_start_offset + last.index.chunk_length
            last.index.message_index_offsets.clear()
            for number, of in last.messages.items():
                last.index.message_index_offsets[number] = begin + builder.count
                of.write(builder)
            last.index.message_index_length, last.end = builder.count, begin + builder.count
        if more and self._described is not None:
            described, at = self._described, builder.count
            Metadata(described.name, {**described.metadata, **more}).write(builder)
            indexes.append(MetadataIndex(begin + at, builder.count - at, described.name))
        DataEnd(0).write(builder)
        data = builder.end()
        return begin, data + self._summary(begin + len(data), indexes)

    def _summary(self, begin: int, indexes: list[ChunkIndex | AttachmentIndex | MetadataIndex]) -> bytes:
        """The summary that begins there, the footer and the magic."""
        groups: dict[Opcode, list[McapRecord]] = {
            Opcode.SCHEMA: [*self._schemas.values()],
            Opcode.CHANNEL: [*self._channels.values()],
            Opcode.STATISTICS: [self._statistics(indexes)],
            Opcode.CHUNK_INDEX: [one for one in indexes if isinstance(one, ChunkIndex)],
            Opcode.ATTACHMENT_INDEX: [one for one in indexes if isinstance(one, AttachmentIndex)],
            Opcode.METADATA_INDEX: [one for one in indexes if isinstance(one, MetadataIndex)],
        }
        builder, offsets = RecordBuilder(), list[SummaryOffset]()
        for opcode, records in groups.items():
            at = builder.count
            for record in records:
                record.write(builder)
            if records:
                offsets.append(SummaryOffset(opcode, begin + at, builder.count - at))
        offsets_begin = begin + builder.count
        for offset in offsets:
            offset.write(builder)
        summary = builder.end()
        head = struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, begin, offsets_begin)
        Footer(begin, offsets_begin, zlib.crc32(head, zlib.crc32(summary))).write(builder)
        return summary + builder.end() + MAGIC

    def _statistics(self, indexes: list[ChunkIndex | AttachmentIndex | MetadataIndex]) -> Statistics:
        kinds, counts, (first, last) = Counter(map(type, indexes)), self._counts, self._span
        return Statistics(
            attachment_count=kinds[AttachmentIndex],
            channel_count=len(self._channels),
            channel_message_counts=dict(counts),
            chunk_count=kinds[ChunkIndex],
            message_count=counts.total(),
            message_end_time=last,
            message_start_time=first,
            metadata_count=kinds[MetadataIndex],
            schema_count=len(self._schemas),
        )


def _records(file: IO[bytes]) -> Iterator[tuple[int, int, McapRecord]]:
    """Begin, end [bytes] and content of every record of the data. Raises BROKEN_RECORD where it is cut."""
    end = len(MAGIC)
    for record in StreamReader(file, emit_chunks=True).records:
        if isinstance(record, DataEnd):
            return
        begin, end = end, file.tell()
        yield begin, end, record


def _free(path: Path) -> Path:
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free
