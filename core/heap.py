"""Memory that is given back. The C library keeps what was freed; where that is not glibc, nothing is done."""

import contextlib
import ctypes
from typing import Protocol, runtime_checkable

M_ARENA_MAX = -8  # of glibc's mallopt


@runtime_checkable
class Rests(Protocol):
    """An object that can do without most of its memory while nothing is asked of it."""

    def rest(self) -> None:
        """Give back what can be read again."""
        ...


def share_arenas() -> None:
    """Let all threads share two arenas: glibc keeps what each has freed in its own one, 27 MB after a single page."""
    with contextlib.suppress(AttributeError, TypeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 2)


def give_back() -> None:
    """Give what was freed back to the system, once a process has built what it works with: some milliseconds."""
    with contextlib.suppress(AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)
