"""Pictures from strangers: looked at before they are decoded, and refused in words."""

import contextlib
import os
import re
import struct
import tempfile
import threading
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from core.calibration.files.pgm import HeadMismatch, in_8_bits, pgm_size, read_pgm
from core.errors import BadInput
from core.files import LFS_POINTER, LFS_WORDS
from core.message import Array
from core.sensors.checks import UnusableReading, fault

MOST_BYTES = 40 * 2**20
MOST_PIXELS = 2**25
MOST_OF_A_PHOTOGRAPH = 2**26  # pixels: telephones take 50 million
MIN_SIDE_PX = 64
MAX_TAIL_BYTES = 4096  # bytes after the end mark that cameras and editors are known to add
PNG_HEAD = b"\x89PNG\r\n\x1a\n"
DAMAGE = re.compile(rb"Corrupt JPEG data: (?!([012]) extraneous bytes)")  # webcams are known to add two bytes
ERROR_OUTPUT, ERROR_LOCK = 2, threading.Lock()  # of the process, which belongs to one decoder at a time
SCAN_MARKER = 0xDA  # marker of a JPEG, after which its pixels begin: no end mark is among them


class Header(NamedTuple):
    """The header fields of a picture."""

    width: int
    height: int
    complete: bool  # its end mark is there
    turned: bool  # it asks to be shown turned


def read_grey(path: Path) -> tuple[Array, str]:
    """A picture file → grey (H, W) uint8 as the sensor took it, and a remark or ''. Raises BadInput."""
    return _read(path, cv2.IMREAD_GRAYSCALE)


def read_colour(path: Path) -> Array:
    """A picture file → blue-green-red (H, W, 3) uint8 as the sensor took it. Raises BadInput."""
    return _read(path, cv2.IMREAD_COLOR)[0]


def read_upright(path: Path) -> Array:
    """A photograph → blue-green-red (H, W, 3) uint8 as it is shown, turned as its EXIF asks. Raises BadInput."""
    return _read(path, cv2.IMREAD_COLOR, upright=True)[0]


def own_names(files: Sequence[Path]) -> tuple[str, ...]:
    """Label every file: its name, or its whole path where several files have the same name."""
    counts = Counter(path.name for path in set(files))
    return tuple(path.name if counts[path.name] == 1 else str(path) for path in files)


def size_words(picture: Array) -> str:
    """A picture (H, W, …) → "640x480"."""
    return f"{picture.shape[1]}x{picture.shape[0]}"


def decode(content: bytes, how: int, *, upright: bool = False, live: bool = False) -> tuple[Array, str]:
    """Bytes of a picture → its pixels and a remark or ''. Raises BadInput.

    Unless `upright`, the orientation in EXIF is not followed: it would swap width and height under a calibration.
    A damaged JPEG, which is grey from the damage on, is refused, but not among pictures of a `live` stream.
    """
    header = look(content)
    if content.startswith(LFS_POINTER):
        raise BadInput(f"it {LFS_WORDS}")
    if header is None:
        raise BadInput("this is no JPEG, PNG, BMP, WebP or PGM picture")
    most = MOST_OF_A_PHOTOGRAPH if upright else MOST_PIXELS
    if header.width * header.height > most:
        raise BadInput(f"it announces {header.width}x{header.height} pixels; at most {most // 2**20} Mpx are read")
    if min(header.width, header.height) < MIN_SIDE_PX:
        raise BadInput(f"it is only {header.width}x{header.height} pixels")
    if not header.complete:
        raise BadInput("the file is cut off")
    said = list[bytes]()
    try:
        with contextlib.nullcontext() if live else _library_words(said):
            pixels = _pixels(content, how if upright else how | cv2.IMREAD_IGNORE_ORIENTATION)
    except HeadMismatch:
        raise BadInput("its head says fewer pixels, or darker ones, than it holds; save it again") from None
    except (cv2.error, ValueError):
        pixels = None
    sizes = {(header.height, header.width)} | ({(header.width, header.height)} if upright else set())
    if pixels is None or pixels.shape[:2] not in sizes:
        moves = content[:4] == b"RIFF" and b"ANIM" in content[:64]  # OpenCV 5 reads the first frame
        raise BadInput(
            "it is an animated picture; save one of its frames"
            if moves
            else "the picture is damaged and cannot be decoded"
        )
    if any(DAMAGE.search(words) for words in said):
        raise BadInput("the picture is damaged: a part of it is lost; copy it again")
    turned = header.turned and not upright
    return pixels, "it asks to be shown turned (EXIF); it is used as the sensor took it" if turned else ""


@contextlib.contextmanager
def _library_words(said: list[bytes]) -> Generator[None]:
    """Add what libraries write to the error output meanwhile: libjpeg says there, and nowhere else, that a picture is
    damaged.

    Whatever else is written there meanwhile goes on to where it was to go.
    """
    with ERROR_LOCK, tempfile.TemporaryFile() as caught:
        try:
            kept = os.dup(ERROR_OUTPUT)
        except OSError:  # the process has none
            yield
            return
        os.dup2(caught.fileno(), ERROR_OUTPUT)
        try:
            yield
        finally:
            os.dup2(kept, ERROR_OUTPUT)
            os.close(kept)
            caught.seek(0)
            said.append(caught.read())
            others = [line for line in said[-1].splitlines(keepends=True) if b"JPEG" not in line]
            if others:
                os.write(ERROR_OUTPUT, b"".join(others))


