"""Files from unknown sources: bounded reading, and sentences for what cannot be opened."""

import bz2
import codecs
import contextlib
import gzip
import io
import lzma
import re
import tempfile
import zlib
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self

import lz4.frame
import zstandard

from core.errors import BadInput
from core.files import LFS_POINTER, LFS_WORDS
from core.recording.read_report import BadRecord

CHUNK_BYTES = 1 << 20  # read at once while searching or unpacking
MAX_LINE_BYTES = 4_000_000  # of a text log
MAX_TEXT_BYTES = 2_000_000_000  # of unpacked text


def open_file(path: Path, largest: int) -> BinaryIO:
    """Open a regular file of at most `largest` bytes. Raises BadInput."""
    try:
        if not path.exists():
            raise BadInput(f"There is no file {path.name}; is the path right?")
        if not path.is_file():
            raise BadInput(f"{path.name} is not a file that can be read as a log.")
        size = path.stat().st_size
        if size == 0:
            raise BadInput(f"{path.name} is empty.")
        if size > largest:
            raise BadInput(
                f"{path.name} has {size / 1e9:.1f} GB; at most {largest / 1e9:.1f} GB are read. "
                "Cut it into parts, or raise log.largest_file_mb in the settings."
            )
        file = path.open("rb")
    except (OSError, ValueError) as problem:
        raise BadInput(f"{path.name} cannot be opened: {problem}.") from problem
    if file.read(len(LFS_POINTER)) == LFS_POINTER:
        file.close()
        raise BadInput(f"{path.name} {LFS_WORDS}.")
    file.seek(0)
    return file


class BinaryLog:
    """A binary log: pieces at any offset, never more than is there."""

    def __init__(self, path: Path, largest: int):
        self._file = open_file(path, largest)
        self.size = self._file.seek(0, io.SEEK_END)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def at(self, offset: int, length: int) -> bytes:
        """The bytes from `offset` on, at most `length`; fewer where the file ends."""
        self._file.seek(offset)
        return self._file.read(max(0, min(length, self.size - offset)))

    def find(self, pattern: re.Pattern[bytes], start: int, longest: int) -> int | None:
        """Offset of the next match (at most `longest` bytes long) from `start` on, or None."""
        while start < self.size:
            match = pattern.search(self.at(start, CHUNK_BYTES + longest))
            if match:
                return start + match.start()
            start += CHUNK_BYTES
        return None


def unpack(packed: bytes, compression: str, size: int, limit: int) -> bytes:
    """A compressed block → its content; of a block that is cut or damaged, what comes before the damage.

    `size` is what the file says it unpacks to [bytes]: never more is unpacked. Raises BadRecord when the compression
    is unknown or `size` exceeds `limit` bytes.
    """
    if compression in ("", "none"):
        return packed
    if size > limit:
        raise BadRecord(f"its block unpacks to {size // 1_000_000} MB, more than is read")
    pieces: list[bytes] = []
    total = 0
    for piece in _unpacked(packed, compression, limit):
        pieces.append(piece)
        total += len(piece)
        if total >= size:
            break
    return b"".join(pieces)[:size]


def _unpacked(packed: bytes, compression: str, limit: int) -> Iterator[bytes]:
    """Bounded pieces; ends quietly where the data are damaged."""
    try:
        if compression == "zstd":
            window = 1 << max(20, (limit - 1).bit_length())
            with zstandard.ZstdDecompressor(max_window_size=window).stream_reader(packed) as reader:
                while piece := reader.read(CHUNK_BYTES):
                    yield piece
            return
        if compression not in ("lz4", "bz2"):
            raise BadRecord(f"its compression {compression[:20]!r} is unknown")
        unpacker = lz4.frame.LZ4FrameDecompressor() if compression == "lz4" else bz2.BZ2Decompressor()
        piece = unpacker.decompress(packed, max_length=CHUNK_BYTES)
        while piece or not (unpacker.eof or unpacker.needs_input):
            yield piece
            if unpacker.eof:
                return
            piece = unpacker.decompress(b"", max_length=CHUNK_BYTES)
    except (zstandard.ZstdError, RuntimeError, OSError, EOFError, ValueError):
        return


