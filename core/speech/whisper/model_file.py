"""Read a model of CTranslate2 (`model.bin`, version 6) without trusting one length in it.

The file stays mapped: numbers in the file's own type are read where they lie, and take no memory of the process.

Little-endian: u32 version; string; u32 revision; u32 count; of each variable its name, u8 rank, u32 × rank shape,
u8 type, u32 bytes and the values; then u32 aliases, two strings each. A string is u16 length, bytes, a closing zero.
"""

import contextlib
import math
import mmap
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from core.errors import BadInput
from core.message import Array

SPEC_VERSION, SPEC_NAME = 6, "WhisperSpec"
TYPES: tuple[type[np.generic], ...] = (
    np.float32,
    np.int8,
    np.int16,
    np.int32,
    np.float16,
)  # by the number that the file uses
MOST_BYTES = 400_000_000  # a whisper-base.en has 145 MB
MOST_VARIABLES, MOST_RANK = 2_000, 3


@dataclass(frozen=True)
class Variable:
    """Place of the values of one variable in the file."""

    begin: int
    shape: tuple[int, ...]
    kind: type[np.generic]

    @property
    def size(self) -> int:
        """Bytes of all values."""
        return math.prod(self.shape) * np.dtype(self.kind).itemsize


class _Head:
    """The bytes of a file from its beginning; whatever reaches beyond its end raises BadInput."""

    def __init__(self, file: BinaryIO, name: str) -> None:
        self._file, self._name, self.at = file, name, 0
        self._length = file.seek(0, 2)
        file.seek(0)
        if self._length > MOST_BYTES:
            raise self.bad(f"it has more than {MOST_BYTES // 10**6} MB")

    def number(self, form: str) -> int:
        """Return the next unsigned number of a form of `struct`: "B", "H" or "I"."""
        return int(struct.unpack("<" + form, self._take(struct.calcsize("<" + form)))[0])

    def string(self) -> str:
        """Return the next string."""
        try:
            return self._take(self.number("H")).removesuffix(b"\0").decode()
        except UnicodeDecodeError:
            raise self.bad("a name in it is no text") from None

    def skip(self, count: int) -> None:
        """Go on behind the next bytes."""
        if count > self._length - self.at:
            raise self.bad("it ends too early")
        self.at += count
        self._file.seek(self.at)

    def bad(self, why: str) -> BadInput:
        """Return the error that says why the file cannot be used."""
        return BadInput(f"{self._name!r} is no usable speech model: {why}. Get the model again.")

    def _take(self, count: int) -> bytes:
        begin = self.at
        self.skip(count)
        self._file.seek(begin)
        return self._file.read(count)


class ModelFile:
    """The variables of a Whisper model by name. Only those that are asked for are read."""

    def __init__(self, path: Path) -> None:
        """Read the head of every variable. Raises BadInput."""
        self._path = path
        try:
            with path.open("rb") as file:
                self._variables = _variables(_Head(file, path.name))
                self._bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as trouble:
            raise BadInput(f"The speech model {path.name!r} cannot be read ({trouble.strerror}).") from None

    def rest(self) -> None:
        """Leave what was read to the system's cache of files, where the next reader finds it."""
        with contextlib.suppress(AttributeError, OSError):  # not on every system
            self._bytes.madvise(mmap.MADV_DONTNEED)

    def get(self, name: str, *shape: int | None) -> Array:
        """Return a variable as finite 32-bit floats; None in `shape`: any size. Raises BadInput."""
        return self._finite(name, self._raw(name, *shape).astype(np.float32))

    def get_compact(self, name: str, *shape: int | None) -> Array:
        """Return a variable as finite floats of the file's own type, to be read where they lie. Raises BadInput."""
        return self._finite(name, self._raw(name, *shape))

    def rows(self, name: str, rows: Array, *shape: int | None) -> Array:
        """Return some rows of a variable as finite 32-bit floats. Raises BadInput."""
        return self._finite(name, self._raw(name, *shape)[rows].astype(np.float32))

    def layers(self, part: str) -> int:
        """Return the number of layers of "encoder" or "decoder"."""
        count = 0
        while f"{part}/layer_{count}/self_attention/layer_norm/gamma" in self._variables:
            count += 1
        return count

    def _raw(self, name: str, *shape: int | None) -> Array:
        found = self._variables.get(name)
        if (
            found is None
            or len(found.shape) != len(shape)
            or any(want not in (None, has) for want, has in zip(shape, found.shape, strict=True))
            or found.kind not in (np.float16, np.float32)
        ):
            raise BadInput(
                f"{self._path.name!r} is no usable speech model: {name!r} is missing or has another shape or type. "
                "It must be an English-only Whisper model in float16 or float32."
            )
        if found.begin + found.size > len(self._bytes):
            raise BadInput(f"{self._path.name!r} changed while it was read. Try again.")
        return np.frombuffer(self._bytes, found.kind, math.prod(found.shape), found.begin).reshape(found.shape)

    def _finite(self, name: str, values: Array) -> Array:
        if not np.isfinite(values).all():
            raise BadInput(
                f"{self._path.name!r} is no usable speech model: {name!r} has numbers that are not finite."
            )
        return values


def _variables(head: _Head) -> dict[str, Variable]:
    version = head.number("I")
    if version != SPEC_VERSION or head.string() != SPEC_NAME:
        raise head.bad(f"it is no Whisper model of CTranslate2, version {SPEC_VERSION}")
    head.number("I")  # revision
    count = head.number("I")
    if count > MOST_VARIABLES:
        raise head.bad("it says that it has too many parts")
    return dict(_variable(head) for _ in range(count))


def _variable(head: _Head) -> tuple[str, Variable]:
    name, rank = head.string(), head.number("B")
    if rank > MOST_RANK:
        raise head.bad(f"{name[:60]!r} has too many dimensions")
    shape = tuple(head.number("I") for _ in range(rank))
    kind, size = head.number("B"), head.number("I")
    if kind >= len(TYPES):
        raise head.bad(f"{name[:60]!r} has numbers of an unknown type")
    variable = Variable(head.at, shape, TYPES[kind])
    if size != variable.size:
        raise head.bad(f"the shape of {name[:60]!r} does not fit its bytes")
    head.skip(size)
    return name, variable
