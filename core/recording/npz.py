"""NumPy archives from unknown sources: named arrays are read with their true size checked first."""

import zipfile
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.lib import format as npy

from core.errors import BadInput
from core.message import Array
from core.recording.source import open_file

MAX_ARRAY_BYTES = 1_000_000_000  # of one array


class Archive:
    """An `.npz` file: its names at once, its arrays only when they are asked for."""

    def __init__(self, path: Path, largest: int):
        self.path = path
        self._file = open_file(path, largest)
        try:
            self._zip = zipfile.ZipFile(self._file)
        except Exception as problem:  # zipfile raises many kinds on damaged files
            self._file.close()
            raise BadInput(f"{path.name} is not a NumPy archive, or it is cut.") from problem

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    @property
    def names(self) -> set[str]:
        """The names of the arrays."""
        return {name.removesuffix(".npy") for name in self._zip.namelist()}

    @property
    def has_arrays(self) -> bool:
        """True where at least one of its files is an array."""
        return any(name.endswith(".npy") for name in self._zip.namelist())

    def floats(self, name: str, columns: int | None = None) -> Array:
        """The array of that name as float64: (N,), or (N, columns) where `columns` is given (0: any number).

        Raises BadInput when it is missing, damaged, of another shape, or not finite.
        """
        array = self._numbers(name)
        dimensions = 1 if columns is None else 2
        if array.ndim != dimensions or (columns and array.shape[1] != columns):
            wanted = "one column" if columns is None else f"{columns or 'several'} columns"
            raise BadInput(f"{name} in {self.path.name} has the shape {array.shape}; {wanted} are expected.")
        array = array.astype(np.float64)
        if not np.isfinite(array).all():
            raise BadInput(f"{name} in {self.path.name} has numbers that are not finite.")
        return array

    def _numbers(self, name: str) -> Array:
        try:
            entry = self._zip.getinfo(name + ".npy")
        except KeyError as problem:
            raise BadInput(f"{self.path.name} has no array {name}.") from problem
        try:
            with self._zip.open(entry) as stream:
                return self._checked(stream, entry.file_size)  # type: ignore[arg-type]
        except BadInput:
            raise
        except Exception as problem:  # zipfile, zlib and numpy raise many kinds on damaged files
            raise BadInput(f"{name} in {self.path.name} is damaged.") from problem

    def _checked(self, stream: BinaryIO, size: int) -> Array:
        """The array in the stream, whose header may not promise more than `size` bytes."""
        version = npy.read_magic(stream)
        if version not in ((1, 0), (2, 0)):
            raise ValueError("unknown version")
        read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, fortran, kind = read_header(stream)
        count = 1
        for length in shape:
            count *= length
        if (
            kind.kind not in "fiu"
            or min(shape, default=0) < 0
            or not 0 <= count * kind.itemsize <= min(size, MAX_ARRAY_BYTES)
        ):
            raise ValueError("not the numbers it promises")
        content = stream.read(count * kind.itemsize)
        return np.frombuffer(content, kind, count).reshape(shape, order="F" if fortran else "C")


def run_number(text: str, name: str) -> int:
    """The number after `#` of a path. Raises BadInput."""
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise BadInput(f"After # of {name} a number is expected, such as {name}#3.")
    return int(text)