BINARY = re.compile(rb"\x89MCAP|#ROSBAG|SQLite format|PK\x03\x04|\x1f\x8b")  # how a log begins that is no text
PACKERS: dict[bytes, Callable[[BinaryIO], Any]] = {
    b"\x1f\x8b": lambda raw: gzip.GzipFile(fileobj=raw),
    b"BZh": lambda raw: bz2.BZ2File(raw),
    b"\xfd7zXZ\0": lzma.open,
    b"\x04\x22\x4d\x18": lambda raw: lz4.frame.LZ4FrameFile(raw),
    b"\x28\xb5\x2f\xfd": lambda raw: zstandard.ZstdDecompressor().stream_reader(raw, read_across_frames=True),
}
"""How a packed file begins, and what reads it."""
READING_ERRORS = (EOFError, OSError, RuntimeError, ValueError, lzma.LZMAError, zlib.error, zstandard.ZstdError)
"""Errors of the readers at a cut or damaged place."""


def first_bytes(path: Path, count: int) -> bytes:
    """How a file begins; b"" where that cannot be read, or would be gone then, or wait for a writer, as of a pipe."""
    try:
        if not path.is_file():
            return b""
        with path.open("rb") as file:
            return file.read(count)
    except (OSError, ValueError):
        return b""


def is_packed(path: Path) -> bool:
    """Return whether a file is packed as a whole; text that is gzip'ed is read as it is."""
    head = first_bytes(path, 6)
    if not head.startswith(b"\x1f\x8b"):
        return any(head.startswith(magic) for magic in PACKERS)
    try:
        with gzip.open(path) as file:
            return bool(BINARY.match(file.read(16)))
    except READING_ERRORS:
        return False


@contextlib.contextmanager
def unpacked_file(path: Path, largest: int) -> Generator[Path]:
    """The content of a packed file, in a temporary one that is gone afterwards; what is cut stays as far as it goes.

    Raises BadInput where it has more than `largest` bytes or nothing of it can be unpacked.
    """
    head = first_bytes(path, 6)
    pack = next(open_pack for magic, open_pack in PACKERS.items() if head.startswith(magic))
    with tempfile.TemporaryDirectory(prefix="beckon-log-") as folder, open_file(path, largest) as raw:
        content = Path(folder) / path.stem
        with content.open("wb") as out, contextlib.suppress(*READING_ERRORS):
            source = pack(raw)
            while piece := source.read1(CHUNK_BYTES):  # what is there before a damage
                if out.tell() + len(piece) > largest:
                    raise BadInput(
                        f"{path.name} unpacks to more than {largest / 1e9:.1f} GB. Cut it into parts, or raise "
                        "log.largest_file_mb in the settings."
                    )
                out.write(piece)
        if content.stat().st_size == 0:
            raise BadInput(f"{path.name} is packed and damaged: nothing of it can be unpacked.")
        yield content


class TextLog:
    """A text log, plain or gzip'ed: its lines with their numbers."""

    def __init__(self, path: Path, largest: int):
        self.path = path
        self._largest = largest
        self.cut = False  # the packed text ended too early

    def __iter__(self) -> Iterator[tuple[int, str]]:
        with open_file(self.path, self._largest) as raw:
            packed = raw.read(2) == b"\x1f\x8b"
            raw.seek(0)
            yield from self._lines(io.BufferedReader(gzip.GzipFile(fileobj=raw)) if packed else raw)

    def _lines(self, stream: BinaryIO | io.BufferedReader) -> Iterator[tuple[int, str]]:
        number, total = 0, 0
        try:
            wide = stream.peek(2)[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)  # type: ignore[union-attr]
            text = io.TextIOWrapper(stream, "utf-16" if wide else "utf-8-sig", errors="replace")  # type: ignore[arg-type]
            while total < MAX_TEXT_BYTES and (line := text.readline(MAX_LINE_BYTES)):
                number += 1
                total += len(line)
                yield number, line.strip()
        except READING_ERRORS:
            self.cut = True
