"""A recording while it grows: one MCAP of ROS 2 messages, readable to its last second however it ends.

It is called NAME.mcap.part until it is finished. The open chunk is closed once a second, for what lies in it is lost
with the process; the disk is synchronized at the same time.
"""

import contextlib
import errno
import fcntl
import os
import struct
import time
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO

import zstandard
from mcap.exceptions import McapError
from mcap.writer import CompressionType, Writer

from core.errors import Unwritable
from core.files import reason, saving
from core.message import message
from core.recording.ros_writing import LATCHED_QOS, LATCHED_TOPICS, RosMessage, definition, type_hash

PART = ".part"  # behind the name of a recording that grows
CHUNK_BYTES = 262_144  # of messages, packed together: a seek unpacks few of them
FLUSH_PERIOD_S = 0.4  # [s] of messages that may be lost with the process
NS_PER_S = 1_000_000_000
BROKEN_RECORD = (McapError, struct.error, zstandard.ZstdError, ValueError)  # what a reader raises at a damaged one


@message
class RecordedFile:
    """A recording as far as it is written."""

    path: Path
    seconds: float
    bytes: int
    messages: Mapping[str, int]  # by topic


class McapRecording:
    """Writes one file. Raises Unwritable, from every method, where the disk does not take it."""

    def __init__(self, path: Path, part: Path | None = None) -> None:
        """`path` ends in .mcap; until the file is finished it is called `part`, None: PART is put behind its name.

        Raises Unwritable, too, where something stands at either.
        """
        self.path = path
        self._part = part or path.with_name(path.name + PART)
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._counts: Counter[str] = Counter()
        self._first = self._last = 0  # [ns] log times
        self._chunked, self._flushed = 0, time.monotonic()  # [ns] log time of the open chunk
        self._ended = False
        try:
            if path.exists():
                raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
            self._file = open(self._part, "xb", opener=private)  # noqa: SIM115
            locked(self._file)
            self._writer = Writer(self._file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
            self._writer.start(profile="ros2", library="beckon")
        except OSError as trouble:
            raise Unwritable(f"{path.name} cannot be recorded: {reason(trouble)}") from None

    @property
    def seconds(self) -> float:
        """From the first message to the last [s]."""
        return (self._last - self._first) / NS_PER_S

    @property
    def written(self) -> RecordedFile:
        """The file as it is now."""
        path = self.path if self._ended else self._part
        return RecordedFile(
            path=path, seconds=self.seconds, bytes=self._size(path), messages=dict(sorted(self._counts.items()))
        )

    def add(self, messages: Iterable[RosMessage], logged: float) -> None:
        """Write messages that came at `logged` [s], Unix time."""
        log_time = max(round(logged * NS_PER_S), 0)
        with self._writing():
            if log_time - self._chunked > NS_PER_S:
                self._writer.flush()
                self._chunked = log_time
            for one in messages:
                number = self._counts[one.topic]
                self._counts[one.topic] += 1
                stamp = max(round(one.stamp * NS_PER_S), 0)
                self._writer.add_message(self._channel(one.topic, one.kind), log_time, one.data, stamp, number)
        self.flush_when_due()
        self._first, self._last = self._first or log_time, log_time

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        """Put a whole file into it."""
        now = time.time_ns()
        with self._writing():
            self._writer.add_attachment(now, now, name, media_type, content)

    def describe(self, name: str, values: Mapping[str, str]) -> None:
        """Put names and texts into it."""
        with self._writing():
            self._writer.add_metadata(name, dict(values))

    def flush_when_due(self) -> None:
        """Flush what is older than FLUSH_PERIOD_S; to be called also while nothing comes."""
        if time.monotonic() - self._flushed > FLUSH_PERIOD_S:
            with self._writing():
                self.flush()

    def flush(self) -> None:
        """Close the open chunk, and have the disk take it. Raises OSError."""
        self._writer.flush()
        self._file.flush()
        os.fsync(self._file.fileno())
        self._flushed = time.monotonic()

    def discard(self) -> None:
        """Remove what is written."""
        with contextlib.suppress(OSError):
            self._file.close()  # the disk may be full
        self._part.unlink(missing_ok=True)

    def finish(self) -> RecordedFile:
        """Write the index, and give the file its name."""
        try:
            with self._writing():
                if not self._ended:
                    self._writer.finish()
                    self._file.flush()
                    os.fsync(self._file.fileno())
                    if self.path.exists():
                        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))
                    self._part.rename(self.path)
                    self._file.close()  # held until here: nobody recovers what is finished
                    self._ended = True
        except Unwritable:
            with contextlib.suppress(OSError):
                self._file.close()  # what is held back must not come behind a recovered end
            raise
        return self.written

    def _channel(self, topic: str, kind: str) -> int:
        if topic not in self._channels:
            if kind not in self._schemas:
                text = definition(kind).encode()
                self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", text)
            quality = LATCHED_QOS if topic in LATCHED_TOPICS else ""
            more = {"offered_qos_profiles": quality, "topic_type_hash": type_hash(kind)}
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[kind], more)
        return self._channels[topic]

    def _writing(self) -> AbstractContextManager[None]:
        return saving(f"The recording {self.path.name} ends here")

    def _size(self, path: Path) -> int:
        try:
            return path.stat().st_size
        except OSError:
            return 0


def locked(file: IO[bytes]) -> bool:
    """Lock a file for as long as it is open; False: it is locked already. A disk that knows no locks holds none."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def private(name: str, flags: int) -> int:
    """Open a file that is its owner's alone."""
    return os.open(name, flags, 0o600)