def _pixels(content: bytes, how: int) -> Array | None:
    """Bytes of a picture → uint8, as cv2 reads it, but for PGM and for files of 16 bits that hold fewer.

    Raises ValueError, cv2.error.
    """
    if pgm_size(content) is not None:
        grey = read_pgm(content)
        return cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR) if how & cv2.IMREAD_COLOR else grey
    deep = content.startswith(PNG_HEAD) and content[24:25] == b"\x10"
    pixels = cv2.imdecode(np.frombuffer(content, np.uint8), how | cv2.IMREAD_ANYDEPTH if deep else how)
    return None if pixels is None else in_8_bits(pixels)


def _read(path: Path, how: int, *, upright: bool = False) -> tuple[Array, str]:
    content = _content(path)
    try:
        return decode(content, how, upright=upright)
    except BadInput as wrong:
        raise UnusableReading(str(wrong), (fault("picture.unreadable", path.name, what=str(wrong)),)) from None


def _content(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise BadInput(f"it is a folder; give the pictures in it, as in {path.name}/*.jpg")
        if not path.is_file():
            raise BadInput("there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise BadInput(f"the file is larger than {MOST_BYTES // 2**20} MB")
        return path.read_bytes()
    except OSError as trouble:
        raise BadInput(f"it cannot be read: {trouble.strerror or trouble}") from None


def look(content: bytes) -> Header | None:
    """The first bytes → size and completeness; None for anything that is not a picture we read."""
    try:
        if content.startswith(b"\xff\xd8\xff"):
            return _jpeg(content)
        if content.startswith(PNG_HEAD) and content[12:16] == b"IHDR":
            width, height = struct.unpack(">II", content[16:24])
            return Header(width, height, b"IEND" in content[-MAX_TAIL_BYTES:], turned=False)
        if content.startswith(b"BM"):
            size, width, height = *struct.unpack("<I", content[2:6]), *struct.unpack("<ii", content[18:26])
            return Header(abs(width), abs(height), len(content) >= size, turned=False)
        if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
            return _webp(content)
        if content[:2] in (b"P2", b"P3", b"P5", b"P6"):
            return _pnm(content)
    except (struct.error, IndexError, ValueError):
        return None
    return None


def _jpeg(content: bytes) -> Header | None:
    """Walk the segments up to the pixels; after their end mark a telephone may add a film."""
    turned = False
    size: tuple[int, int] | None = None
    for marker, segment, at in _segments(content):
        if marker == 0xE1 and segment.startswith(b"Exif\0\0"):
            turned = _orientation(segment[6:]) not in (0, 1)
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", segment[1:5])
            size = width, height
        if marker == SCAN_MARKER and size is not None:
            return Header(*size, content.find(b"\xff\xd9", at) >= 0, turned)
    return None if size is None else Header(*size, complete=False, turned=turned)


def _segments(content: bytes) -> Iterator[tuple[int, bytes, int]]:
    """Markers, what they hold, and where that begins."""
    at = 2
    while at + 4 <= len(content):
        if content[at] != 0xFF:
            return
        marker = content[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        length = struct.unpack(">H", content[at + 2 : at + 4])[0]
        yield marker, content[at + 4 : at + 2 + length], at + 4
        at += 2 + length


def _orientation(tiff: bytes) -> int:
    """The EXIF block → its orientation, 0 where it has none."""
    order = "<" if tiff[:2] == b"II" else ">"
    start = struct.unpack(order + "I", tiff[4:8])[0]
    for entry in range(min(struct.unpack(order + "H", tiff[start : start + 2])[0], 200)):
        at = start + 2 + 12 * entry
        if struct.unpack(order + "H", tiff[at : at + 2])[0] == 0x0112:
            return int(struct.unpack(order + "H", tiff[at + 8 : at + 10])[0])
    return 0


def _webp(content: bytes) -> Header | None:
    complete = len(content) >= struct.unpack("<I", content[4:8])[0] + 8
    kind = content[12:16]
    if kind == b"VP8X":
        width, height = (int.from_bytes(content[at : at + 3], "little") + 1 for at in (24, 27))
    elif kind == b"VP8 ":
        width, height = (size & 0x3FFF for size in struct.unpack("<HH", content[26:30]))
    elif kind == b"VP8L":
        bits = int.from_bytes(content[21:25], "little")
        width, height = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    else:
        return None
    return Header(width, height, complete, turned=False)


def _pnm(content: bytes) -> Header:
    words: list[bytes] = []
    for line in content[:1024].splitlines():
        words += line.split(b"#")[0].split()
        if len(words) >= 4:
            break
    width, height = int(words[1]), int(words[2])
    needed = width * height * (3 if words[0] in (b"P3", b"P6") else 1)
    return Header(width, height, len(content) >= needed, turned=False)
