"""An MCAP file that stays open: its chunks in any order, for what plays and seeks in a long recording.

`mcap_file` reads a file from its beginning to its end; here the index says where a time lies. A file without one,
which was cut, is read once for it.
"""

import bisect
import itertools
from collections import OrderedDict
from pathlib import Path
from typing import BinaryIO, cast

from mcap.reader import SeekingReader
from mcap.summary import Summary

from core.errors import BadInput
from core.recording.mcap_file import CHUNK_OPCODE, HEAD, MAGIC, NANOSECOND_S, ChunkSpan, McapWalk
from core.recording.mcap_writing import BROKEN_RECORD
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings
from core.recording.ros import Envelope
from core.recording.source import BinaryLog

HELD_CHUNKS = 8  # unpacked ones that are kept


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
        """The last chunk that begins at that time [s] or before."""
        return max(bisect.bisect_right(self._firsts, logged) - 1, 0)

    def numbers_with(self, topic: str) -> list[int]:
        """The chunks with messages of this topic."""
        return [bisect.bisect_left(self._begins, begin) for begin in sorted(self._holding.get(topic, []))]

    def _listed(self, summary: Summary) -> list[ChunkSpan]:
        schemas = [(number, one.name) for number, one in summary.schemas.items()]
        channels = [(key, one.topic, one.message_encoding, one.schema_id) for key, one in summary.channels.items()]
        self._walk.know(schemas, channels)
        if summary.statistics is not None:
            counted = summary.statistics.channel_message_counts
            self.counts = {summary.channels[number].topic: count for number, count in counted.items()}
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
